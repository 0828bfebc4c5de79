from scanrack import never

STATIONS = (0, 1300, 2700)


@never
def elsewhere(now):
    """No move is complete where there is no station."""
    return now.slot[1].status.MOVE_COMPLETE and now.slot[1].position not in STATIONS
