"""Presets in the rungs of a document: `TON(Delay,5000,0)` shows PRE and ACC at the time of the export.

The data of the tags has the same values. A preset that can't be an initial value is replaced by `?`:

| case | reason |
|---|---|
| an element with a computed subscript, `Delays[Step]` | the element varies from scan to scan |
| an InOut of an add-on instruction | the tag varies from call to call |
| a structure with another preset in an earlier rung | a structure has only one initial value |
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
        self._first: dict[tuple[str, str], Operand] = {}  # by structure in capitals and member

    def with_settled_presets(self, rung: Rung, specs: Mapping[str, Spec]) -> Rung:
        """Return a rung of a document, with `?` instead of presets that can't be initial values."""
        for instruction in instructions_of(rung.series):
            spec = specs.get(instruction.name.upper())
            if spec is not None and self._operands(instruction, spec) != instruction.operands:
                return Rung(self._series(rung.series, specs), rung.comment, rung.origin)
        return rung

    def _series(self, series: Series, specs: Mapping[str, Spec]) -> Series:
        return tuple(self._element(element, specs) for element in series)

    def _element(self, element: Element, specs: Mapping[str, Spec]) -> Element:
        if isinstance(element, Branch):
            return Branch(tuple(self._series(leg, specs) for leg in element.legs))
        return Instruction(element.name, self._operands(element, specs[element.name.upper()]))

    def _operands(self, instruction: Instruction, spec: Spec) -> tuple[Operand, ...]:
        """Return the operands, with `?` instead of presets that can't be initial values."""
        if Use.PRESET not in spec.operands:
            return instruction.operands
        structure: Operand | None = None  # the structure to which the next presets belong
        names: Iterator[str] = iter(())  # the members that they set
        settled: list[Operand] = []
        for use, operand in zip(spec.operands, instruction.operands, strict=False):
            if use in WITH_PRESETS:
                structure, names = operand, iter(WITH_PRESETS[use])
            if use is Use.PRESET:
                settled.append(self._preset(structure, next(names), operand))
            else:
                settled.append(operand)
        return tuple(settled)

    def _preset(self, structure: Operand | None, member: str, preset: Operand) -> Operand:
        """Return a preset, or `?` if it can't be the initial value of the structure's member."""
        if not isinstance(preset, Number):
            return preset
        if not isinstance(structure, Address) or structure.name.upper() in self._inouts:
            return Unknown()
        if any(map(_is_computed, structure.steps)):
            return Unknown()
        first = self._first.setdefault((str(structure).upper(), member), preset)
        return preset if preset == first else Unknown()


def _is_computed(step: object) -> bool:
    return isinstance(step, SubscriptStep) and not all(isinstance(index, Number) for index in step.indices)
