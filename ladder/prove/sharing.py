"""Finds unknown values that are equal in two programs, and relates the others.

Each unknown value is the value of a function, see `relation.unknowns`. If the same function has the same
terms as arguments in both programs, the programs share one value. For any other pair of values of one
function, equal arguments imply equal values (Ackermann's expansion). For a strict function, only the first
rule applies, and only if every term that its arguments depend on is the same in both programs.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass, field

from .algebra.numbers import same
from .algebra.terms import FALSE, TRUE, T, all_of, not_, or_, var
from .relation.unknowns import UnknownOrigin
from .system import ProgramSystem

NEW = "~new:"
"""Name prefix of variables that only the new program has."""

MOST_PAIRS = 24
"""Maximum number of old unknown values that each new one is compared with."""

InNew = Callable[[T], T]
"""Returns a term of the new program with its own variables replaced by shared ones."""


def own(v: T) -> T:
    """Return the new program's own variable for a variable that can't be shared."""
    return var(NEW + v.val, v.kind, v.lo, v.hi)


@dataclass(slots=True)
class SharedUnknowns:
    """The unknown values of two programs.

    Attributes:
        known: the origin of each variable, by name, with arguments in the shared variables.
        facts: conditions that are true in each scan (equal arguments imply equal values), with the names of
            the two values.
        shared: names of the old program's variables that the new one shares.
    """

    old: ProgramSystem
    new: ProgramSystem
    known: dict[str, UnknownOrigin] = field(default_factory=dict)
    facts: list[tuple[frozenset[str], T]] = field(default_factory=list)
    shared: set[str] = field(default_factory=set)

    def match(self, own_of: dict[str, T], in_new: InNew, unshared: set[str]) -> None:
        """Choose a variable for each unknown value of the new program; fill the attributes.

        Args:
            own_of: filled with the variables, by their names in the new program.
            in_new: replaces the variables of a term according to `own_of`.
            unshared: names of unshared variables of strict functions.
        """
        self.known, self.facts, self.shared = {}, [], set()
        by_function: dict[Hashable, list[tuple[T, UnknownOrigin]]] = defaultdict(list)
        for variable, origin in _in_order(self.old):
            self.known[variable.val] = origin
            if origin.function is not None:
                by_function[origin.function].append((variable, origin))
        for variable, origin in _in_order(self.new):
            new = origin._replace(
                arguments={name: in_new(argument) for name, argument in origin.arguments.items()}
            )
            pairs = by_function.get(new.function, []) if new.function is not None else []
            twin = next(
                (
                    old
                    for old, old_origin in pairs
                    if _has_same_arguments(new, old_origin) and old.val not in unshared
                ),
                None,
            )
            if twin is not None:
                own_of[variable.val] = twin
                self.shared.add(twin.val)
                continue
            apart = own_of[variable.val] = own(variable)
            self.known[apart.val] = new
            for partner, old_origin in pairs[:MOST_PAIRS] if not new.strict else ():
                fact = or_(not_(_arguments_equal(new, old_origin)), same(partner, apart))
                if fact is not TRUE:
                    self.facts.append((frozenset((partner.val, apart.val)), fact))

    def strict(self) -> Iterable[str]:
        """Return the shared variables of strict functions."""
        return [name for name in self.shared if self.known[name].strict]


def _in_order(problem: ProgramSystem) -> list[tuple[T, UnknownOrigin]]:
    """Return the unknown values of a program; each value comes after those its arguments depend on."""
    return sorted(problem.machine.origins.items(), key=lambda each: int(each[0].val[1:]))


def _has_same_arguments(new: UnknownOrigin, old: UnknownOrigin) -> bool:
    new_arguments, old_arguments = new.arguments, old.arguments
    return new_arguments.keys() == old_arguments.keys() and all(
        old_arguments[name] is argument for name, argument in new_arguments.items()
    )


def _arguments_equal(new: UnknownOrigin, old: UnknownOrigin) -> T:
    """Return the condition that all arguments are equal, or FALSE if their names or kinds differ."""
    new_arguments, old_arguments = new.arguments, old.arguments
    if new_arguments.keys() != old_arguments.keys() or any(
        old_arguments[name].kind != argument.kind for name, argument in new_arguments.items()
    ):
        return FALSE
    return all_of(same(argument, old_arguments[name]) for name, argument in new_arguments.items())


def deciding(known: Mapping[str, UnknownOrigin], name: str) -> Iterable[T]:
    """Return the terms that an unknown value depends on, or () if the name belongs to another variable."""
    origin = known.get(name)
    return () if origin is None else origin.arguments.values()
