"""A transition system: its states and their next values, and its free and held variables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence, Set
from contextlib import contextmanager
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any, NamedTuple

from ..algebra.terms import FALSE, TRUE, T, and_, variables_by_root
from ..relation.places import Key

Fact = tuple[frozenset[str], T]
"""The names of unknown values, and a condition on them that is true in each scan."""

DT = "~dt"
"""Name of the variable with the time since the previous scan, in units of `System.tick_ns`."""

WRITTEN = "~told:"
"""Name prefix of a variable with the bits written into a number from outside before the next scan."""

FIRST_SCAN = ("S:FS", 0)

TURNED = "~turned"
"""Name of the variable that is true after a scan if the key is turned to program and back."""

RETAINED = "~retained"
"""Name of the variable that is true after a scan if the run ends and the next run begins with its tags."""

BEGUN = "~begun"
"""Name of the state that is true in the first scan with retained tags: no time has passed before it."""

THEN = "~then:"
"""Name prefix of a variable that prescan reads instead of a value that is written from outside."""

OFF = "~off"
"""Name of the variable with the time in program mode, in units of `System.tick_ns`."""

STOPPED = "~stopped"
"""Name of the state that is true after a major fault has stopped the processor, so that no scan follows."""


class HeldNumber(NamedTuple):
    """A number, or one bit of it, with the value that a proof assumes."""

    key: Key
    bit: int | None
    value: Any

    def named(self, tag: str) -> str:
        """Return the name of the number or bit, given the name of its tag."""
        return tag if self.bit is None else f"{tag}.{self.bit}"


MS = 1_000_000
"""Nanoseconds in a millisecond."""


@dataclass(frozen=True, slots=True)
class ScanBounds:
    """Minimum and maximum time between two scans, in ms; both are multiples of a unit, in ns.

    Raises:
        ValueError: the times are not 0 <= low <= high with high > 0, exceed a day, or are not multiples of
            the unit.
    """

    low_ms: float = 1
    high_ms: float = 1000
    tick_ns: int = MS

    def __post_init__(self) -> None:
        if not 0 <= self.low_ms <= self.high_ms <= 86_400_000 or self.high_ms == 0:
            raise ValueError(
                f"scan time from {self.low_ms} to {self.high_ms} ms; must be 1 ms to a day, least first"
            )
        if MS % self.tick_ns or any(
            round(bound * MS) % self.tick_ns for bound in (self.low_ms, self.high_ms)
        ):
            raise ValueError(
                f"scan time from {self.low_ms} to {self.high_ms} ms; must be multiples of {self.tick_ns} ns"
            )

    @classmethod
    def of(cls, low_ms: float, high_ms: float, *others_ns: int) -> ScanBounds:
        """Return bounds whose unit is the greatest common divisor of both times, 1 ms, and the other times.

        >>> ScanBounds.of(2.5, 10)
        ScanBounds(low_ms=2.5, high_ms=10, tick_ns=500000)
        """
        return cls(low_ms, high_ms, math.gcd(MS, round(low_ms * MS), round(high_ms * MS), *others_ns))

    @property
    def ticks(self) -> tuple[int, int]:
        """Minimum and maximum time, in units."""
        low, high = (round(bound * MS) // self.tick_ns for bound in (self.low_ms, self.high_ms))
        return low, high

    @property
    def steps_text(self) -> str:
        """The unit as text; "" if both times are equal."""
        if self.low_ms == self.high_ms:
            return ""
        return ", in whole ms" if self.tick_ns == MS else f", in steps of {self.tick_ns / MS:g} ms"


def ms_of(ticks: int, tick_ns: int) -> float:
    """Return a time in ms, as an int if it is whole.

    >>> ms_of(3, 1_000_000), ms_of(5, 500_000)
    (3, 2.5)
    """
    time_ns = ticks * tick_ns
    return time_ns / MS if time_ns % MS else time_ns // MS


@dataclass(slots=True)
class System:
    """A transition system.

    Attributes:
        next: each state's term after a scan, by the name of its variable.
        initial: initial values of states, held variables and late variables.
        held: names of variables that keep their initial value.
        late: names of free variables that have their initial value in the first scan.
        contract: a condition on each scan; runs that break it are not considered.
        kept: contracts of modules; each matters only to terms that its module's inputs decide, see
            `narrowed`.
        facts: conditions on two unknown values that are true in each scan, with the values' names; see
            `narrowed`.
        deep: the condition under which the relation does not follow the program.
        unmodeled: variables for values that are not modeled, with the instructions that cause them.
        key_of: the places of variables, by name.
        likely: frequent values of free variables in random scans, by variable name.
        least: minimum time between scans, in units of `tick_ns`.
        follows: the verdict on whether `deep` is never true; None until it is decided.
        invariants: the invariants found so far, with their work, by contract and cone.
        variables_known: cache of the variables in terms, see `cone`.
    """

    next: dict[str, T] = field(default_factory=dict)
    initial: dict[str, Any] = field(default_factory=dict)
    held: set[str] = field(default_factory=set)
    late: set[str] = field(default_factory=set)
    contract: T = TRUE
    kept: list[T] = field(default_factory=list)
    facts: list[Fact] = field(default_factory=list)
    deep: T = FALSE
    unmodeled: dict[str, str] = field(default_factory=dict)
    key_of: dict[str, Key] = field(default_factory=dict)
    likely: dict[str, Sequence[int]] = field(default_factory=dict)
    least: int = 1
    tick_ns: int = MS
    follows: Any = None
    invariants: dict[tuple[T, frozenset[str]], Any] = field(default_factory=dict)
    variables_known: dict[T, list[T]] = field(default_factory=dict)

    def role(self, name: str) -> str:
        """Return the role of a variable: `state`, `held` or `free`."""
        if name in self.next:
            return "state"
        return "held" if name in self.held else "free"

    def cone(self, roots: Iterable[T]) -> dict[str, T]:
        """Return the variables that terms depend on over any number of scans, the most direct ones first."""
        found: dict[str, T] = {}
        open_terms = [*roots, *([] if self.contract is TRUE else [self.contract])]
        while open_terms:
            fresh = [variable for variable in self._variables(open_terms) if variable.val not in found]
            found.update((variable.val, variable) for variable in fresh)
            open_terms = [self.next[variable.val] for variable in fresh if variable.val in self.next]
        return found

    def _variables(self, terms: Sequence[T]) -> list[T]:
        """Return the variables in terms, as `variables` does, without walking any term twice."""
        cache = self.variables_known
        cache.update(variables_by_root([term for term in terms if term not in cache]))
        return sorted({variable for term in terms for variable in cache[term]}, key=attrgetter("id"))

    def narrowed(self, roots: Iterable[T]) -> T:
        """Return the contract, with the module contracts and facts that matter to terms.

        A module's contract matters if the terms depend on its inputs. A fact matters if the terms depend on
        both of its unknown values.
        """
        roots, contract = list(roots), self.contract
        remaining: list[T | Fact] = [*self.kept, *self.facts]
        while True:
            inputs = {name for name in self.cone([*roots, contract]) if self.role(name) == "free"}
            relevant = [candidate for candidate in remaining if self._matters(candidate, inputs)]
            if not relevant:
                return contract
            remaining = [candidate for candidate in remaining if candidate not in relevant]
            for part in relevant:
                contract = and_(contract, part[1] if isinstance(part, tuple) else part)

    def _matters(self, condition: T | Fact, inputs: Set[str]) -> bool:
        """Return whether a module's contract, or a fact, matters to terms that depend on some inputs."""
        if isinstance(condition, tuple):
            return condition[0] <= inputs
        return any(variable.val in inputs for variable in self._variables([condition]))

    @contextmanager
    def narrowing(self, roots: Iterable[T]) -> Iterator[None]:
        """Use the contract that `narrowed` returns for terms in the body of the `with` statement."""
        contract, self.contract = self.contract, self.narrowed(roots)
        try:
            yield
        finally:
            self.contract = contract

    def blame(self, cone: Iterable[str]) -> tuple[str, ...]:
        """Return the unmodeled instructions that affect a cone."""
        return tuple(dict.fromkeys(self.unmodeled[name] for name in cone if name in self.unmodeled))

    def held_numbers(self, cone: Iterable[str], roots: Sequence[T]) -> tuple[HeldNumber, ...]:
        """Return the numbers that terms and their cone read and that nothing writes.

        None here, because a bare system does not know its writers; the system of a program overrides this.
        """
        return ()

    def limits_met(self) -> tuple[str, ...]:
        """Return the places where the relation does not follow the program."""
        return ("a loop or call beyond the limits",)


def shown(name: str) -> str:
    """Return a variable's name as a user writes it: with a subscript only for an array's element."""
    return name.removesuffix("[0]")
