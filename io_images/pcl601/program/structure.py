"""Checks a whole program: labels, loops, end and size."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import NamedTuple

from .instructions import CAPACITY_BYTES
from .model import Program, ProgramError


class _Loop(NamedTuple):
    """A loop."""

    start: int  # index of its label
    end: int  # index of its LOOP instruction
    kind: str  # "inner" or "outer"


def check_structure(program: Program, lines: Sequence[int] | None = None) -> None:
    """Raise a ProgramError if the labels, loops, end or size are wrong.

    Args:
        lines: line number of each step; None for a program without text.
    """
    for index, reason in chain(_wrong_labels(program), _wrong_loops(program)):
        raise ProgramError(reason, None if lines is None else lines[index])
    if not program.steps or program.steps[-1].name != "END":
        raise ProgramError("END is missing: it must be the last instruction", lines[-1] if lines else None)
    if program.size > CAPACITY_BYTES:
        raise ProgramError(f"it takes {program.size} bytes: program memory holds {CAPACITY_BYTES}")


def _wrong_labels(program: Program) -> Iterator[tuple[int, str]]:
    """Yield the index of each step with a wrong label, and the reason."""
    for index, step in enumerate(program.steps):
        if step.name == "LABEL" and program.labels[str(step.values[0])] != index:
            yield program.labels[str(step.values[0])], f"label {step.values[0]} is given twice"
        if step.target is not None and step.target not in program.labels:
            labels = f"known are {', '.join(program.labels)}" if program.labels else "the program has none"
            yield index, f"label {step.target} is unknown: {labels}"


def _wrong_loops(program: Program) -> Iterator[tuple[int, str]]:
    """Yield the index of each LOOP instruction that is wrong, and the reason."""
    loops: list[_Loop] = []
    for index, step in enumerate(program.steps):
        if not step.name.startswith("LOOP"):
            continue
        kind = "inner" if step.name == "LOOP INNER" else "outer"
        loop = _Loop(program.labels[str(step.target)], index, kind)
        if loop.start > index:
            yield index, f"label {step.target} must be above the loop"
        for other_loop in loops:
            is_inside = other_loop.end > loop.start
            if is_inside and (other_loop.kind, loop.kind) != ("inner", "outer"):
                only = "only inner loops in an outer one"
                yield index, f"an {other_loop.kind} loop can't be inside an {loop.kind} loop: {only}"
        loops.append(loop)
