"""Checks of a whole program: labels, loops, end, size."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from .instructions import CAPACITY_BYTES
from .model import Program, ProgramError


class _Loop(NamedTuple):
    """A loop: the indices of its label and its LOOP instruction."""

    start: int
    end: int
    inner: bool


def check_structure(program: Program, lines: Sequence[int] | None = None) -> None:
    """Raise a ProgramError for wrong labels, loops, end or size; `lines` has the line of each step."""
    for step, reason in _mistakes(program):
        raise ProgramError(reason, None if lines is None else lines[step])
    if not program.steps or program.steps[-1].name != "END":
        raise ProgramError("END is missing: it must be the last instruction", lines[-1] if lines else None)
    if program.size > CAPACITY_BYTES:
        raise ProgramError(f"it takes {program.size} bytes: program memory holds {CAPACITY_BYTES}")


def _mistakes(program: Program) -> Iterator[tuple[int, str]]:
    yield from _labels(program)
    yield from _loops(program)


def _labels(program: Program) -> Iterator[tuple[int, str]]:
    for index, step in enumerate(program.steps):
        if step.name == "LABEL" and program.labels[str(step.values[0])] != index:
            yield program.labels[str(step.values[0])], f"label {step.values[0]} is given twice"
        if step.target is not None and step.target not in program.labels:
            yield index, f"label {step.target} is unknown: {_known(program)}"


def _known(program: Program) -> str:
    return "known are " + ", ".join(program.labels) if program.labels else "the program has none"


def _loops(program: Program) -> Iterator[tuple[int, str]]:
    loops: list[_Loop] = []
    for index, step in enumerate(program.steps):
        if not step.name.startswith("LOOP"):
            continue
        loop = _Loop(program.labels[str(step.target)], index, step.name == "LOOP INNER")
        if loop.start > index:
            yield index, f"label {step.target} must be above the loop"
        for other_loop in loops:
            if other_loop.end > loop.start and (other_loop.inner == loop.inner or not other_loop.inner):
                yield index, _nested(other_loop, loop)
        loops.append(loop)


def _nested(inside: _Loop, around: _Loop) -> str:
    inner_kind, outer_kind = ("inner" if loop.inner else "outer" for loop in (inside, around))
    return f"an {inner_kind} loop can't be inside an {outer_kind} loop: only inner loops in an outer one"
