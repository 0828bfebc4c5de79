"""The Python front end: each rung is a call, with its elements from left to right.

| Python | rung text |
|---|---|
| `rung(start, ~stop, OTE(run))` | `XIC(Start)XIO(Stop)OTE(Run);` |
| `rung([start, run], ~stop, OTE(run))` | `[XIC(Start),XIC(Run)]XIO(Stop)OTE(Run);` |
| `rung([(a, ~b), c], OTE(d), e, OTE(f))` | `[XIC(a)XIO(b),XIC(c)]OTE(d)XIC(e)OTE(f);` |
| `rung(run, TON(fill))` | `XIC(Run)TON(Fill,?,?);` |
| `rung(count.ACC >= 10, MOV(count.ACC, total))` | `GEQ(Count.ACC,10)MOV(Count.ACC,Total);` |
| `rung(a * 2 > b, CPT(c, (a + b) / 2))` | `CMP(a*2>b)CPT(c,(a+b)/2);` |

Brackets are parallel branches, parentheses are a series in a branch, a tag is XIC, `~` is XIO, and a
comparison is the compare instruction.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence

from scanrack.io_images.site import Site

from ..instructions import BY_NAME
from ..model.errors import LadderError
from ..model.spec import Spec
from ..model.tagref import Expression, TagRef, operand_of
from ..model.tree import Branch, Element, Instruction, Origin, Rung, Series, too_deep
from .text import parse_rung


class RungMaker:
    """The argument of a routine's function. Call it once per rung; its instructions are from `specs`."""

    def __init__(self, specs: Mapping[str, Spec] = BY_NAME) -> None:
        self.rungs: list[Rung] = []  # the rungs so far
        self._specs = specs

    def __call__(self, *elements: object, comment: str = "") -> None:
        """Add a rung from tags, instructions and lists (branches), or from one str with rung text."""
        caller = sys._getframe(1)
        origin = Origin(caller.f_code.co_filename, caller.f_lineno)
        try:
            if len(elements) == 1 and isinstance(elements[0], str):
                series = parse_rung(elements[0], rung=len(self.rungs), specs=self._specs).series
            else:
                series = _checked(series_of(elements))
        except (LadderError, RecursionError) as error:
            reason = "lists are nested too deep" if isinstance(error, RecursionError) else error
            site = Site(file=origin.file, line=origin.line, rung=len(self.rungs))
            raise LadderError.at(site, f"rung {len(self.rungs)}: {reason}") from None
        self.rungs.append(Rung(series, comment, origin))


def _checked(series: Series) -> Series:
    deep = too_deep(series)
    if deep:
        raise LadderError(f"{deep}; split the rung with an internal bit")
    return series


def series_of(elements: Sequence[object]) -> Series:
    """Return Python values as a series; see the table above."""
    series: list[Element] = []
    for element in elements:
        if isinstance(element, tuple):
            series.extend(series_of(element))
        else:
            series.append(_element(element))
    return tuple(series)


def _element(value: object) -> Element:
    """Return a Python value as an element of a series; raise a LadderError if it can't be one."""
    if isinstance(value, (Instruction, Branch)):
        return value
    if isinstance(value, list):
        legs = tuple(series_of(leg if isinstance(leg, tuple) else (leg,)) for leg in value)
        return Branch(legs)
    if isinstance(value, TagRef):
        return Instruction("XIC", (value.operand,))
    if isinstance(value, str):
        return Instruction("XIC", (operand_of(value),))
    shown = f"the expression {value}" if isinstance(value, Expression) else repr(value)
    raise LadderError(f"{shown} is not part of a rung; write a tag, an instruction, or a list as a branch")


def make(name: str, *operands: object) -> Instruction:
    """Return an instruction by its name (see `Spec`), or raise a LadderError."""
    spec = BY_NAME.get(name.upper())
    if spec is None:
        raise LadderError(f"no instruction {name}")
    return spec(*operands)
