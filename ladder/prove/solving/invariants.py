"""Truths of the state after a scan that hold in every run: random scans suggest them, the solver keeps some.

| suggested | of |
|---|---|
| a bit is never on, or never off | bits that never changed in the random scans |
| not both, not neither, not one without the other | two bits |
| at least 0, at most a bound | numbers |
| at most as much as another one | timers and counters |
| DN only from PRE on, TT only below it | timers |
| an enabled timer is done, or its time has been counted | timers |

Suggestions that the first scan breaks are dropped. Of the others those are dropped that a scan breaks before
which all of them held, until none is: what is left is inductive together.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations
from random import Random
from typing import Any, NamedTuple

from ..evaluation import Evaluator
from ..meaning import BOOL, INT
from ..system import CLOCK, System, shown
from ..terms import TRUE, T, and_, bits_of, const, lt, not_, or_
from .frames import Frame
from .solver import SAT, UNSAT, Solver

SCANS, RESTART = 300, 60
"""Random scans, and after how many of them a run starts again."""

MOST_TRIES = 8
"""Choices of free values for a scan, if contracts forbid some."""

MOST_STATES = 120
"""States up to which many suggestions are made."""

MOST_BITS, FEW_BITS = 160, 40
"""Bits of which pairs are formed in cones up to and above `MOST_STATES`."""

MOST_TIMERS = 12
"""Timers and counters of which pairs are formed."""

MOST_SUGGESTED = 4000

MOST_ROUNDS = 400
"""Maximum questions of one search."""

BOUNDS = (1, 2, 5, 10, 100, 1000)


class Invariant(NamedTuple):
    """A truth of the state after a scan, as a term of the values before it, and as text."""

    term: T
    text: str


def invariants(system: System, cone: Mapping[str, T], steps: int) -> list[Invariant]:
    """Return truths that hold from power-up on and follow from each other.

    Args:
        cone: the variables that count, the nearest first.
        steps: limit of the solver, for one question.
    """
    states = [name for name in cone if name in system.next]
    traces = simulate(system, cone, [system.next[name] for name in states])
    seen = dict(zip(states, traces, strict=True))
    made = {each.term: each for each in _suggested(system, cone, seen) if each.term.op != "const"}
    candidates = list(made.values())[:MOST_SUGGESTED]
    candidates = _kept(system, candidates, steps, first=True)
    return _kept(system, candidates, steps, first=False)


def simulate(system: System, cone: Mapping[str, T], roots: Sequence[T], seed: int = 0) -> list[list[Any]]:
    """Return the values of terms after random scans from power-up: one list for each term."""
    rng = Random(seed)
    states = [name for name in cone if name in system.next]
    every = Evaluator([*[system.next[name] for name in states], *roots, system.contract])
    values: dict[str, Any] = {}
    out: list[list[Any]] = [[] for _ in roots]
    for number in range(SCANS):
        first = number % RESTART == 0
        if first:
            values = {name: system.initial[name] for name in cone if name in system.initial}
        for _ in range(1 if system.contract is TRUE else MOST_TRIES):
            tried = values | _chosen(rng, system, cone, values, first=first)
            got = every(tried)
            if got[-1]:
                values = tried | dict(zip(states, got, strict=False))
                for each, value in zip(out, got[len(states) : -1], strict=True):
                    each.append(value)
                break
    return out


def _chosen(
    rng: Random, system: System, cone: Mapping[str, T], values: Mapping[str, Any], *, first: bool
) -> dict[str, Any]:
    """Return new values for some of the free variables; without a value before, for all."""
    chosen = {}
    for name, v in cone.items():
        kept = system.role(name) != "free" or (first and name in system.late)
        if not kept and (name not in values or rng.random() < 0.3):
            if name in system.likely and rng.random() < 0.7:
                chosen[name] = _signed(v, rng.choice(system.likely[name]))
                continue
            turned = name in values and v.kind == INT and rng.random() < 0.5
            chosen[name] = _one_bit_turned(rng, v, values[name]) if turned else any_value(rng, v)
    return chosen


def _signed(v: T, word: int) -> int:
    """Return an unsigned word as the variable has it."""
    return word if word <= v.hi else word - 0x10000


def _one_bit_turned(rng: Random, v: T, value: int) -> int:
    """Return a value near another one as words are: one bit differs, or two."""
    bits = bits_of(v.lo, v.hi) - 1
    turned = value ^ 1 << rng.randrange(bits) ^ (1 << rng.randrange(bits) if rng.random() < 0.3 else 0)
    return turned if v.lo <= turned <= v.hi else value


def any_value(rng: Random, v: T) -> Any:
    """Return a random value of a variable; small numbers are likely."""
    if v.kind == BOOL:
        return rng.random() < 0.5
    if v.kind == INT:
        near = rng.choice((0, 1, 2, 3, 5, 10, 100, 1000, rng.randint(v.lo, v.hi)))
        return max(v.lo, min(v.hi, near))
    return const(rng.choice((0.0, 1.0, rng.uniform(-100, 100))), v.kind).val


# --- suggestions


def _suggested(system: System, cone: Mapping[str, T], seen: Mapping[str, list[Any]]) -> Iterator[Invariant]:
    small = len(seen) <= MOST_STATES
    bits = [name for name in seen if cone[name].kind == BOOL]
    yield from _of_bits(system, seen, bits[: MOST_BITS if small else FEW_BITS])
    yield from _of_two_times(system, seen)
    for place, name in enumerate(seen):
        if cone[name].kind == INT and (small or place < MOST_STATES // 2):
            yield from _of_number(system, name, seen)


def _of_bits(system: System, seen: Mapping[str, list[Any]], bits: Sequence[str]) -> Iterator[Invariant]:
    packed = {name: sum(1 << at for at, on in enumerate(seen[name]) if on) for name in bits}
    every = (1 << len(seen[bits[0]])) - 1 if bits else 0
    changing = []
    for name in bits:
        t = system.next[name]
        if packed[name] in (0, every):
            yield Invariant(t, shown(name)) if packed[name] else Invariant(not_(t), f"NOT {shown(name)}")
        else:
            changing.append((shown(name), t, packed[name]))
    for place, (one, a, p) in enumerate(changing):
        for other, b, q in changing[place + 1 :]:
            if not p & q:
                yield Invariant(not_(and_(a, b)), f"NOT ({one} AND {other})")
            if not p & ~q:
                yield Invariant(or_(not_(a), b), f"NOT {one} OR {other}")
            if not ~p & q:
                yield Invariant(or_(a, not_(b)), f"{one} OR NOT {other}")
            if (p | q) == every:
                yield Invariant(or_(a, b), f"{one} OR {other}")


def _of_number(system: System, name: str, seen: Mapping[str, list[Any]]) -> Iterator[Invariant]:
    t, values = system.next[name], seen[name]
    if name.endswith(CLOCK + "[0]"):
        yield from _of_clock(system, name)
        return
    if not values:
        return
    if min(values) >= 0:
        yield Invariant(not_(lt(t, const(0))), f"{shown(name)} >= 0")
    for bound in sorted({max(values), *BOUNDS}):
        if max(values) <= bound:
            yield Invariant(not_(lt(const(bound), t)), f"{shown(name)} <= {bound}")
    stem, _, last = name.rpartition(".")
    preset = system.initial.get(f"{stem}.PRE[0]")
    if last == "ACC[0]" and preset is not None:
        below = lt(t, const(preset))
        for member, truth, sign in (("DN", not_(below), ">="), ("TT", below, "<")):
            flag = system.next.get(f"{stem}.{member}[0]")
            if flag is not None:
                text = f"NOT {stem}.{member} OR {shown(name)} {sign} {preset}"
                yield Invariant(or_(not_(flag), truth), text)


def _of_two_times(system: System, seen: Mapping[str, list[Any]]) -> Iterator[Invariant]:
    """Suggest that one timer never runs ahead of another."""
    timed = [name for name in seen if name.endswith(".ACC[0]") and any(seen[name])][:MOST_TIMERS]
    for one, other in permutations(timed, 2):
        if all(a <= b for a, b in zip(seen[one], seen[other], strict=True)):
            text = f"{shown(one)} <= {shown(other)}"
            yield Invariant(not_(lt(system.next[other], system.next[one])), text)


def _of_clock(system: System, name: str) -> Iterator[Invariant]:
    stem = name.rpartition(".")[0]
    enabled, done = (system.next.get(f"{stem}.{member}[0]") for member in ("EN", "DN"))
    if enabled is not None and done is not None:
        counted = not_(lt(const(0), system.next[name]))
        yield Invariant(or_(not_(enabled), or_(done, counted)), f"{stem} has counted its time")


# --- which of them hold


def _kept(system: System, candidates: list[Invariant], steps: int, *, first: bool) -> list[Invariant]:
    """Return the candidates that the first scan keeps, or any scan after one that kept all of them."""
    rounds = 0
    while candidates:
        solver = Solver(steps)
        frame = Frame(system, solver, first=first)
        if not first:
            for each in candidates:
                solver.state(frame.term(each.term))
            frame = Frame(system, solver, frame)
        left = [(each, frame.term(each.term)) for each in candidates]
        while True:
            rounds += 1
            answer = solver.check(_some_broken(solver, [made for _, made in left]))
            if answer == UNSAT:
                break
            if answer != SAT or rounds > MOST_ROUNDS:
                return []
            left = [(each, made) for each, made in left if solver.found(made, TRUE)]
            if not left:
                return []
        if first or len(left) == len(candidates):
            return [each for each, _ in left]
        candidates = [each for each, _ in left]
    return []


def _some_broken(solver: Solver, made: Sequence[Any]) -> Any:
    return solver.apply("not", [solver.apply("and", list(made)) if len(made) > 1 else made[0]])
