"""The scans of a run in which something changed, in groups: a search aims its events at them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from itertools import pairwise
from random import Random

Group = dict[Hashable, list[int]]
"""The scans of each kind of change."""

COMMAND, STATE, THIN = "command", "state", "thin"

SIZE, PAIR, UNDER = "size", "pair", "under"
"""Groups that only show that a run is new: no event is aimed at them."""

INPUTS = ("status", "number")
"""Groups of the modules' responses."""

TOGETHER = "together"
"""Group of the output words that change in one scan: only torn updates are aimed at them."""

NOT_AIMED, NOT_NEW = frozenset({SIZE, PAIR, UNDER, TOGETHER}), frozenset({THIN, TOGETHER})

ANSWERS = (COMMAND, "path", STATE)
"""Groups of changes in the program itself."""

THIN_SCANS = 3
"""Longest duration of a thin state, scans."""

NEAR = (-8, -5, -3, -2, -1, -1, -1, 0, 0, 0, 1, 1, 1, 2, 3, 5, 8)
"""Distances from an edge, scans. The program sees an event of scan n in scan n or n + 1, and reacts later.

Negative distances hit something that ends, such as the last steps of a move.
"""

SOON = 8
"""Number of preferred edges after an event."""

MOST_SCANS, MOST_KINDS = 200, 2_000
"""Largest number of scans of one change, and of changes in one group: the first ones."""

BEGINNING = 5
"""Scans after power-up in which every state is thin."""

MOST_STEPS = 4
"""An integer with large values and more small values than this is a quantity, not a step."""


class Edges:
    """The changes in one run.

    A draw chooses a group first, then a kind, then a scan: a bit that changed once is as likely as one that
    changed a thousand times.
    """

    def __init__(self) -> None:
        self.groups: dict[str, Group] = {}

    def add(self, group: str, kind: Hashable, scan: int) -> None:
        """Record a change."""
        kinds = self.groups.setdefault(group, {})
        scans = kinds.get(kind)
        if scans is not None:
            if len(scans) < MOST_SCANS:
                scans.append(scan)
        elif len(kinds) < MOST_KINDS:
            kinds[kind] = [scan]

    def close(self) -> None:
        """Add the group of thin states after the run.

        >>> edges = Edges()
        >>> for scan, step in ((0, 1), (90, 2), (92, 3), (500, 1)):
        ...     edges.add(STATE, step, scan)
        >>> edges.close()
        >>> edges.groups[THIN]
        {2: [90]}
        """
        by_scan: dict[int, Hashable] = {}
        quantities = self._quantities()
        for kind, scans in self.groups.get(STATE, {}).items():
            if _tag(kind) not in quantities:
                for scan in scans:
                    by_scan.setdefault(scan, kind)
        ordered = sorted(by_scan)
        for scan, end in pairwise(ordered):
            if end - scan <= THIN_SCANS and scan > BEGINNING:
                self.add(THIN, by_scan[scan], scan)

    def _quantities(self) -> set[Hashable]:
        """Return the place and name of each integer that runs through its values, such as a position."""
        small = Counter(_tag(kind) for kind in self.groups.get(STATE, ()))
        return {tag for kind in self.groups.get(SIZE, ()) if small[tag := _tag(kind)] > MOST_STEPS}

    def firsts(self) -> dict[tuple[str, Hashable], int]:
        """Return the first scan of each change that may be new, by group and kind."""
        return {
            (group, kind): scans[0]
            for group, kinds in self.groups.items()
            if group not in NOT_NEW
            for kind, scans in kinds.items()
        }

    def one_of(self, random: Random, groups: Sequence[str]) -> int | None:
        """Return a random scan of a change in one of the groups; None if they have no changes."""
        filled_groups = [self.groups[name] for name in groups if name in self.groups]
        if not filled_groups:
            return None
        group = random.choice(filled_groups)
        return random.choice(group[random.choice(list(group))])

    def answers(self) -> set[tuple[str, Hashable]]:
        """Return the changes in the program itself."""
        return {(group, kind) for group in ANSWERS for kind in self.groups.get(group, ())}

    def output(self, random: Random) -> tuple[int, tuple[int, ...], int] | None:
        """Return a change of several output words: the slot's place, the words, the scan; None if none."""
        kinds = self.groups.get(TOGETHER)
        if not kinds:
            return None
        kind = random.choice(list(kinds))
        assert isinstance(kind, tuple)
        return kind[0], kind[1], random.choice(kinds[kind])

    def near(self, random: Random, first: int) -> int | None:
        """Return a random scan near an edge, preferably soon after the scan `first`; None without edges."""
        aimed = [name for name in self.groups if name not in NOT_AIMED]
        if not aimed:
            return None
        group = self.groups[random.choice(aimed)]
        scans = group[random.choice(list(group))]
        later = [scan for scan in scans if scan >= first - 2] or scans
        return random.choice(later[:SOON] if random.random() < 0.6 else later) + random.choice(NEAR)


def _tag(kind: Hashable) -> Hashable:
    return kind[:2] if isinstance(kind, tuple) else kind


NO_EDGES = Edges()
"""The changes when a run has no probe."""
