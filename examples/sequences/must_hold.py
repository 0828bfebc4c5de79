"""What must hold of every program here, whatever happens: `scanrack fuzz stations.toml -i must_hold.py`."""

from scanrack import Snapshot, always, eventually, never


@always
def one_motion_command(now: Snapshot) -> object:
    """Never two motion commands at once to one module."""
    return all(slot.motions <= 1 for slot in now.slot.values())


@eventually("100 ms", after=lambda now: now.slot[1].status.IN_ESTOP)
def stands_still(now: Snapshot) -> object:
    """At most 100 ms from emergency stop to zero speed."""
    return not now.slot[1].moving


@never
def no_unready_command(now: Snapshot) -> object:
    """No command while the module is not configured."""
    return now.slot[1].status.CONFIG_ERROR and now.slot[1].motions
