"""Finds the smallest input changes that set a tag to a value, by running scans with them.

Sets of one input are tried first, then sets of two and three. For a number, bisection finds the closest value
that works.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations, product
from typing import Any

from scanrack.io_images.dataclass import dataclass

from ..model.arithmetic import real
from ..state.memory import Value
from .watched import shown

MOST_INPUTS = 3
"""Maximum number of inputs in a set."""

MOST_TRIES = 3_000
"""Maximum number of sets to try."""

MOST_CANDIDATES = 64
"""Maximum number of inputs to try, beginning with the inputs nearest to the tag."""

MOST_VALUES = 12
"""Maximum number of values to try for a number, beginning with the values nearest to the current one."""


@dataclass(frozen=True, slots=True)
class InputChange:
    """An input and its new value."""

    cell: Any  # the place in memory
    name: str
    place: str  # the place in the rack, such as `slot 2 input 3`; "" for a tag
    value: Value

    def __str__(self) -> str:
        place = f" ({self.place})" if self.place else ""
        verb = ("goes off", "comes on")[self.value] if isinstance(self.value, bool) else _becomes(self.value)
        return f"{self.name}{place} {verb}"


def _becomes(value: Value) -> str:
    return f"becomes {value:.9g}" if isinstance(value, float) else f"becomes {value}"


@dataclass(frozen=True, slots=True)
class Candidate:
    """An input, its current value, and the other values to try."""

    cell: Any
    name: str
    place: str
    current: Value
    alternatives: tuple[Value, ...]

    def change(self, value: Value) -> InputChange:
        """Return the change of the input to a value."""
        return InputChange(self.cell, self.name, self.place, value)


def bit(cell: Any, name: str, place: str, current: bool) -> Candidate:
    """Return a bit as a candidate."""
    return Candidate(cell, name, place, current, (not current,))


def number(
    cell: Any, name: str, place: str, current: float, limits: tuple[float, float], compared: Iterable[float]
) -> Candidate:
    """Return a number within limits as a candidate.

    Args:
        compared: constants in the program; values near them are tried, and so are the limits.
    """
    low, high = limits
    near = {value + offset for value in compared for offset in (-1, 0, 1)}
    kind = type(current)
    tried = sorted(
        {kind(value) for value in near if low <= value <= high} - {current},
        key=lambda value: abs(value - current),
    )
    far = [kind(bound) for bound in (high, low) if bound != current]
    return Candidate(cell, name, place, current, tuple(dict.fromkeys([*tried[:MOST_VALUES], *far])))


@dataclass(frozen=True, slots=True)
class Remedy:
    """A set of input changes that produces the value; empty if no input needs to change."""

    changes: tuple[InputChange, ...]
    scans: int  # number of scans until the tag has the value


@dataclass(frozen=True, slots=True)
class Remedies:
    """The sets of inputs that were found for a tag.

    Attributes:
        tried: number of sets that were tried.
        left: whether any sets are left untried.
        terminal: the terminal of an input; "" for other values of a module, None for a tag that is not an
            input.
    """

    tag: str
    requested: Value
    found: tuple[Remedy, ...]
    candidates: tuple[str, ...]
    tried: int
    left: bool
    terminal: str | None = None

    def __str__(self) -> str:
        """Return a line for each set, or the reason why there is none."""
        if self.found:
            is_bit = isinstance(self.requested, bool)
            verb = ("goes off", "comes on")[int(self.requested)] if is_bit else f"becomes {self.requested}"
            return "\n".join(f"{self.tag} {verb} {_condition(remedy)}" for remedy in self.found)
        if self.terminal:
            hint = "switch it there (timeline of the rack file, a button of the page, set_input of a bench)"
            return f"{self.tag} is itself an input, {self.terminal}: {hint}, or force it"
        if self.terminal is not None:
            return f"{self.tag} is a value that a module reports: let the module report it, or force it"
        if not self.candidates:
            return f"{self.tag} depends on no input"
        sets = f"none of the first {self.tried} sets" if self.left else f"no set of up to {MOST_INPUTS}"
        inputs = ", ".join(self.candidates)
        return f"{self.tag}: {sets} of its inputs sets it to {shown(self.requested)}: {inputs}"

    def as_json(self) -> dict[str, Any]:
        """Return the answer as JSON values."""
        sets = [
            {
                "scans": remedy.scans,
                "inputs": [
                    {"name": change.name, "place": change.place, "value": change.value}
                    for change in remedy.changes
                ],
            }
            for remedy in self.found
        ]
        return {"wanted": self.requested, "sets": sets, "tried": self.tried, "complete": not self.left}


def of_input(tag: str, requested: Value, terminal: str | None) -> Remedies:
    """Return the answer for a tag that is itself an input, which the program does not write.

    Args:
        terminal: its terminal; None for other values of a module.
    """
    return Remedies(tag, requested, (), (), 0, left=False, terminal=terminal or "")


Attempt = Callable[[Sequence[InputChange]], int | None]
"""Runs scans with changed inputs; returns the number of scans until the tag had the value, or None."""


@dataclass(slots=True)
class Search:
    """Searches sets of inputs for a value.

    Args:
        tag: the name of the value.
    """

    tag: str
    requested: Value
    attempt: Attempt
    tried: int = 0

    def among(self, candidates: Sequence[Candidate]) -> Remedies:
        """Return the smallest sets of inputs that work; no set contains another set."""
        remedies: list[Remedy] = []
        names = tuple(candidate.name for candidate in candidates)
        for size in range(MOST_INPUTS + 1):
            for chosen in combinations(candidates, size):
                chosen_names = {candidate.name for candidate in chosen}
                if any({change.name for change in remedy.changes} <= chosen_names for remedy in remedies):
                    continue
                if self.tried >= MOST_TRIES:
                    return Remedies(self.tag, self.requested, tuple(remedies), names, self.tried, left=True)
                remedies += self._with(chosen)
        return Remedies(self.tag, self.requested, tuple(remedies), names, self.tried, left=False)

    def _with(self, chosen: Sequence[Candidate]) -> Iterator[Remedy]:
        """Yield the first combination of values that works, if any."""
        for values in product(*(candidate.alternatives for candidate in chosen)):
            changes = [candidate.change(value) for candidate, value in zip(chosen, values, strict=True)]
            scans = self._try(changes)
            if scans is not None:
                yield self._nearest(chosen, changes, scans)
                return

    def _try(self, changes: Sequence[InputChange]) -> int | None:
        """Run scans with changed inputs, and count the try; return the number of scans, or None."""
        self.tried += 1
        return self.attempt(changes)

    def _nearest(self, chosen: Sequence[Candidate], changes: list[InputChange], scans: int) -> Remedy:
        """Return a remedy with numbers as close to their current values as possible."""
        for index, candidate in enumerate(chosen):
            if isinstance(candidate.current, bool):
                continue
            failing, working = candidate.current, changes[index].value
            while (middle := _between(failing, working)) is not None:
                nearer = [*changes[:index], replace(changes[index], value=middle), *changes[index + 1 :]]
                tried_scans = self._try(nearer)
                if tried_scans is None:
                    failing = middle
                else:
                    working, changes, scans = middle, nearer, tried_scans
        return Remedy(tuple(changes), scans)


def _between(a: Value, b: Value) -> Value | None:
    """Return the number halfway between two numbers; None if they are adjacent."""
    if isinstance(a, float):
        middle: Value = real((a + b) / 2)
    else:
        middle = (int(a) + int(b)) // 2
    return None if middle in (a, b) else middle


def _condition(remedy: Remedy) -> str:
    """Return a remedy as text: its changes, and the number of scans if it takes several."""
    after = "" if remedy.scans == 1 else f", after {remedy.scans} scans"
    if not remedy.changes:
        return f"by itself{after}"
    return f"if {' and '.join(map(str, remedy.changes))}{after}"
