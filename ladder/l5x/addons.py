"""Add-on instructions of a document."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..addon import ENABLES, LOGIC, ROUTINES, AddOn, Parameter, Way
from ..errors import LadderError
from ..instructions import BY_NAME
from ..spec import Spec
from ..tree import Routine
from ..types import MAX_DIMENSIONS, Structure
from .assembly import without
from .datatypes import Types
from .records import AddOnRecord, TagRecord
from .report import Refusal, Report
from .routines import RoutineReader
from .values import ValueTextError, initial_of

_WAYS = {"INPUT": Way.INPUT, "OUTPUT": Way.OUTPUT, "INOUT": Way.INOUT}


class AddOns:
    """The add-on instructions of a document, made when one is asked for.

    Attributes:
        made: by name in capitals.

    Args:
        records: their records.
        types: the document's types.
        report: collects what is refused.
    """

    def __init__(self, records: tuple[AddOnRecord, ...], types: Types, report: Report) -> None:
        self.records = {each.name.upper(): each for each in records}
        self._types, self._report = types, report
        self._shapes: dict[str, AddOn] = {}
        self._wrong: dict[str, str] = {}
        self.made: dict[str, AddOn] = {}
        types.add_on = self.structure

    def structure(self, name: str) -> Structure | None:
        """Return the type of an add-on's instances, None if there is no such add-on."""
        return self.shape(name).structure if name in self.records else None

    def shape(self, name: str) -> AddOn:
        """Return an add-on with its parameters and without its logic.

        Args:
            name: in capitals.

        Raises:
            LadderError: it can't be used.
        """
        if name in self._wrong:
            raise LadderError(self._wrong[name])
        if name not in self._shapes:
            record = self.records[name]
            try:
                if name in BY_NAME:
                    raise LadderError(f"{record.name} is an instruction here, and an add-on in the file")
                parameters = tuple(self._parameters(record))
                self._shapes[name] = AddOn(record.name, parameters, (Routine(LOGIC, ()),), record.comment)
            except LadderError as error:
                self._wrong[name] = str(error)
                raise
        return self._shapes[name]

    def specs(self) -> Mapping[str, Spec]:
        """Return the shapes of all instructions, by name in capitals; refuse add-ons that can't be used."""
        found = dict(BY_NAME)
        for name, record in self.records.items():
            try:
                found[name] = self.shape(name).spec
            except LadderError as error:
                self._refuse(record, str(error), "correct the definition")
        return found

    def _parameters(self, record: AddOnRecord) -> Any:
        enables = [each.upper() for each in ENABLES]
        for each in record.parameters:
            if each.name.upper() not in enables:
                yield self._parameter(each, _WAYS.get(each.usage.upper(), Way.INPUT))
        for each in record.locals:
            yield self._parameter(each, Way.LOCAL)

    def _parameter(self, record: TagRecord, way: Way) -> Parameter:
        if len(record.dims) > MAX_DIMENSIONS:
            raise LadderError(f"{record.name} has more than {MAX_DIMENSIONS} dimensions")
        if record.target:
            return self._alias(record, way)
        kind = self._types.find(record.type)
        initial = None
        if way is not Way.INOUT:
            try:
                initial = initial_of(record.data, kind, record.dims)
            except ValueTextError as error:
                self._report.note(record.name, f"its default is not used: {error}", record.line)
        return Parameter(record.name, kind, way, record.dims, record.required, record.comment, initial)

    def _alias(self, record: TagRecord, way: Way) -> Parameter:
        kind = self._types.find(record.type or "BOOL")
        return Parameter(
            record.name, kind, way, record.dims, record.required, record.comment, at=record.target
        )

    def read(self, reader: RoutineReader) -> None:
        """Read the logic of all add-ons."""
        for name, shape in self._shapes.items():
            record = self.records[name]
            if record.encoded:
                self._refuse(record, "its source is encoded, so that it is not in the file", _DECODE)
                continue
            routines = []
            for each in record.routines:
                routine = reader.routine(record.name, each)
                role = next((role for role in ROUTINES if role.upper() == each.name.upper()), None)
                if role is not None and routine is not None:
                    named = Routine(role, routine.rungs, routine.comment, routine.statements)
                    routines.append(self._allowed(shape, named, reader))
            if LOGIC not in [each.name for each in routines]:
                routines.insert(0, Routine(LOGIC, ()))
            self.made[name] = shape.with_routines(tuple(routines))

    def _allowed(self, shape: AddOn, routine: Routine, reader: RoutineReader) -> Routine:
        """Return a routine without what has no place in an add-on instruction; refuse that."""
        for number, text in list(shape.wrong_in(routine)):
            if routine.statements is None:
                reader.refuse(shape.name, routine.name, number, text, _PARAMETER)
            else:
                reader.refuse_object(shape.name, routine.name, f"line {number}: {text}", 0, _PARAMETER)
            routine = without(routine, number)
            if routine.statements is not None:
                break
        return routine

    def _refuse(self, record: AddOnRecord, reason: str, remedy: str) -> None:
        self._report.objects.append(
            Refusal(self._report.file, record.line, record.name, "", None, 1, "", reason, remedy)
        )


_PARAMETER = "pass it as a parameter"
_DECODE = "export it without source protection, or stub it"
