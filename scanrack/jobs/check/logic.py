"""Conditions of a program in any language: whether one can hold, and whether it always holds.

    XIC(A)XIO(A)                  never: A is on and off
    GRT(Level,10)LES(Level,5)     never: Level is above 10 and below 5
    GRT(Count,40000)              never, if Count is an INT
    [XIC(A),XIO(A)]               always

A condition is split into alternatives, each of parts that hold together. With more than `MOST` alternatives
the answer is no.
A bit has one value within a condition: readers rename a bit once the program has written it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice

MOST = 128
"""Maximum number of alternatives of a condition."""

MOST_PARTS = 128
"""Maximum number of parts of a condition; further parts are unknown. The time grows with their square."""

ON_DELAY = "t"
"""Suffix in the names of on-delay timer bits: DN and TT exclude each other [1756-RM003, TON]."""

INPUT = "in "
"""Prefix in the names of card inputs, which people and sensors set. Any of them may be on together."""

OPPOSITE = {"=": "<>", "<>": "=", "<": ">=", ">=": "<", ">": "<=", "<=": ">"}
"""The opposite of each relation."""

MIRRORED = {"=": "=", "<>": "<>", "<": ">", ">": "<", "<=": ">=", ">=": "<="}
"""Each relation with its sides exchanged."""


@dataclass(frozen=True, slots=True)
class FixedTruth:
    """A constant truth value."""

    holds: bool


@dataclass(frozen=True, slots=True)
class Unknown:
    """A condition that the text does not determine."""


@dataclass(frozen=True, slots=True)
class Bit:
    """A bit that is on or off."""

    name: str
    on: bool = True


@dataclass(frozen=True, slots=True)
class Compare:
    """A number compared with a constant."""

    name: str
    relation: str
    number: float
    least: float = -math.inf  # lowest value of the number
    most: float = math.inf
    whole: bool = True  # whether it is an integer


@dataclass(frozen=True, slots=True)
class AllOf:
    """Parts that hold together."""

    parts: tuple[Condition, ...]


@dataclass(frozen=True, slots=True)
class AnyOf:
    """Parts at least one of which holds."""

    parts: tuple[Condition, ...]


Condition = FixedTruth | Unknown | Bit | Compare | AllOf | AnyOf
TRUE, FALSE, UNKNOWN = FixedTruth(True), FixedTruth(False), Unknown()
Term = tuple[Condition, ...]


def all_of(*parts: Condition) -> Condition:
    """Return the condition that all parts hold. Parts beyond `MOST_PARTS` become unknown."""
    kept: list[Condition] = []
    size = 0
    for part in parts:
        if part == TRUE:
            continue
        size += sum(1 for _ in islice(leaves(part), MOST_PARTS + 1))
        if size > MOST_PARTS:
            kept.append(UNKNOWN)
            break
        kept += part.parts if isinstance(part, AllOf) else [part]
    return AllOf(tuple(kept)) if len(kept) > 1 else kept[0] if kept else TRUE


def negated(condition: Condition) -> Condition:
    """Return the opposite condition."""
    match condition:
        case FixedTruth(holds):
            return FixedTruth(not holds)
        case Bit(name, on):
            return Bit(name, not on)
        case Compare(name, relation, number, least, most, whole):
            return Compare(name, OPPOSITE[relation], number, least, most, whole)
        case AllOf(parts):
            return AnyOf(tuple(map(negated, parts)))
        case AnyOf(parts):
            return AllOf(tuple(map(negated, parts)))
    return condition


def of_any_number(condition: Condition) -> Condition:
    """Return a condition whose numbers may have any value, not only those that the program gives them."""

    def of(leaf: Condition) -> Condition:
        return replace(leaf, least=-math.inf, most=math.inf) if isinstance(leaf, Compare) else leaf

    return with_leaves(condition, of)


def with_leaves(condition: Condition, of: Callable[[Condition], Condition]) -> Condition:
    """Return a condition with each leaf replaced by `of(leaf)`."""
    match condition:
        case AllOf(parts):
            return AllOf(tuple(with_leaves(part, of) for part in parts))
        case AnyOf(parts):
            return AnyOf(tuple(with_leaves(part, of) for part in parts))
    return of(condition)


def never(condition: Condition) -> bool:
    """Whether a condition can't hold."""
    terms = alternatives(condition)
    return terms is not None and all(map(is_impossible, terms))


def always(condition: Condition) -> bool:
    """Whether a condition always holds."""
    return never(negated(condition))


def constant_condition(condition: Condition) -> tuple[str, str] | None:
    """For a condition that is always true or false, return the broken rule and a text; otherwise None."""
    if never(condition):
        several = len(list(islice(leaves(condition), 2))) > 1
        return "contradiction" if several else "constant-condition", "never holds"
    return ("constant-condition", "always holds") if always(condition) else None


def leaves(condition: Condition) -> Iterator[Condition]:
    """Yield the parts of a condition that have no parts themselves."""
    if isinstance(condition, AllOf | AnyOf):
        for part in condition.parts:
            yield from leaves(part)
    else:
        yield condition


def needed(condition: Condition) -> frozenset[Bit]:
    """Return the bits that hold whenever the condition does."""
    if isinstance(condition, Bit):
        return frozenset({condition})
    if isinstance(condition, AllOf):
        return frozenset().union(*map(needed, condition.parts))
    if isinstance(condition, AnyOf) and condition.parts:
        first, *others = map(needed, condition.parts)
        return first.intersection(*others)
    return frozenset()


def base_of(name: str) -> str:
    """Return the name of a value without the suffix that marks its later values.

    >>> base_of("STEP#0.1")
    'STEP'
    """
    return name.partition("#")[0]


def plain(condition: Condition) -> Condition:
    """Return a condition in which a value keeps one name, even if the program writes it in between."""

    def of(leaf: Condition) -> Condition:
        return replace(leaf, name=base_of(leaf.name)) if isinstance(leaf, Bit | Compare) else leaf

    return with_leaves(condition, of)


def compares(leaf: Condition, number: str) -> bool:
    """Whether a leaf compares a number, even if the program writes the number in between."""
    return isinstance(leaf, Compare) and base_of(leaf.name) == number


def is_only_of(condition: Condition, number: str) -> bool:
    """Whether a condition only compares one number."""
    return all(compares(leaf, number) for leaf in leaves(condition) if leaf != TRUE)


def steps_in(condition: Condition, number: str, steps: frozenset[float]) -> frozenset[float] | None:
    """Return the values of a number for which a condition can hold; None for all of them."""
    compared = (leaf for leaf in leaves(condition) if isinstance(leaf, Compare))
    names = sorted({comparison.name for comparison in compared if base_of(comparison.name) == number})
    if not names:
        return None
    possible_steps = frozenset(
        step for step in steps if not never(AllOf((*(Compare(name, "=", step) for name in names), condition)))
    )
    return None if possible_steps == steps else possible_steps


def alternatives(condition: Condition) -> list[Term] | None:
    """Return the alternatives of a condition; None if there are too many."""
    if isinstance(condition, AnyOf):
        terms_so_far: list[Term] = []
        for part in condition.parts:
            terms = alternatives(part)
            if terms is None or len(terms_so_far) + len(terms) > MOST:
                return None
            terms_so_far += terms
        return terms_so_far
    if isinstance(condition, AllOf):
        return _joined(condition.parts)
    return [(condition,)]


def _joined(parts: Iterable[Condition]) -> list[Term] | None:
    """Return the possible alternatives of parts that hold together; None if there are too many."""
    flat = list(_flat(parts))
    together = tuple(dict.fromkeys(part for part in flat if not isinstance(part, AnyOf)))
    joined: list[Term] | None = [] if is_impossible(together) else [together]
    for choice in flat:
        if isinstance(choice, AnyOf) and joined is not None:
            terms = alternatives(choice)
            joined = None if terms is None else _together(joined, terms)
    return joined


def _together(terms: list[Term], others: list[Term]) -> list[Term] | None:
    """Return every combination of two terms; None if there are too many."""
    if len(terms) * len(others) > MOST * 4:
        return None
    joined = [both for term in terms for other in others if not is_impossible(both := term + other)]
    is_short = len(joined) <= MOST and all(len(term) <= MOST_PARTS for term in joined)
    return joined if is_short else None


def _flat(parts: Iterable[Condition]) -> Iterator[Condition]:
    """Yield the parts that hold together; a part that consists of such parts is replaced by them."""
    for part in parts:
        if isinstance(part, AllOf):
            yield from _flat(part.parts)
        else:
            yield part


def is_impossible(term: Term) -> bool:
    """Whether parts of a term exclude each other."""
    on: dict[str, bool] = {}
    compared: dict[str, list[Compare]] = {}
    for part in term:
        if isinstance(part, FixedTruth) and not part.holds:
            return True
        if isinstance(part, Bit) and on.setdefault(part.name, part.on) != part.on:
            return True
        if isinstance(part, Compare):
            compared.setdefault(part.name, []).append(part)
    if any(map(_is_unsatisfiable, compared.values())):
        return True
    return any(on.get(_done(name)) for name in on if on[name])


def _done(name: str) -> str:
    """Return the name of the DN bit that excludes a TT bit, see `ON_DELAY`; "" for another bit."""
    return name.replace(".TT#", ".DN#") if ".TT#" in name and name.endswith(ON_DELAY) else ""


def _is_unsatisfiable(compared: list[Compare]) -> bool:
    """Whether no number satisfies all comparisons."""
    is_whole = compared[0].whole
    limits = [BOUNDS[comparison.relation](comparison.number, is_whole) for comparison in compared]
    lows, highs = zip(*limits, strict=True)
    least, most = max(compared[0].least, *lows), min(compared[0].most, *highs)
    if least > most:
        return True
    excluded = {comparison.number for comparison in compared if comparison.relation == "<>"}
    # few enough whole numbers that all may be excluded
    if is_whole and math.isfinite(most - least) and most - least < len(excluded):
        return excluded.issuperset(range(math.ceil(least), math.floor(most) + 1))
    return least == most and least in excluded


BOUNDS: Mapping[str, Callable[[float, bool], tuple[float, float]]] = {
    "=": lambda number, whole: (math.ceil(number), math.floor(number)) if whole else (number, number),
    "<>": lambda _number, _whole: (-math.inf, math.inf),
    ">=": lambda number, _whole: (number, math.inf),
    "<=": lambda number, _whole: (-math.inf, number),
    ">": lambda number, whole: (_next(number, whole=whole), math.inf),
    "<": lambda number, whole: (-math.inf, -_next(-number, whole=whole)),
}
"""By relation: the lowest and highest number that satisfies it; `whole` tells whether it is an integer."""


def _next(number: float, *, whole: bool) -> float:
    """Return the lowest value above a number."""
    return math.floor(number) + 1 if whole else math.nextafter(number, math.inf)
