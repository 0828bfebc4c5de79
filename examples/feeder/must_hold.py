"""What must hold of the feeder, whatever happens around it: `scanrack fuzz feeder.toml -i must_hold.py`."""

from scanrack import Snapshot, always, eventually, never


@never
def two_strokes_at_once(now: Snapshot) -> object:
    """The two strokes are never asked for together."""
    return now.tags["OutGo"] and now.tags["BackGo"]


@always
def one_motion_command(now: Snapshot) -> object:
    """Never two motion commands at once."""
    return now.slot[1].motions <= 1


@eventually("100 ms", after=lambda now: now.slot[1].status.IN_ESTOP)
def stands_still(now: Snapshot) -> object:
    """At most 100 ms from emergency stop to zero speed."""
    return not now.slot[1].moving


@never
def command_error(now: Snapshot) -> object:
    """No COMMAND_ERROR ever."""
    return now.slot[1].status.COMMAND_ERROR
