"""What must hold of the shared zone, besides: `scanrack fuzz shared_zone.toml -i zone_must_hold.py`."""

from scanrack import Snapshot, never


@never
def both_move(now: Snapshot) -> object:
    """Never both axes in motion: one that moves has the zone."""
    return now.slot[1].moving and now.slot[3].moving
