from scanrack import never


@never
def lost(now):
    """A request is never forgotten in the scan in which it is made."""
    return now.tags["Key"] and not now.tags["Asked"]
