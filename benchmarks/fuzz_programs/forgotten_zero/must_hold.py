from scanrack import never


@never
def unknown(now):
    """No absolute move begins where the position is not known."""
    return now.slot[1].status.COMMAND_ERROR
