"""Records of an L5X document's parts, each with its line.

Texts are stripped, names keep their case, attributes that are missing are "". `data` is the XML of values,
which `initial_values` reads, see `data`.
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
    wrong_dims: str = ""  # invalid dimensions as text, else ""


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
    required: bool  # whether a call takes an argument for it
    comment: str
    data: list[Data]  # elements with its values, until `L5xDocument.release`
    line: int
    wrong_dims: str = ""  # invalid dimensions as text, else ""
    remote: str = ""  # of a consumed tag: the producer's tag
    rpi: str = ""  # of a consumed tag: its interval, ms
    forced: list[Data] = field(default_factory=list)  # elements with its forces, until `L5xDocument.release`
    access: str = ""  # `Read/Write`, `Read Only`, `None` or ""


@record
class L5xRungRecord:
    """A rung."""

    number: int  # as in the document, else its index
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
        """Return the first child with a tag."""
        return next((child for child in self.children if child.tag == tag), None)


@dataclass(frozen=True, slots=True)
class RoutineRecord:
    """A routine."""

    name: str
    kind: str  # `RLL`, `ST`, `FBD` or `SFC`
    comment: str
    rungs: tuple[L5xRungRecord, ...]
    lines: tuple[tuple[str, int], ...]  # of structured text, in a chart too: text and line
    line: int
    tests_edits: bool = False  # whether its program executes (tests) accepted edits
    texts: tuple[tuple[str, int], ...] = ()  # of structured text under edit: type and line of all texts
    chosen: int = 0  # which of them `lines` are
    chart: ElementRecord | None = None  # the content of a chart or a function block diagram


@dataclass(frozen=True, slots=True)
class EncodedRecord:
    """A `Routine` or `AddOnInstructionDefinition` without its source."""

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
    """A program; `encoded` has its routines without source; a disabled program is skipped by its task."""

    name: str
    main: str
    fault: str
    disabled: bool
    is_phase: bool  # whether it is an equipment phase, whose `main` is the prestate routine
    tags: tuple[TagRecord, ...]
    routines: tuple[RoutineRecord, ...]
    encoded: tuple[EncodedRecord, ...]
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
    rpi_us: int  # the shortest RPI of its connections, us; 0 without one
    tags: tuple[ModuleTagRecord, ...]
    line: int


@dataclass(frozen=True, slots=True)
class L5xDocument:
    """An L5X file."""

    file: str
    revision: str  # software revision
    target: str  # the exported object: `Controller`, `Program`, `Routine`, `Rung`,
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
        """Release the XML of values, which takes ten times the memory of the rest."""
        for owner in self._with_data():
            owner.data.clear()
            owner.forced.clear()

    def _with_data(self) -> Iterator[TagRecord | ModuleTagRecord]:
        yield from self.tags
        for program in self.programs:
            yield from program.tags
        for add_on in self.add_ons:
            yield from (*add_on.parameters, *add_on.locals)
        for module in self.modules:
            yield from module.tags

    @property
    def whole(self) -> bool:
        """Whether it is a whole controller with all its references."""
        return self.target == "Controller"


def lines_of(printed: Iterable[tuple[str, int]]) -> tuple[list[str], list[int]]:
    """Return the lines of structured text, and their numbers in the file."""
    lines: list[str] = []
    numbers: list[int] = []
    for text, number in printed:
        body = text.lstrip("\r\n")
        start = number + text[: len(text) - len(body)].count("\n")
        for offset, part in enumerate(body.rstrip("\r\n").split("\n")):
            lines.append(part.rstrip("\r"))
            numbers.append(start + offset)
    return lines, numbers
