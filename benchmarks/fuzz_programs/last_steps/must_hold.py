from scanrack import never


@never
def stamps_elsewhere(now):
    """The stamp falls only where the move is complete."""
    return now.tags["Stamp"] and not now.tags["Arrived"]
