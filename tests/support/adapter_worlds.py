"""What an adapter's controller is wired to, where its terminals are not a 3601's [docs/adapter-tables.md]."""

from __future__ import annotations

from oracle_bits import CCW_LIMIT, CW_LIMIT, ESTOP, HOME
from oracle_world import World

ANY_LIMIT = CW_LIMIT | CCW_LIMIT
SHARED = HOME | CCW_LIMIT


class Diodes(World):
    """A PCL601's machine: the emergency stop is wired to both hard limits, too, which then tell nothing."""

    def levels(self):
        mask = super().levels()
        return mask & ~ANY_LIMIT if mask & ESTOP else mask


class SharedPin(World):
    """A PMC006's machine: home switch and CCW limit are one pin, which a search for home takes for home."""

    searching = False

    def levels(self):
        mask = super().levels()
        if mask & SHARED:
            mask |= SHARED
        return mask & ~CCW_LIMIT if self.searching else mask


WORLD = {"PCL601": Diodes, "PMC006": SharedPin}
