"""Defects planted in the relation: the comparison with the interpreter has to find each of them.

    python tests/tools/relation_defects.py            all of them
    python tests/tools/relation_defects.py MCR        those whose name has the word
    python tests/tools/relation_defects.py --values 2000000     no defect, until so many values are compared
    python tests/tools/relation_defects.py --values 500000 9000     the same from another seed on

Each defect changes one thing in `ladder/prove`, as a mistake there would. Random programs then run until one
has a value that differs; its number is printed. They are drawn by `relation_programs` and `relation_rows`;
without a defect those of the tests of both back ends run, too (`ladder_programs`, `structured_programs`). The
status is 1 if a defect is not found, if a difference is found without one, or if an instruction was not met.
"""

from __future__ import annotations

import itertools
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import hypothesis
import ladder_programs
import structured_programs
from relation import Relation
from relation_corpus import machine_text
from relation_programs import PROVED_WRONGLY, drawn
from relation_rows import BLOCKS, ROWS, SLC_ROWS, drawn_rows
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove.algebra import meaning, numbers, terms
from scanrack.ladder.prove.algebra.numbers import add, eq, lt, mul, sub
from scanrack.ladder.prove.algebra.terms import FALSE, TRUE, and_, const, ite, not_, or_
from scanrack.ladder.prove.relation import (
    calls,
    copies,
    faults,
    machine,
    operations,
    paths,
    patterns,
    places,
    stored,
    symbols,
    term_values,
    texts,
)
from scanrack.ladder.state.lowered import steps_of

MOST_PROGRAMS = 300
"""Programs that run before a defect counts as not found."""

FURTHER = 60

SCANS = 8

WRONGLY_EVERY = 150
"""Programs from one that was proved wrongly to the next."""

AT_ONCE = 40
"""Programs of a strategy that are drawn at once."""

Machine, Values, Symbol = machine.ScanMachine, term_values.TermValues, symbols.TermSymbol
Patch = tuple[Any, str, Any]
"""Owner, name, and what is there instead; the name of an item is in brackets."""


def _rounded_down(a: Any, b: Any) -> Any:
    """Divide, rounding down."""
    exact = numbers.div(a, b)
    below = and_(lt(a, const(0)), not_(eq(mul(exact, b), a)))
    return ite(below, sub(exact, const(1)), exact)


def _unmerged(found: list[Any], value: Any) -> Any:
    """Merge two paths the other way round."""
    left = [each for each in found if not each.faulted]
    if len(left) == 2 and len(left[0].decided) == 1:
        return ite(left[0].decided[0][0], value(left[1]), value(left[0]))
    return paths.merged(found, value)


def _instead(name: str, run: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method that does something else, with the one that it stands for first."""
    before = getattr(Machine, name)
    return lambda self, *given, **named: run(before, self, *given, **named)


def _always_active(self: Any, power: Any) -> Any:
    from contextlib import nullcontext

    return nullcontext(power)


def _no_flags(self: Any, t: Any, kind: str = "overflow") -> None:
    """Note no overflow."""


def _left_over(self: Any, nodes: Any) -> None:
    """Copy no results out."""


def _forget_rest(self: Any, since: Any, unit_ns: int) -> Any:
    found = self.get(since)
    self.put(since, 0)
    return found + 1


def _kept_age(self: Any, since: Any) -> None:
    """Do not begin to measure."""


def _first_choice_only(before: Any, self: Any, selection: Any, inputs: Any) -> None:
    before(self, replace(selection, choices=selection.choices[:1]), inputs)


def _no_else(before: Any, self: Any, arms: Any, inputs: Any) -> None:
    before(self, replace(arms, otherwise=()), inputs)


def _until_ignored(before: Any, self: Any, line: Any, inputs: Any, *, ends_if: bool) -> Any:
    return (
        before(self, line, inputs, ends_if=False)
        if ends_if and line is not None
        else before(self, line, inputs, ends_if=ends_if)
    )


def _both_legs(self: Any, branch: Any, power: Any) -> Any:
    behind = TRUE
    for leg in branch.legs:
        behind = and_(behind, self._series(leg, power))
    return behind


def _last_leg(self: Any, branch: Any, power: Any) -> Any:
    behind = FALSE
    for leg in branch.legs:
        behind = self._series(leg, power)
    return behind


def _in_place(self: Any, source: Any, target: Any, length: Any) -> None:
    """Copy element by element, so that an overlap reads what was just written."""
    origin, region, first = source
    goal, into, at = target
    count = self._least(self._least(length, into.left(at, goal)), region.left(first, origin))
    for number in range(copies._most(count, into)):
        for one, other in zip(region.parts, into.parts, strict=True):
            value = origin.read(one.leaf, (first + number) * one.per_element + one.field.index)
            self._write(
                goal, other.leaf, (at + number) * other.per_element + other.field.index, value, number, count
            )


def _stored_as_known(self: Any, leaf: Any, index: int, t: Any, guard: Any = TRUE) -> None:
    """Store where an instruction does not act what is known where it does (a proof was false)."""
    old = self.value_here(leaf, index)
    REAL["poke"](self, leaf, index, t, guard)
    if self.paths.path is None:
        key = leaf.path.upper(), index
        new = self._fitting(t, leaf, key)
        self._kept[key] = ite(and_(self.active, guard), new, old)


REAL: dict[str, Any] = {
    "poke": stored.TermPlaces.poke,
    "bit": numbers.bit,
    "setbit": numbers.setbit,
    "wrap": numbers.wrap,
    "lt": numbers.lt,
    "to_float": numbers.to_float,
}

DEFECTS: dict[str, tuple[Patch, ...]] = {
    "a narrow destination keeps 32 bits": (
        (term_values, "wrap", lambda a, n: REAL["wrap"](a, 32 if 0 < n < 32 else n)),
    ),
    "an unsigned destination is signed": ((term_values, "wrap", lambda a, n: REAL["wrap"](a, abs(n))),),
    "division rounds down": ((term_values, "DIVISIONS", {"/": _rounded_down, "MOD": numbers.rem}),),
    "MOD has the sign of the divisor": (
        (
            term_values,
            "DIVISIONS",
            {"/": numbers.div, "MOD": lambda a, b: sub(a, mul(_rounded_down(a, b), b))},
        ),
    ),
    "bits above 25 are their neighbors": (
        (places, "bit", lambda a, k: REAL["bit"](a, k - 1 if k > 25 else k)),
    ),
    "setting a bit clears bit 0": (
        (places, "setbit", lambda a, k, b, n: REAL["setbit"](REAL["setbit"](a, 0, FALSE, n), k, b, n)),
    ),
    "less or equal for less": ((symbols, "lt", lambda a, b: numbers.le(a, b)),),
    "unequal for equal beyond 100": (
        (symbols, "eq", lambda a, b: numbers.eq(a, b) if a.kind != "i" or a.hi < 100 else FALSE),
    ),
    "OR of conditions is XOR": (
        (term_values, "TRUTH", {**operations.TRUTH, "OR": lambda a, b: not_(terms.iff(a, b))}),
    ),
    "NOT of a number is its negation": ((symbols, "inv", lambda a: sub(const(0), a)),),
    "AND of patterns is OR": ((Symbol, "__and__", lambda self, other: self._bits(other, "bor", or_)),),
    "JMP does not skip": ((Machine, "jump_to", lambda self, power, label: power),),
    "a label is not reached by its jump": (
        (Machine, "jump_to", lambda self, power, label: self._left(power)),
    ),
    "RET does not leave": ((Machine, "_left", lambda self, power: power),),
    "RET brings no values": ((Machine, "take_values", lambda self, places_, values_: None),),
    "a call leaves the caller's rung false": (
        (
            Machine,
            "call_with",
            _instead("call_with", lambda before, self, *given: (before(self, *given), FALSE)[1]),
        ),
    ),
    "a false rung acts": ((Machine, "when", _always_active),),
    "a branch is true where all legs are": ((Machine, "_branch", _both_legs),),
    "a branch is as its last leg": ((Machine, "_branch", _last_leg),),
    "MCR is not seen": (
        (
            Machine,
            "_line",
            _instead(
                "_line", lambda before, self, line, inputs, **_: before(self, line, inputs, statement=True)
            ),
        ),
    ),
    "overflow sets no flag": ((faults.TermFaults, "overflow_if", _no_flags),),
    "a divisor of zero sets no flag": ((faults.TermFaults, "zero_divisor_if", _no_flags),),
    "division by zero gives 0": (
        (
            term_values,
            "ite",
            lambda c, a, b: terms.ite(c, const(0) if a.kind == "i" and b.op == "wrap" else a, b),
        ),
    ),
    "REAL is computed in double": ((term_values, "F32", meaning.F64), (stored, "F32", meaning.F64)),
    "a REAL is cut off into an integer": ((term_values, "to_int", lambda t, how: numbers.to_int(t, "rtz")),),
    "NaN equals itself": ((symbols, "eq", lambda a, b: TRUE if a is b else numbers.eq(a, b)),),
    "a fault of a subscript is lost": (
        (paths, "faults_of", lambda found: FALSE),
        (stored, "faults_of", lambda found: FALSE),
    ),
    "a negative subscript counts from the end": (
        (stored, "_below", lambda t, most: numbers.bitop("band", sub(t, const(1)), const(7))),
    ),
    "a computed write hits the next element": ((places, "eq", lambda a, b: numbers.eq(add(a, const(1)), b)),),
    "a computed read reads the first element": ((places, "chosen", lambda found, number: found[0]),),
    "a timer counts a millisecond more": ((Values, "elapsed", _forget_rest),),
    "a timer does not begin anew": ((Values, "start_clock", _kept_age),),
    "paths are merged the other way": ((stored, "merged", _unmerged),),
    "a path that writes nothing clears": (
        (
            stored,
            "merged",
            lambda found, value: paths.merged([each for each in found if each.written] or found[:1], value),
        ),
    ),
    "results of an add-on are not copied out": ((Machine, "_copies", _left_over),),
    "EnableInFalse runs on a true rung": (
        (
            Machine,
            "call_add_on",
            _instead("call_add_on", lambda before, self, power, call: before(self, not_(power), call)),
        ),
    ),
    "what is known where an instruction acts is stored where it does not": (
        (stored.TermPlaces, "poke", _stored_as_known),
    ),
    "a refused block without power does nothing": (
        (Machine, "_acting", lambda self, step, power: power),  # a proof was false
    ),
    "ELSE does nothing": (
        (Machine, "_arms", _instead("_arms", _no_else)),
        (
            Machine,
            "_selection",
            _instead(
                "_selection",
                lambda before, self, each, inputs: before(self, replace(each, otherwise=()), inputs),
            ),
        ),
    ),
    "only the first choice of CASE counts": (
        (Machine, "_selection", _instead("_selection", _first_choice_only)),
    ),
    "UNTIL ends on false": ((Machine, "_left_by", _instead("_left_by", _until_ignored)),),
    "EXIT goes on": ((Machine, "exit_loop", lambda self, power: power),),
    "BRK does not end a FOR": ((calls, "BROKEN", object()),),
    "a copy reads what it has just written": ((copies.CopyRegions, "_copy_fields", _in_place),),
    "a copy is one element longer": (
        (copies, "_known", lambda count, region: count + 1 if count == 1 else count),
    ),
    "bytes are in the other order": (
        (patterns, "shr", lambda a, n: numbers.shr(a, 8 - n if 0 <= n <= 8 else n)),
    ),
    "FLL fills one element less": ((copies.CopyRegions, "fill", lambda self, target, length, value: None),),
    "CONCAT starts one place early": (
        (
            texts,
            "_moved",
            lambda codes, by, size, real=texts._moved: real(
                codes, numbers.clip(sub(by, const(1)), 0, 255), size
            ),
        ),
    ),
    "capitals end at Y": ((texts.TermText, "upper", lambda self: self._shifted(b"ay", -32)),),
    "texts are equal without their ends": (
        (texts.TermText, "_equals", lambda self, other: eq(self.length, other.length)),
    ),
    "digits come the other way": (
        (term_values, "digits", lambda make, value: _turned(texts.digits(make, value))),
    ),
}
"""What is wrong, and where."""


def _turned(text: Any) -> Any:
    return texts.TermText(text.make, text.length, [text.at(1), text.at(0), *text.codes[2:]])


@contextmanager
def planted(patches: tuple[Patch, ...]) -> Iterator[None]:
    """Run the body with a defect."""
    kept = [(owner, name, getattr(owner, name)) for owner, name, _ in patches]
    for owner, name, new in patches:
        setattr(owner, name, new)
    try:
        yield
    finally:
        for owner, name, old in kept:
            setattr(owner, name, old)


def program_of(seed: int) -> Any:
    """Return the program of a seed: one of two generators, now and then one that was proved wrongly."""
    rounds, turn = divmod(seed, WRONGLY_EVERY)
    if turn < len(PROVED_WRONGLY):
        return parse_program(PROVED_WRONGLY[turn])
    seed -= len(PROVED_WRONGLY) * (rounds + 1)
    return drawn_rows(seed // 2) if seed % 2 else parse_program(drawn(seed // 2))


def first_difference(most: int) -> str:
    """Return the first program whose values differ, "" if none does; one that can't run is none.

    Where only faults differ, that is said after `FURTHER` programs more: of a lost fault nothing else can.
    """
    broken, faulted, last = 0, "", most
    for seed in range(most):
        if seed == last:
            break
        try:
            found = Relation(program_of(seed)).differences(Random(seed), SCANS)
        except Exception:
            broken += 1
            continue
        values = [each for each in found if ": interpreter " in each]
        if values:
            return f"program {seed}: {values[0]}" + f" ({broken} could not run)" * bool(broken)
        if found and not faulted:
            faulted, last = f"only faults: program {seed}: {found[0]}", min(most, seed + FURTHER)
    return faulted


def strategies(seed: int) -> list[str]:
    """Return programs of rungs and of structured text that tests of both back ends have."""
    found: list[str] = []

    @hypothesis.seed(seed)
    @hypothesis.settings(
        max_examples=AT_ONCE,
        phases=[hypothesis.Phase.generate],
        database=None,
        deadline=None,
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(ladder_programs.programs(), structured_programs.structured())
    def keep(rungs: str, text: str) -> None:
        found.extend((rungs, text))

    keep()
    return found


def programs(first: int) -> Iterator[Any]:
    """Yield programs without end, from a seed on."""
    for seed in itertools.count(first):
        yield program_of(seed)
        if seed % 5 == 4:
            yield parse_program(machine_text(seed))
        if seed % 200 == 199:
            yield from map(parse_program, strategies(seed))


def compare(values: int, first: int = 0) -> int:
    """Compare values without a defect, from a seed on; return the status."""
    count: Counter[str] = Counter()
    met: set[str] = set()
    for number, program in enumerate(programs(first)):
        relation = Relation(program)
        found = relation.differences(Random(first + number), SCANS, count)
        count["programs"] += 1
        met |= {step.name for line, _, _ in relation.machine.rungs for step in steps_of(line.nodes)}
        if found:
            print(f"program {number} from seed {first} on: {found[0]}")
            return 1
        if count["programs"] % 100 == 0:
            print(", ".join(f"{number:,} {name}" for name, number in count.items()), flush=True)
        if count["values"] >= values:
            break
    missed = sorted({*ROWS, *BLOCKS, *SLC_ROWS} - met)
    print(f"{count['values']:,} values of {count['programs']:,} programs are equal; {len(met)} instructions")
    print(f"not met: {', '.join(missed) or 'none'}")
    return 1 if missed else 0


def main(words: list[str]) -> int:
    """Plant the defects whose names have the words; return the status."""
    if words[:1] == ["--values"]:
        return compare(*map(int, words[1:]))
    missed = 0
    for name, patches in DEFECTS.items():
        if words and not any(each in name for each in words):
            continue
        with planted(patches):
            where = first_difference(MOST_PROGRAMS)
        missed += not where
        print(f"{name}: {where or 'NOT FOUND'}", flush=True)
    print(f"{len(DEFECTS)} defects, {missed} not found")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
