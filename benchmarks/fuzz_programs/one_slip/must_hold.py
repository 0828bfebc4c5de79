from scanrack import never


@never
def forgotten(now):
    """No request is forgotten when both keys ask."""
    return now.tags["Forgotten"]
