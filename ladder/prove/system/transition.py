"""A transition system: which values are state, what they become, which are free or held."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ..algebra.terms import FALSE, TRUE, T, and_, variables

Key = tuple[str, int]
"""A place: path of the leaf in capitals, flat index."""

CLOCK = "~LAST_NS"
"""End of the path of a hidden member whose term is the ms since an instant."""

DT = "~dt"
"""Name of the variable with the ms since the scan before."""

TOLD = "~told:"
"""Start of the name of a variable whose bits someone outside writes into a number before the next scan."""

FIRST_SCAN = ("S:FS", 0)

TURNED = "~turned"
"""Name of the variable that says, behind a scan, that the key is turned to program and back."""

RETAINED = "~retained"
"""Name of the variable that says, behind a scan, that the run ends and the next one begins with its tags."""

BEGUN = "~begun"
"""Name of the state that says that a scan is the first with retained tags: no time has passed before it."""

THEN = "~then:"
"""Start of the name of a variable that prescan reads in place of a value that may be written from outside."""

OFF = "~off"
"""Name of the variable with the ms that this takes."""


class HeldNumber(NamedTuple):
    """A number, or one bit of it, with the value that a proof assumes."""

    key: Key
    bit: int | None
    value: Any

    def named(self, tag: str) -> str:
        """Return its name, of the name of its tag."""
        return tag if self.bit is None else f"{tag}.{self.bit}"


@dataclass(frozen=True, slots=True)
class ScanBounds:
    """Least and most time between two scans, ms; `whole` if it is always whole ms.

    With parts of a ms the bounds are cut off: 2.5 to 10.2 ms are 2 to 10, and each timer may count one more.

    Raises:
        ValueError: not 0 < low <= high, or more than a day.
    """

    low_ms: int = 1
    high_ms: int = 1000
    whole: bool = True

    def __post_init__(self) -> None:
        if not 0 <= self.low_ms <= self.high_ms <= 86_400_000 or self.high_ms == 0:
            raise ValueError(
                f"scan time from {self.low_ms} to {self.high_ms} ms; must be 1 ms to a day, least first"
            )

    @classmethod
    def of(cls, low_ms: float, high_ms: float) -> ScanBounds:
        """Return bounds of times that need not be whole.

        >>> ScanBounds.of(2.5, 10)
        ScanBounds(low_ms=2, high_ms=10, whole=False)
        """
        whole = float(low_ms).is_integer() and float(high_ms).is_integer()
        return cls(math.floor(low_ms), math.floor(high_ms), whole)

    def done(self, ms: int) -> int:
        """Return the whole ms that a run has for a scan time of the solver: within the bounds, if any is."""
        return ms if self.whole else min(self.high_ms, max(ms, self.low_ms + 1))


@dataclass(slots=True)
class System:
    """States, their next values, and what else decides them.

    Attributes:
        next: the term after a scan of each state, by the name of its variable.
        initial: values of states and held values, and of free ones that the first scan finds unchanged.
        held: names of variables that keep their initial value.
        late: names of free variables that have their initial value in the first scan.
        contract: what holds in each scan of a run in question.
        kept: contracts of modules; each counts for what its module's inputs decide, see `narrowed`.
        deep: where the relation does not follow the program.
        havocs: variables of what is not modeled, and what to blame.
        key_of: the place of each variable that has one.
        likely: values that random scans give a free variable often, by its name.
        least_ms: least time between scans.
        follows: the verdict whether `deep` never holds; None before it is known.
        invariants: found so far, with their work, by contract and cone.
    """

    next: dict[str, T] = field(default_factory=dict)
    initial: dict[str, Any] = field(default_factory=dict)
    held: set[str] = field(default_factory=set)
    late: set[str] = field(default_factory=set)
    contract: T = TRUE
    kept: list[T] = field(default_factory=list)
    deep: T = FALSE
    havocs: dict[str, str] = field(default_factory=dict)
    key_of: dict[str, Key] = field(default_factory=dict)
    likely: dict[str, Sequence[int]] = field(default_factory=dict)
    least_ms: int = 1
    follows: Any = None
    invariants: dict[tuple[T, tuple[str, ...]], Any] = field(default_factory=dict)

    def role(self, name: str) -> str:
        """`state`, `held`, or `free`."""
        return "state" if name in self.next else "held" if name in self.held else "free"

    def cone(self, roots: Iterable[T]) -> dict[str, T]:
        """Return the variables that decide terms in any number of scans, the nearest first."""
        seen: dict[str, T] = {}
        todo = [*roots, *([] if self.contract is TRUE else [self.contract])]
        while todo:
            fresh = [v for v in variables(todo) if v.val not in seen]
            seen.update((v.val, v) for v in fresh)
            todo = [self.next[v.val] for v in fresh if v.val in self.next]
        return seen

    def narrowed(self, roots: Iterable[T]) -> T:
        """Return the contract with those of modules whose inputs decide terms."""
        roots, contract, left = list(roots), self.contract, [*self.kept]
        while True:
            inputs = {name for name in self.cone([*roots, contract]) if self.role(name) == "free"}
            counts = [each for each in left if any(v.val in inputs for v in variables([each]))]
            if not counts:
                return contract
            left = [each for each in left if each not in counts]
            for each in counts:
                contract = and_(contract, each)

    def blame(self, cone: Iterable[str]) -> tuple[str, ...]:
        """Return the instructions that are not modeled and decide a cone."""
        return tuple(dict.fromkeys(self.havocs[name] for name in cone if name in self.havocs))

    def held_numbers(self, cone: Iterable[str], roots: Sequence[T]) -> tuple[HeldNumber, ...]:
        """Return what is held of a program and decides terms."""
        return ()

    def limits_met(self) -> tuple[str, ...]:
        """Return where the relation does not follow the program."""
        return ("a loop or call beyond the limits",)


def name_of(key: Key) -> str:
    """Return the name of a place's variable."""
    return f"{key[0]}[{key[1]}]"


def shown(name: str) -> str:
    """Return a variable's name as a person writes it: without the subscript of what has none."""
    return name.removesuffix("[0]")
