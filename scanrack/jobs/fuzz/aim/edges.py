"""The scans with changes in a run, in groups. A search places its events near them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from itertools import pairwise
from random import Random

Group = dict[Hashable, list[int]]
"""The scans of each kind of change."""

COMMAND, STATE, THIN = "command", "state", "thin"

SIZE, PAIR, UNDER = "size", "pair", "under"
"""Groups that only show whether a run is new. No event is placed near their changes."""

INPUTS = ("status", "number")
"""Groups of the modules' responses."""

TOGETHER = "together"
"""Group of output words that change in the same scan. Only torn updates are placed there."""

NOT_AIMED = frozenset({SIZE, PAIR, UNDER, TOGETHER})
"""Groups without nearby events."""

NOT_NEW = frozenset({THIN, TOGETHER})
"""Groups that do not make a run new."""

PROGRAM_GROUPS = (COMMAND, "path", STATE)
"""Groups of changes in the program itself."""

THIN_SCANS = 3
"""Maximum duration of a thin state, scans."""

NEAR = (-8, -5, -3, -2, -1, -1, -1, 0, 0, 0, 1, 1, 1, 2, 3, 5, 8)
"""Distances of an event from an edge, scans. The program reads an event of scan n in scan n or n + 1.

An event before an edge disturbs an action that is about to end, such as the last steps of a move.
"""

SOON = 8
"""Number of preferred edges after an event."""

MOST_SCANS, MOST_KINDS = 200, 2_000
"""Maximum number of recorded scans per change, and of recorded changes per group."""

BEGINNING = 5
"""Number of scans after power-up without thin states, because every state would be thin there."""

MOST_STEPS = 4
"""Maximum number of small values if an integer also has large values; beyond it, it is a quantity."""


class Edges:
    """The changes in one run.

    A draw chooses a group, then a kind, then a scan. Therefore, a bit with one change is as likely to be
    chosen as a bit with a thousand changes.
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
        """Add the group of thin states at the end of the run.

        >>> edges = Edges()
        >>> for scan, step in ((0, 1), (90, 2), (92, 3), (500, 1)):
        ...     edges.add(STATE, step, scan)
        >>> edges.close()
        >>> edges.groups[THIN]
        {2: [90]}
        """
        state_by_scan: dict[int, Hashable] = {}
        quantities = self._quantities()
        for kind, scans in self.groups.get(STATE, {}).items():
            if _place_and_name(kind) not in quantities:
                for scan in scans:
                    state_by_scan.setdefault(scan, kind)
        change_scans = sorted(state_by_scan)
        for scan, next_scan in pairwise(change_scans):
            if next_scan - scan <= THIN_SCANS and scan > BEGINNING:
                self.add(THIN, state_by_scan[scan], scan)

    def _quantities(self) -> set[Hashable]:
        """Return the place and name of each integer that counts through its values, such as a position."""
        small_values = Counter(map(_place_and_name, self.groups.get(STATE, ())))
        with_large_values = set(map(_place_and_name, self.groups.get(SIZE, ())))
        return {integer for integer in with_large_values if small_values[integer] > MOST_STEPS}

    def firsts(self) -> dict[tuple[str, Hashable], int]:
        """Return the first scan of each change that may be new, by group and kind."""
        return {
            (group, kind): scans[0]
            for group, kinds in self.groups.items()
            if group not in NOT_NEW
            for kind, scans in kinds.items()
        }

    def one_of(self, random: Random, groups: Sequence[str]) -> int | None:
        """Return a random scan with a change in one of the groups; None if nothing changes."""
        filled_groups = [self.groups[name] for name in groups if name in self.groups]
        if not filled_groups:
            return None
        group = random.choice(filled_groups)
        return random.choice(group[random.choice(list(group))])

    def program_changes(self) -> set[tuple[str, Hashable]]:
        """Return the changes in the program itself."""
        return {(group, kind) for group in PROGRAM_GROUPS for kind in self.groups.get(group, ())}

    def output(self, random: Random) -> tuple[int, tuple[int, ...], int] | None:
        """Return a random change of several output words as (slot index, words, scan), or None."""
        kinds = self.groups.get(TOGETHER)
        if not kinds:
            return None
        kind = random.choice(list(kinds))
        assert isinstance(kind, tuple)
        return kind[0], kind[1], random.choice(kinds[kind])

    def near(self, random: Random, from_scan: int) -> int | None:
        """Return a random scan near an edge, preferably soon after scan `from_scan`; None without edges."""
        group_names = [name for name in self.groups if name not in NOT_AIMED]
        if not group_names:
            return None
        group = self.groups[random.choice(group_names)]
        scans = group[random.choice(list(group))]
        later_scans = [scan for scan in scans if scan >= from_scan - 2] or scans
        if random.random() < 0.6:
            later_scans = later_scans[:SOON]
        return random.choice(later_scans) + random.choice(NEAR)


def _place_and_name(kind: Hashable) -> Hashable:
    """Return the place and name of a changed value, without the value."""
    return kind[:2] if isinstance(kind, tuple) else kind


NO_EDGES = Edges()
"""The changes in a run without a probe."""
