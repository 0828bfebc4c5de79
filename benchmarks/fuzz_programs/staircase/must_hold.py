from scanrack import never


@never
def below_zero(now):
    """The target is never below zero."""
    return now.tags["Target"] < 0
