"""Add-on instructions of a document."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from scanrack.ladder.instructions import BY_NAME
from scanrack.ladder.instructions.addons import ADD_ON_CALL, with_off_calls
from scanrack.ladder.lowering.addon import (
    ENABLES,
    LOGIC,
    OTHERWISE,
    ROUTINES,
    AddOn,
    Parameter,
    ParameterMode,
)
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.expressions import parse_address
from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.spec import Spec, Use
from scanrack.ladder.model.tags import Tag
from scanrack.ladder.model.types import MAX_DIMENSIONS, Structure

from .assembly import emptied
from .report import Refusal, Report
from .routines import RoutineReader
from .scopes import read_initial
from .values.datatypes import NAME, Types
from .xml.records import AddOnRecord, TagRecord

_MODES = {"INPUT": ParameterMode.INPUT, "OUTPUT": ParameterMode.OUTPUT, "INOUT": ParameterMode.INOUT}


class AddOns:
    """The add-on instructions of a document, built on demand."""

    def __init__(self, records: tuple[AddOnRecord, ...], types: Types, report: Report) -> None:
        """Find the add-ons by name, and make their types available to `types`."""
        self.records: dict[str, AddOnRecord] = {}  # by name in capitals; the first with each name
        self._duplicates: list[AddOnRecord] = []  # later records with a name in `records`; they are refused
        for record in records:
            if self.records.setdefault(record.name.upper(), record) is not record:
                self._duplicates.append(record)
        self._types, self._report = types, report
        # each of these by name in capitals:
        self._shapes: dict[str, AddOn] = {}  # without logic, see `shape`
        self._errors: dict[str, str] = {}  # why an add-on is unusable
        self._routines: dict[str, list[Routine]] = {}
        self._generated: dict[str, list[Tag]] = {}  # tags generated for diagrams
        self.built: dict[str, AddOn] = {}  # with logic, see `build`
        types.add_on = self.structure

    def structure(self, name: str) -> Structure | None:
        """Return the type of an add-on's instances; None if there is no such add-on."""
        return self.shape(name).structure if name in self.records else None

    def shape(self, name: str) -> AddOn:
        """Return an add-on, without logic, by its name in capitals; raise a LadderError if it is unusable."""
        if name in self._errors:
            raise LadderError(self._errors[name])
        if name not in self._shapes:
            record = self.records[name]
            try:
                if name in BY_NAME:
                    raise LadderError(f"{record.name} is an instruction here, and an add-on in the file")
                if not NAME.fullmatch(record.name):
                    raise LadderError(f"{record.name!r} is not a name of an add-on")
                parameters = tuple(self._parameters(record))
                shape = AddOn(record.name, parameters, (Routine(LOGIC, ()),), record.comment)
                self._types.refuse_size(shape.structure)
                if not record.encoded:
                    generated = frozenset(tag.name for tag in self._generated.get(name, ()))
                    self._types.layouts.add_ons[name] = generated
                self._shapes[name] = shape
            except LadderError as error:
                self._errors[name] = str(error)
                raise
        return self._shapes[name]

    def specs(self) -> Mapping[str, Spec]:
        """Return all instruction specs by name in capitals."""
        return {
            **BY_NAME,
            **with_off_calls({name: _spec_of(record) for name, record in self.records.items()}),
        }

    def arguments(self, name: str) -> tuple[TagRecord, ...] | None:
        """Return the parameters of an add-on that need an argument, in call order; None if it is unknown."""
        record = self.records.get(name.upper())
        return None if record is None else tuple(arguments_of(record))

    def acts_when_off(self, name: str) -> bool:
        """Return whether an add-on has logic for a false EnableIn."""
        record = self.records.get(name.upper())
        if record is None or OTHERWISE in record.switched_off:
            return False
        return any(routine.name.upper() == OTHERWISE.upper() for routine in record.routines)

    def outputs(self, name: str) -> frozenset[str]:
        """Return the names of an add-on's outputs, in capitals."""
        record = self.records.get(name.upper())
        parameters = record.parameters if record else ()
        return frozenset(
            parameter.name.upper() for parameter in parameters if _mode_of(parameter) is ParameterMode.OUTPUT
        )

    def _parameters(self, record: AddOnRecord) -> Iterator[Parameter]:
        """Yield an add-on's parameters, its local tags, and the tags generated for its diagrams."""
        for parameter in _own_parameters(record):
            yield self._parameter(parameter, _mode_of(parameter))
        for parameter in record.locals:
            yield self._parameter(parameter, ParameterMode.LOCAL)
        for tag in self._generated.get(record.name.upper(), ()):
            yield Parameter(tag.name, tag.type, ParameterMode.LOCAL)

    def _parameter(self, record: TagRecord, mode: ParameterMode) -> Parameter:
        """Return a parameter or local tag; raise a LadderError for an invalid name or dimensions."""
        if not NAME.fullmatch(record.name):
            raise LadderError(f"{record.name!r} is not a name of a parameter")
        if len(record.dims) > MAX_DIMENSIONS:
            raise LadderError(f"{record.name} has more than {MAX_DIMENSIONS} dimensions")
        if record.wrong_dims or min(record.dims, default=1) < 1:
            raise LadderError(f"{record.name} has dimensions {record.wrong_dims or record.dims}")
        if record.target:
            return self._alias(record, mode)
        kind = self._types.find(record.type)
        initial = None
        if mode is not ParameterMode.INOUT:
            loss = "its default is not used"
            initial = read_initial(record, kind, self._types, self._report, record.name, consequence=loss)
        return Parameter(record.name, kind, mode, record.dims, record.required, record.comment, initial)

    def _alias(self, record: TagRecord, mode: ParameterMode) -> Parameter:
        """Return a parameter that is an alias of a part of another parameter; its default type is BOOL."""
        parse_address(record.target)  # raises a LadderError for a text that is no address
        kind = self._types.find(record.type or "BOOL")
        return Parameter(
            record.name, kind, mode, record.dims, record.required, record.comment, at=record.target
        )

    def read(self, reader: RoutineReader) -> None:
        """Read the logic of all add-ons; their types need not be defined yet."""
        for name, record in self.records.items():
            inouts = {
                parameter.name.upper()
                for parameter in record.parameters
                if _mode_of(parameter) is ParameterMode.INOUT
            }
            routines = [reader.routine(record.name, routine, inouts) for routine in record.routines]
            self._routines[name] = [routine for routine in routines if routine is not None]
            self._generated[name] = reader.generated(record.name)
        for record in self._duplicates:
            text = f"the file has two add-ons {record.name}; the first one is used"
            self._refuse(record, text, _RENAME)
            for routine in record.routines:
                reader.skipped(record.name, routine, text, _RENAME)

    def routines(self) -> Iterator[tuple[str, Routine]]:
        """Yield the routines read so far, each with the name of its add-on."""
        for name, routines in self._routines.items():
            yield from ((self.records[name].name, routine) for routine in routines)

    def build(self, reader: RoutineReader) -> Mapping[str, str]:
        """Build the add-ons; return why the unusable ones can't be called, by name in capitals.

        An encoded add-on is built without logic, so its type is defined.
        """
        withheld: dict[str, str] = {}
        self._errors.clear()  # types may have been defined since
        self._shapes.clear()
        for name, record in self.records.items():
            if record.encoded:
                self._refuse(record, _ENCODED, _DECODE)
                if not record.parameters:
                    withheld[name] = _ENCODED
                    continue
            try:
                self.built[name] = self._with_logic(self.shape(name), self._routines[name], reader)
            except LadderError as error:
                withheld[name] = f"this add-on can't be used: {error}"
                self._refuse(record, str(error), _CORRECT)
                for routine in record.routines:
                    for number in range(len(routine.rungs)):
                        reader.refuse(record.name, routine.name, number, withheld[name], _CORRECT)
        return withheld

    def _with_logic(self, shape: AddOn, logic: Iterable[Routine], reader: RoutineReader) -> AddOn:
        """Return an add-on with only the routines that run."""
        record = self.records[shape.name.upper()]
        routines = []
        for routine in logic:
            role = next((role for role in ROUTINES if role.upper() == routine.name.upper()), None)
            if role in record.switched_off and (routine.rungs or routine.statements):
                text = f"its routine {role} does not run: Execute{role} is false"
                self._report.note(record.name, text, record.line)
            elif role is not None:
                routines.append(self._without_forbidden(shape, replace(routine, name=role), reader))
        if not any(routine.name == LOGIC for routine in routines):
            routines.insert(0, Routine(LOGIC, ()))
        return shape.with_routines(tuple(routines))

    def _without_forbidden(self, shape: AddOn, routine: Routine, reader: RoutineReader) -> Routine:
        """Refuse and remove everything in a routine that an add-on instruction can't contain."""
        for site, text in list(shape.problems_in(routine)):
            number = site.rung or 0
            if routine.statements is None:
                reader.refuse(shape.name, routine.name, number, text, _PARAMETER, site)
            else:
                place, line = reader.place_of(shape.name, routine.name, number)
                reader.refuse_object(shape.name, routine.name, f"{place}: {text}", line, _PARAMETER)
            routine = emptied(routine, number)
            if routine.statements is not None:  # all statements are removed
                break
        return routine

    def _refuse(self, record: AddOnRecord, reason: str, remedy: str) -> None:
        self._report.objects.append(
            Refusal(self._report.file, record.line, record.name, "", None, 1, "", reason, remedy)
        )


def arguments_of(record: AddOnRecord) -> Iterator[TagRecord]:
    """Yield the parameters that need an argument, in call order."""
    for parameter in _own_parameters(record):
        if parameter.required or _mode_of(parameter) is ParameterMode.INOUT:
            yield parameter


def _own_parameters(record: AddOnRecord) -> Iterator[TagRecord]:
    """Yield the parameters of a definition, except EnableIn and EnableOut."""
    enables = [enable.upper() for enable in ENABLES]
    yield from (parameter for parameter in record.parameters if parameter.name.upper() not in enables)


def _mode_of(parameter: TagRecord) -> ParameterMode:
    return _MODES.get(parameter.usage.upper(), ParameterMode.INPUT)


def _spec_of(record: AddOnRecord) -> Spec:
    """Return the spec for calls of an add-on: the instance, then its arguments."""
    arguments = (Use.ARGUMENT for _ in arguments_of(record))
    return replace(ADD_ON_CALL, name=record.name, operands=(Use.INSTANCE, *arguments))


_ENCODED = "the source of this add-on is encoded, so it is not in the file"
_CORRECT = "correct the definition"
_RENAME = "rename or remove it"
_PARAMETER = "pass it as a parameter"
_DECODE = "export it without source protection, or stub it"
