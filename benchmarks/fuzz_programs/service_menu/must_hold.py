from scanrack import never


@never
def opens(now):
    """The door opens only with the emergency stop in."""
    return now.tags["Door"] and not now.slot[1].status.IN_ESTOP
