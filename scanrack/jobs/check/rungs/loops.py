"""Endless loops of a ladder program, and the ranges of loop counts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain

from scanrack.ladder.model.operands import Calculation, Constant, Group, Place
from scanrack.ladder.state.lowered import (
    ADD_ON,
    Act,
    Arms,
    Body,
    Loop,
    LoweredLine,
    LoweredRoutine,
    LoweredStep,
    Selection,
)

from ..facts import Facts, FileLine
from ..ranges import Range
from .operands import around, is_zero, parts_of, path_of, steps_in, written_by

LEAVES = ("EXIT", "RETURN", "RET", "TND", "JMP")


def endless(
    routines: Iterable[LoweredRoutine], place_of: Callable[[LoweredLine], FileLine], facts: Facts
) -> None:
    """Note endless loops."""
    for routine in routines:
        for loop in loops_in(routine.body or ()):
            text = _why_endless(loop)
            if text:
                facts.remark("never-waits", place_of(loop.start or loop.condition), text)
        for line, text in _jumps_back(routine) if routine.body is None else ():
            facts.remark("never-waits", place_of(line), text)


def _why_endless(loop: Loop) -> str:
    """Return the reason why a loop is endless; "" if it may end."""
    steps = _steps(loop.body)
    if any(step.name in LEAVES for step in steps):
        return ""
    if loop.start is not None:
        return "FOR counts by 0: it never ends" if _counts_by_zero(loop) else ""
    tested = loop.condition.steps[0].operands[0]
    places = [part for part in parts_of(tested) if isinstance(part, Place)]
    names = ", ".join(dict.fromkeys(place.text for place in places))
    if not names or not _are_fixed(places, steps):
        return ""
    return f"nothing in this loop changes {names}: it never ends once it begins"


def _are_fixed(places: Sequence[Place], steps: Iterable[LoweredStep]) -> bool:
    """Whether nothing, including these instructions, can change these values during a scan."""
    paths = set(map(path_of, places))
    return all(map(_is_of_program, places)) and not any(_may_write(step, paths) for step in steps)


def _counts_by_zero(loop: Loop) -> bool:
    """Whether a FOR adds the constant 0 after each pass."""
    advance = loop.advance.steps[-1].operands[1] if loop.advance is not None else None
    return isinstance(advance, Calculation) and is_zero(advance.operands[1])


def _is_of_program(place: Place) -> bool:
    """Whether only the program can change a value during a scan, and its subscripts are constants."""
    return not place.leaf.output and not place.leaf.frame and not place.can_fault


def _may_write(step: LoweredStep, paths: set[str]) -> bool:
    """Whether an instruction may write one of the paths; calls may write any path."""
    if step.name in ("JSR", ADD_ON, "FOR", "GSV"):
        return True
    written = {path_of(operand) for operand in written_by(step) if isinstance(operand, Place | Group)}
    return any(not written.isdisjoint((path, *around(path))) for path in paths)


def _jumps_back(routine: LoweredRoutine) -> Iterator[tuple[LoweredLine, str]]:
    """Yield rungs that always jump back over rungs that never leave the loop."""
    for index, line in enumerate(routine.lines):
        label = _always_jumps_to(line)
        target = routine.labels.get(label, index + 1)
        between = chain.from_iterable(inner.all_steps for inner in routine.lines[target:index])
        if target <= index and not any(step.name in LEAVES for step in between):
            yield line, f"this always jumps back to {label}: the scan never ends"


def _always_jumps_to(line: LoweredLine) -> str:
    """Return the label of a JMP at the start of a rung; "" if there is none."""
    first = line.nodes[0] if line.nodes else None
    return str(first.operands[0]) if isinstance(first, LoweredStep) and first.name == "JMP" else ""


def counted(routines: Iterable[LoweredRoutine]) -> Iterator[tuple[str, Range, frozenset[int]]]:
    """Yield each count of a FOR: its tag in capitals, its range in the loop, and the sites that count it."""
    for routine in routines:
        for loop in loops_in(routine.body or ()):
            sites = frozenset(act.steps[-1].site for act in (loop.start, loop.advance) if act is not None)
            yield from ((path, range_, sites) for path, range_ in _counted_by(loop))
        for step in steps_in(routine):
            if step.name == "FOR" and all(isinstance(operand, Constant) for operand in step.operands[2:4]):
                yield path_of(step.operands[1]), _range(*step.operands[2:4]), frozenset({step.site})


def counts_by_site(routines: Iterable[LoweredRoutine]) -> dict[int, dict[str, Range]]:
    """Return, for each instruction in the body of a FOR, the range of each count, by path in capitals."""
    counts: dict[int, dict[str, Range]] = {}
    for routine in routines:
        for loop in loops_in(routine.body or ()):
            steps = _steps(loop.body)
            for path, range_ in _counted_by(loop):
                if not any(_may_write(step, {path}) for step in steps):
                    for step in steps:
                        counts.setdefault(step.site, {})[path] = range_
    return counts


def _counted_by(loop: Loop) -> Iterator[tuple[str, Range]]:
    """Yield the count of a FOR with constant bounds, and its range in the body."""
    if loop.start is None or loop.test is None:
        return
    place, first = loop.start.steps[-1].operands[:2]
    last = loop.test.steps[0].operands[0]
    end = last.operands[1] if isinstance(last, Calculation) and last.name in ("<=", ">=") else None
    if isinstance(first, Constant) and isinstance(end, Constant) and not place.frame:
        yield path_of(place), _range(first, end)


def _range(first: Constant, last: Constant) -> Range:
    return Range(min(first.value, last.value), max(first.value, last.value))


def loops_in(body: Body) -> Iterator[Loop]:
    """Yield the loops in statements."""
    for statement in body:
        if isinstance(statement, Loop):
            yield statement
        for inner in bodies_of(statement):
            yield from loops_in(inner)


def bodies_of(statement: Act | Arms | Selection | Loop) -> Iterator[Body]:
    """Yield the bodies of a statement."""
    match statement:
        case Arms(arms, otherwise):
            yield from (body for _, body in arms)
            yield otherwise
        case Selection():
            yield from (body for _, body in statement.choices)
            yield statement.otherwise
        case Loop():
            yield statement.body


def _steps(body: Body) -> list[LoweredStep]:
    """Return the instructions of statements."""
    return [step for line in lines_in(body) for step in line.all_steps]


def lines_in(body: Body) -> Iterator[LoweredLine]:
    """Yield the lines of statements; the lines of a statement come before the lines inside it."""
    for statement in body:
        match statement:
            case Act(line) | Selection(line):
                yield line
            case Arms():
                yield from (line for line, _ in statement.arms)
            case Loop():
                lines = (statement.start, statement.test, statement.advance, statement.until)
                yield from (line for line in lines if line is not None)
        for inner in bodies_of(statement):
            yield from lines_in(inner)
