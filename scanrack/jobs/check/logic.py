"""Conditions of a program in any language, and whether they are never or always true.

    XIC(A)XIO(A)                  never: A is on and off
    GRT(Level,10)LES(Level,5)     never: Level is above 10 and below 5
    GRT(Count,40000)              never, if Count is an INT
    [XIC(A),XIO(A)]               always

A condition is split into alternatives. All parts of an alternative are true together. A condition with more
than `MOST` alternatives counts as neither never nor always true. A bit has one value within a condition,
because readers rename a bit after the program writes it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice

MOST = 128
"""Maximum number of alternatives of a condition."""

MOST_PARTS = 128
"""Maximum number of parts of a condition; additional parts are unknown. Time grows with their square."""

ON_DELAY = "t"
"""Suffix in the names of on-delay timer bits; DN and TT exclude each other [1756-RM003, TON]."""

INPUT = "in "
"""Prefix in the names of card inputs, which people and sensors set. Any inputs can be on together."""

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
    """Parts that are all true."""

    parts: tuple[Condition, ...]


@dataclass(frozen=True, slots=True)
class AnyOf:
    """Parts, at least one of which is true."""

    parts: tuple[Condition, ...]


Condition = FixedTruth | Unknown | Bit | Compare | AllOf | AnyOf
TRUE, FALSE, UNKNOWN = FixedTruth(True), FixedTruth(False), Unknown()
Term = tuple[Condition, ...]


def all_of(*parts: Condition) -> Condition:
    """Return the condition that all parts are true, without always-true parts and without nesting.

    Parts beyond `MOST_PARTS` become unknown.
    """
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
    if not kept:
        return TRUE
    return AllOf(tuple(kept)) if len(kept) > 1 else kept[0]


def negated(condition: Condition) -> Condition:
    """Return the opposite condition; a condition that is not known stays unknown."""
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
    """Return a condition in which numbers can have any value, not only values from the program."""

    def without_limits(leaf: Condition) -> Condition:
        return replace(leaf, least=-math.inf, most=math.inf) if isinstance(leaf, Compare) else leaf

    return with_leaves(condition, without_limits)


def with_leaves(condition: Condition, new_leaf: Callable[[Condition], Condition]) -> Condition:
    """Return a condition with each leaf replaced by `new_leaf(leaf)`."""
    match condition:
        case AllOf(parts):
            return AllOf(tuple(with_leaves(part, new_leaf) for part in parts))
        case AnyOf(parts):
            return AnyOf(tuple(with_leaves(part, new_leaf) for part in parts))
    return new_leaf(condition)


def never(condition: Condition) -> bool:
    """Whether a condition can't be true."""
    terms = alternatives(condition)
    return terms is not None and all(map(is_impossible, terms))


def always(condition: Condition) -> bool:
    """Whether a condition is always true."""
    return never(negated(condition))


def constant_condition(condition: Condition) -> tuple[str, str] | None:
    """Return the broken rule and a text if a condition is always true or always false; otherwise None."""
    if never(condition):
        several = len(list(islice(leaves(condition), 2))) > 1
        return "contradiction" if several else "constant-condition", "never holds"
    return ("constant-condition", "always holds") if always(condition) else None


def leaves(condition: Condition) -> Iterator[Condition]:
    """Yield the parts of a condition that have no parts of their own."""
    if isinstance(condition, AllOf | AnyOf):
        for part in condition.parts:
            yield from leaves(part)
    else:
        yield condition


def needed(condition: Condition) -> frozenset[Bit]:
    """Return the bits, each with the state that the condition needs to be true."""
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
    """Return a condition in which each value has one name, even if the program writes it in between."""

    def with_base_name(leaf: Condition) -> Condition:
        return replace(leaf, name=base_of(leaf.name)) if isinstance(leaf, Bit | Compare) else leaf

    return with_leaves(condition, with_base_name)


def compares(leaf: Condition, number: str) -> bool:
    """Whether a leaf compares a number, even if the program writes the number in between."""
    return isinstance(leaf, Compare) and base_of(leaf.name) == number


def is_only_of(condition: Condition, number: str) -> bool:
    """Whether a condition only compares one number."""
    return all(compares(leaf, number) for leaf in leaves(condition) if leaf != TRUE)


def steps_in(condition: Condition, number: str, steps: frozenset[float]) -> frozenset[float] | None:
    """Return the steps in which a condition can be true, or None if it can be true in all of them.

    Args:
        number: name of the number that contains the step.
    """
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
        return _alternatives_of_all(condition.parts)
    return [(condition,)]


def _alternatives_of_all(parts: Iterable[Condition]) -> list[Term] | None:
    """Return the alternatives in which all parts are true; None if there are too many."""
    flat_parts = list(_flattened(parts))
    fixed_parts = tuple(dict.fromkeys(part for part in flat_parts if not isinstance(part, AnyOf)))
    terms: list[Term] | None = [] if is_impossible(fixed_parts) else [fixed_parts]
    for choice in flat_parts:
        if isinstance(choice, AnyOf) and terms is not None:
            choice_terms = alternatives(choice)
            terms = None if choice_terms is None else _combinations(terms, choice_terms)
    return terms


def _combinations(terms: list[Term], other_terms: list[Term]) -> list[Term] | None:
    """Return every possible combination of two terms; None if there are too many."""
    if len(terms) * len(other_terms) > MOST * 4:
        return None
    combined = (term + other for term in terms for other in other_terms)
    possible = [term for term in combined if not is_impossible(term)]
    is_short = len(possible) <= MOST and all(len(term) <= MOST_PARTS for term in possible)
    return possible if is_short else None


def _flattened(parts: Iterable[Condition]) -> Iterator[Condition]:
    """Yield parts, with each `AllOf` replaced by its own parts."""
    for part in parts:
        if isinstance(part, AllOf):
            yield from _flattened(part.parts)
        else:
            yield part


def is_impossible(term: Term) -> bool:
    """Whether parts of a term exclude each other."""
    bit_states: dict[str, bool] = {}
    comparisons: dict[str, list[Compare]] = {}
    for part in term:
        if isinstance(part, FixedTruth) and not part.holds:
            return True
        if isinstance(part, Bit) and bit_states.setdefault(part.name, part.on) != part.on:
            return True
        if isinstance(part, Compare):
            comparisons.setdefault(part.name, []).append(part)
    if any(map(_is_unsatisfiable, comparisons.values())):
        return True
    return any(is_on and bit_states.get(_done_bit(name)) for name, is_on in bit_states.items())


def _done_bit(name: str) -> str:
    """Return the name of the DN bit that excludes a TT bit, see `ON_DELAY`; "" for any other bit."""
    return name.replace(".TT#", ".DN#") if ".TT#" in name and name.endswith(ON_DELAY) else ""


def _is_unsatisfiable(comparisons: list[Compare]) -> bool:
    """Whether no number satisfies all comparisons."""
    is_whole = comparisons[0].whole
    limits = [BOUNDS[comparison.relation](comparison.number, is_whole) for comparison in comparisons]
    lows, highs = zip(*limits, strict=True)
    least, most = max(comparisons[0].least, *lows), min(comparisons[0].most, *highs)
    if least > most:
        return True
    excluded = {comparison.number for comparison in comparisons if comparison.relation == "<>"}
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
"""By relation, the lowest and highest number that satisfies it; `whole` says whether it is an integer."""


def _next(number: float, *, whole: bool) -> float:
    """Return the lowest value above a number."""
    return math.floor(number) + 1 if whole else math.nextafter(number, math.inf)
