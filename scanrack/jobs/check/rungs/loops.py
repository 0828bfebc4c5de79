"""Loops of a ladder program: those that never end, and what their variables count."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from scanrack.ladder.debug.crossref import TARGETS
from scanrack.ladder.model.operands import Calculation, Constant, Place, Resolved
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

LEAVES = ("EXIT", "RETURN", "RET", "TND", "JMP")


def endless(
    routines: Iterable[LoweredRoutine], place_of: Callable[[LoweredLine], FileLine], facts: Facts
) -> None:
    """Note the loops of the user's routines that never end."""
    for routine in routines:
        for loop in loops_in(routine.body or ()):
            text = _why_endless(loop)
            if text:
                facts.remark("never-waits", place_of(loop.start or loop.condition), text)
        for line, text in _jumps_back(routine) if routine.body is None else ():
            facts.remark("never-waits", place_of(line), text)


def _why_endless(loop: Loop) -> str:
    """Return why a loop never ends; "" if it may."""
    steps = [step for line in _lines(loop.body) for step in line.all_steps]
    if any(step.name in LEAVES for step in steps):
        return ""
    if loop.start is not None:
        advance = loop.advance.steps[-1].operands[1] if loop.advance is not None else None
        by = advance.operands[1] if isinstance(advance, Calculation) else None
        return "FOR counts by 0: it never ends" if isinstance(by, Constant) and not by.value else ""
    places = list(_places(loop.condition.steps[0].operands[0]))
    paths = {each.leaf.path.upper() for each in places}
    is_fixed = all(not each.leaf.output and not each.leaf.frame and not each.can_fault for each in places)
    if not paths or not is_fixed or any(_may_write(step, paths) for step in steps):
        return ""
    names = ", ".join(dict.fromkeys(each.text for each in places))
    return f"nothing in this loop changes {names}: it never ends once it begins"


def _may_write(step: LoweredStep, paths: set[str]) -> bool:
    """Whether an instruction may write one of these; calls may write anything."""
    if step.name in ("JSR", ADD_ON, "FOR", "GSV"):
        return True
    for use, operand in zip(step.uses, step.operands, strict=False):
        path = (operand.leaf.path if isinstance(operand, Place) else getattr(operand, "path", "")).upper()
        is_same = any(each == path or each.startswith(f"{path}.") for each in paths)
        if use in TARGETS and is_same:
            return True
    return False


def _jumps_back(routine: LoweredRoutine) -> Iterator[tuple[LoweredLine, str]]:
    """Yield rungs that always jump back over rungs that never leave."""
    for at, line in enumerate(routine.lines):
        first = line.nodes[0] if line.nodes else None
        if isinstance(first, LoweredStep) and first.name == "JMP":
            label = routine.labels.get(first.operands[0])
            between = routine.lines[label:at] if label is not None else ()
            leaving = any(step.name in LEAVES for each in between for step in each.all_steps)
            if label is not None and label <= at and not leaving:
                yield line, f"this always jumps back to {first.operands[0]}: the scan never ends"


def counted(routines: Iterable[LoweredRoutine]) -> Iterator[tuple[str, Range, frozenset[int]]]:
    """Yield each FOR counter: its tag in capitals, its range in the loop, and where FOR writes it."""
    for routine in routines:
        for loop in loops_in(routine.body or ()):
            for path, range_ in _counted_by(loop):
                lines = (line for line in (loop.start, loop.advance) if line is not None)
                yield path, range_, frozenset(each.steps[-1].site for each in lines)
        for line in routine.lines:
            for step in line.all_steps:
                if step.name == "FOR" and all(isinstance(each, Constant) for each in step.operands[2:4]):
                    yield (
                        step.operands[1].leaf.path.upper(),
                        _range(*step.operands[2:4]),
                        frozenset({step.site}),
                    )


def counts_by_site(routines: Iterable[LoweredRoutine]) -> dict[int, dict[str, Range]]:
    """Return, by instruction in the body of a FOR, what it counts there: path in capitals, and range."""
    found: dict[int, dict[str, Range]] = {}
    for routine in routines:
        for loop in loops_in(routine.body or ()):
            steps = [step for line in _lines(loop.body) for step in line.all_steps]
            for path, range_ in _counted_by(loop):
                if not any(_may_write(step, {path}) for step in steps):
                    for step in steps:
                        found.setdefault(step.site, {})[path] = range_
    return found


def _counted_by(loop: Loop) -> Iterator[tuple[str, Range]]:
    """Yield what a FOR with constant bounds counts, and its range in the body."""
    if loop.start is None or loop.test is None:
        return
    place, first = loop.start.steps[-1].operands[:2]
    last = loop.test.steps[0].operands[0]
    end = last.operands[1] if isinstance(last, Calculation) and last.name in ("<=", ">=") else None
    if isinstance(first, Constant) and isinstance(end, Constant) and not place.frame:
        yield place.leaf.path.upper(), _range(first, end)


def _range(first: Constant, last: Constant) -> Range:
    return Range(min(first.value, last.value), max(first.value, last.value))


def loops_in(body: Body) -> Iterator[Loop]:
    """Yield the loops in statements."""
    for each in body:
        if isinstance(each, Loop):
            yield each
        for inner in bodies_of(each):
            yield from loops_in(inner)


def bodies_of(each: Act | Arms | Selection | Loop) -> Iterator[Body]:
    """Yield the bodies of a statement."""
    match each:
        case Arms(arms, otherwise):
            yield from (body for _, body in arms)
            yield otherwise
        case Selection():
            yield from (body for _, body in each.choices)
            yield each.otherwise
        case Loop():
            yield each.body


def _lines(body: Body) -> Iterator[LoweredLine]:
    for each in body:
        match each:
            case Act(line):
                yield line
            case Arms():
                yield from (line for line, _ in each.arms)
            case Selection(line):
                yield line
            case Loop():
                yield from (
                    line for line in (each.start, each.test, each.advance, each.until) if line is not None
                )
        for inner in bodies_of(each):
            yield from _lines(inner)


def _places(operand: Resolved) -> Iterator[Place]:
    if isinstance(operand, Place):
        yield operand
    for each in operand.operands if isinstance(operand, Calculation) else ():
        yield from _places(each)
