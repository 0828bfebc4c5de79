from scanrack import never


@never
def twice(now):
    """No two bottles within 30 ms."""
    return now.tags["Twice"]
