"""Presets in the rungs of a document: `TON(Delay,5000,0)` shows PRE and ACC at the time of the export.

The data of the tags have the same values. A preset is replaced by `?` where it can't be an initial value:

| case | reason |
|---|---|
| an element with a computed subscript, `Delays[Step]` | it varies from scan to scan |
| an InOut of an add-on instruction | it varies from call to call |
| a structure with another preset in an earlier rung | it has one initial value |
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

from scanrack.ladder.model.spec import WITH_PRESETS, Spec, Use
from scanrack.ladder.model.tree import (
    Address,
    Branch,
    Element,
    Instruction,
    Number,
    Operand,
    Rung,
    Series,
    SubscriptStep,
    Unknown,
    instructions_of,
)


class Presets:
    """The presets in one program or add-on instruction; `inouts` are in capitals."""

    def __init__(self, inouts: Collection[str] = ()) -> None:
        self._inouts = inouts
        self._first: dict[tuple[str, str], Operand] = {}

    def settled(self, rung: Rung, specs: Mapping[str, Spec]) -> Rung:
        """Return a document's rung, with `?` in place of presets that can't be initial values."""
        if any(
            self._differs(instruction, specs.get(instruction.name.upper()))
            for instruction in instructions_of(rung.series)
        ):
            return Rung(self._series(rung.series, specs), rung.comment, rung.origin)
        return rung

    def _differs(self, instruction: Instruction, spec: Spec | None) -> bool:
        return spec is not None and self._operands(instruction, spec) != instruction.operands

    def _series(self, series: Series, specs: Mapping[str, Spec]) -> Series:
        return tuple(self._element(element, specs) for element in series)

    def _element(self, element: Element, specs: Mapping[str, Spec]) -> Element:
        if isinstance(element, Branch):
            return Branch(tuple(self._series(leg, specs) for leg in element.legs))
        return Instruction(element.name, self._operands(element, specs[element.name.upper()]))

    def _operands(self, instruction: Instruction, spec: Spec) -> tuple[Operand, ...]:
        """Return the operands of an instruction, keeping only presets that can be initial values."""
        if Use.PRESET not in spec.operands:
            return instruction.operands
        structure: Operand | None = None
        names: Iterator[str] = iter(())
        settled: list[Operand] = []
        for use, operand in zip(spec.operands, instruction.operands, strict=False):
            if use in WITH_PRESETS:
                structure, names = operand, iter(WITH_PRESETS[use])
            if use is Use.PRESET:
                settled.append(self._preset(structure, next(names), operand))
            else:
                settled.append(operand)
        return tuple(settled)

    def _preset(self, structure: Operand | None, name: str, given: Operand) -> Operand:
        if not isinstance(given, Number):
            return given
        if not isinstance(structure, Address) or structure.name.upper() in self._inouts:
            return Unknown()
        if any(map(_is_computed, structure.steps)):
            return Unknown()
        return given if self._first.setdefault((str(structure).upper(), name), given) == given else Unknown()


def _is_computed(step: object) -> bool:
    return isinstance(step, SubscriptStep) and not all(isinstance(index, Number) for index in step.indices)
