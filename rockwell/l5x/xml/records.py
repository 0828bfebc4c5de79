"""Records of an L5X document's parts, each with its line.

Texts are stripped, names keep their case, attributes that are missing are "". `data` is the XML of values,
which `values` reads.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from lxml.etree import _Element as Element

Data: TypeAlias = Element
"""An element with values."""

_NUMBER = re.compile(r"[0-9]{1,9}")


def number_of(text: str) -> int | None:
    """Return an attribute's whole number of up to 9 digits, else None."""
    return int(text) if _NUMBER.fullmatch(text) else None


@dataclass(frozen=True, slots=True)
class MemberRecord:
    """A member of a data type.

    Attributes:
        type: `BIT` for a packed bit.
        hidden: whether users do not see it.
        target: host member of a packed bit.
        bit: number of a packed bit in its host.
        wrong_dims: invalid dimensions as text, else "".
    """

    name: str
    type: str
    dims: tuple[int, ...]
    hidden: bool
    target: str
    bit: int
    line: int
    wrong_dims: str = ""


@dataclass(frozen=True, slots=True)
class DataTypeRecord:
    """A data type; `family` is `StringFamily` for a string type."""

    name: str
    family: str
    members: tuple[MemberRecord, ...]
    comment: str
    line: int


@dataclass(frozen=True, slots=True)
class TagRecord:
    """A tag, or a parameter or local tag of an add-on instruction.

    Attributes:
        kind: `Base`, `Alias`, `Produced` or `Consumed`.
        target: address of an alias.
        usage: `Input`, `Output`, `InOut`, `Public`, `Local` or "".
        required: whether a call has an argument for it.
        comments: descriptions of parts, by their address after the name.
        data: elements with its values, until `L5xDocument.release`.
        wrong_dims: invalid dimensions as text, else "".
    """

    name: str
    kind: str
    type: str
    dims: tuple[int, ...]
    target: str
    usage: str
    required: bool
    comment: str
    comments: tuple[tuple[str, str], ...]
    data: list[Data]
    line: int
    wrong_dims: str = ""


@dataclass(frozen=True, slots=True)
class L5xRungRecord:
    """A rung.

    Attributes:
        number: as in the document, else its index.
        kind: its Type: `N`, or a letter of an edit in progress.
        line: first line of its text.
        texts: number of its texts; the first one is read.
    """

    number: int
    kind: str
    text: str
    comment: str
    line: int
    texts: int = 1


@dataclass(frozen=True, slots=True)
class RoutineRecord:
    """A routine.

    Attributes:
        kind: `RLL`, `ST`, `FBD` or `SFC`.
        lines: of structured text: text and line.
        target: whether it is the exported object, not context.
    """

    name: str
    kind: str
    comment: str
    rungs: tuple[L5xRungRecord, ...]
    lines: tuple[tuple[str, int], ...]
    target: bool
    line: int


@dataclass(frozen=True, slots=True)
class EncodedRecord:
    """A `Routine` or `AddOnInstructionDefinition` without its source."""

    kind: str
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
    line: int


@dataclass(frozen=True, slots=True)
class ProgramRecord:
    """A program; `encoded` are its routines without source, `disabled` means that its task skips it."""

    name: str
    main: str
    fault: str
    disabled: bool
    tags: tuple[TagRecord, ...]
    routines: tuple[RoutineRecord, ...]
    encoded: tuple[EncodedRecord, ...]
    comment: str
    line: int


@dataclass(frozen=True, slots=True)
class TaskRecord:
    """A task.

    Attributes:
        kind: `CONTINUOUS`, `PERIODIC` or `EVENT`.
        rate: ms, as text.
        priority: as text.
    """

    name: str
    kind: str
    rate: str
    priority: str
    programs: tuple[str, ...]
    inhibited: bool
    comment: str
    line: int


@dataclass(frozen=True, slots=True)
class ModuleTagRecord:
    """A tag of a module.

    Attributes:
        suffix: `I`, `O`, `C`, `I1`.
        kind: `InputTag`, `OutputTag`, `ConfigTag`, `InAliasTag` or `OutAliasTag`.
        comments: descriptions of parts, by their address after the name.
        data: elements with its values, until `L5xDocument.release`.
        size: bytes of its connection, 0 if unknown.
    """

    suffix: str
    kind: str
    comments: tuple[tuple[str, str], ...]
    data: list[Data]
    size: int
    line: int


@dataclass(frozen=True, slots=True)
class ModuleRecord:
    """A module.

    Attributes:
        type: number of its product type.
        code: its product code.
        address: at its upstream port: a slot or a network address, "" without one.
        bus: type of that port: `ICP`, `Compact`, `PointIO`, `Ethernet`.
        rpi_us: the shortest RPI of its connections, us; 0 without one.
    """

    name: str
    catalog: str
    vendor: str
    type: str
    code: str
    parent: str
    address: str
    bus: str
    rpi_us: int
    tags: tuple[ModuleTagRecord, ...]
    inhibited: bool
    line: int


@dataclass(frozen=True, slots=True)
class L5xDocument:
    """An L5X file.

    Attributes:
        revision: software revision.
        target: the exported object: `Controller`, `Program`, `Routine`, `Rung`, ...
        processor: the controller's catalog number.
        others: ignored parts: name and line.
    """

    file: str
    revision: str
    target: str
    name: str
    processor: str
    data_types: tuple[DataTypeRecord, ...]
    add_ons: tuple[AddOnRecord, ...]
    tags: tuple[TagRecord, ...]
    programs: tuple[ProgramRecord, ...]
    tasks: tuple[TaskRecord, ...]
    modules: tuple[ModuleRecord, ...]
    others: tuple[tuple[str, int], ...]

    def release(self) -> None:
        """Release the XML of values, ten times the memory of the rest."""
        for each in self._with_data():
            each.data.clear()

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
