from scanrack import never


@never
def both(now):
    """Never both axes on their way."""
    return now.tags["GoX"] and now.tags["GoY"]
