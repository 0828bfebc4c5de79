"""Records of an L5X document's parts, each with its line.

Texts are stripped, and names keep their case. Missing attributes are "".
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from lxml.etree import _Element
from scanrack.io_images.records import record

from .data import Data

Element: TypeAlias = _Element
"""An element with values."""


@record
class MemberRecord:
    """A member of a data type."""

    name: str
    type: str  # `BIT` for a packed bit
    dims: tuple[int, ...]
    hidden: bool  # whether it is hidden from users
    target: str  # host member of a packed bit
    bit: int  # number of a packed bit in its host
    wrong_dims: str = ""  # invalid dimensions as text; "" if they are valid


@dataclass(frozen=True, slots=True)
class DataTypeRecord:
    """A data type."""

    name: str
    members: tuple[MemberRecord, ...]
    line: int


@record
class TagRecord:
    """A tag, or a parameter or local tag of an add-on instruction."""

    name: str
    kind: str  # `Base`, `Alias`, `Produced` or `Consumed`
    type: str
    dims: tuple[int, ...]
    target: str  # address of an alias
    usage: str  # `Input`, `Output`, `InOut`, `Public`, `Local` or ""
    required: bool  # whether a call needs an argument for it
    comment: str
    data: list[Data]  # elements with its values, until `L5xDocument.release`
    line: int
    wrong_dims: str = ""  # invalid dimensions as text; "" if they are valid
    remote: str = ""  # of a consumed tag: the producer's tag
    rpi: str = ""  # of a consumed tag: its RPI in ms, as text
    forced: list[Data] = field(default_factory=list)  # elements with its forces, until `L5xDocument.release`
    access: str = ""  # `Read/Write`, `Read Only`, `None` or ""


@record
class L5xRungRecord:
    """A rung."""

    number: int  # in the document; its index if it has none
    kind: str  # its Type: `N`, or the letters of an edit in progress, see `edits`
    text: str
    comment: str
    line: int  # first line of its text
    texts: int = 1  # number of its texts; the first one is read


@dataclass(frozen=True, slots=True)
class ElementRecord:
    """An element of a chart or a diagram, with the elements inside it."""

    tag: str
    attributes: Mapping[str, str]
    text: str
    children: tuple[ElementRecord, ...]
    line: int

    def child(self, tag: str) -> ElementRecord | None:
        """Return the first child with the given tag."""
        return next((child for child in self.children if child.tag == tag), None)


@dataclass(frozen=True, slots=True)
class RoutineRecord:
    """A routine."""

    name: str
    kind: str  # `RLL`, `ST`, `FBD` or `SFC`
    comment: str
    rungs: tuple[L5xRungRecord, ...]
    lines: tuple[tuple[str, int], ...]  # of structured text, also in a chart: text and line
    line: int
    tests_edits: bool = False  # whether its program executes (tests) accepted edits
    texts: tuple[tuple[str, int], ...] = ()  # versions of structured text under edit: type and line
    chosen: int = 0  # index of the version in `lines`
    chart: ElementRecord | None = None  # the content of a chart or a function block diagram


@dataclass(frozen=True, slots=True)
class EncodedRecord:
    """A routine without its source."""

    name: str
    line: int


@dataclass(frozen=True, slots=True)
class AddOnRecord:
    """An add-on instruction; an encoded one lacks locals and routines."""

    name: str
    parameters: tuple[TagRecord, ...]
    locals: tuple[TagRecord, ...]
    routines: tuple[RoutineRecord, ...]
    comment: str
    encoded: bool
    switched_off: frozenset[str]  # names of routines that the definition has but does not run
    line: int


@dataclass(frozen=True, slots=True)
class ProgramRecord:
    """A program."""

    name: str
    main: str  # the main routine; for an equipment phase the prestate routine
    fault: str
    disabled: bool  # whether its task skips it
    is_phase: bool  # whether it is an equipment phase
    tags: tuple[TagRecord, ...]
    routines: tuple[RoutineRecord, ...]
    encoded: tuple[EncodedRecord, ...]  # routines without source
    line: int


@dataclass(frozen=True, slots=True)
class TaskRecord:
    """A task."""

    name: str
    kind: str  # `CONTINUOUS`, `PERIODIC` or `EVENT`
    rate: str  # ms, as text
    priority: str  # as text
    programs: tuple[str, ...]
    inhibited: bool
    comment: str
    line: int


@dataclass(frozen=True, slots=True)
class ModuleTagRecord:
    """A tag of a module."""

    suffix: str  # `I`, `O`, `C`, `I1`
    kind: str  # `InputTag`, `OutputTag`, `ConfigTag`, `InAliasTag` or `OutAliasTag`
    data: list[Data]  # elements with its values, until `L5xDocument.release`
    size: int  # bytes of its connection, 0 if unknown
    line: int
    forced: list[Data] = field(default_factory=list)  # elements with its forces, until `L5xDocument.release`


@dataclass(frozen=True, slots=True)
class ModuleRecord:
    """A module."""

    name: str
    catalog: str
    parent: str
    address: str  # at its upstream port: a slot or a network address; "" if it has none
    bus: str  # type of that port: `ICP`, `Compact`, `PointIO`, `Ethernet`
    rpi_us: int  # the shortest RPI of its connections, µs; 0 without one
    tags: tuple[ModuleTagRecord, ...]
    line: int


@dataclass(frozen=True, slots=True)
class L5xDocument:
    """An L5X file."""

    file: str
    revision: str  # software revision
    target: str  # type of the exported object, as `Controller` or `Routine`; "" for an incomplete controller
    name: str
    data_types: tuple[DataTypeRecord, ...]
    add_ons: tuple[AddOnRecord, ...]
    tags: tuple[TagRecord, ...]
    programs: tuple[ProgramRecord, ...]
    tasks: tuple[TaskRecord, ...]
    modules: tuple[ModuleRecord, ...]
    others: tuple[tuple[str, str, int], ...]  # parts that are not read: name, description, line
    charts: tuple[str, str, str] = ("", "", "")  # SFCExecutionControl, SFCRestartPosition, SFCLastScan

    def routines(self) -> Iterator[tuple[str, RoutineRecord]]:
        """Yield the routines of programs and add-on instructions, each with the name of its owner."""
        owners: tuple[ProgramRecord | AddOnRecord, ...] = (*self.programs, *self.add_ons)
        for owner in owners:
            yield from ((owner.name, routine) for routine in owner.routines)

    def release(self) -> None:
        """Release the XML of values, which uses ten times the memory of everything else."""
        for owner in self._with_data():
            owner.data.clear()
            owner.forced.clear()

    def _with_data(self) -> Iterator[TagRecord | ModuleTagRecord]:
        """Yield the records that refer to the XML of their values: tags, parameters and module tags."""
        yield from self.tags
        for program in self.programs:
            yield from program.tags
        for add_on in self.add_ons:
            yield from (*add_on.parameters, *add_on.locals)
        for module in self.modules:
            yield from module.tags

    @property
    def whole(self) -> bool:
        """Whether the file contains a whole controller, and therefore defines every name that it uses."""
        return self.target == "Controller"


def lines_of(texts_with_lines: Iterable[tuple[str, int]]) -> tuple[list[str], list[int]]:
    """Return the lines of structured text, and their numbers in the file."""
    lines: list[str] = []
    numbers: list[int] = []
    for text, number in texts_with_lines:
        body = text.lstrip("\r\n")
        first_number = number + text[: len(text) - len(body)].count("\n")
        for line_number, line in enumerate(body.rstrip("\r\n").split("\n"), start=first_number):
            lines.append(line.rstrip("\r"))
            numbers.append(line_number)
    return lines, numbers
