from scanrack import never


@never
def open_guard(now):
    """The saw never runs with its guard open."""
    return now.tags["Saw"] and not now.tags["Guard"]
