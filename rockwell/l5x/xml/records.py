"""The parts of an L5X document as plain records; each knows its line.

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
"""An element that holds values."""

_NUMBER = re.compile(r"[0-9]{1,9}")


def number_of(text: str) -> int | None:
    """Return the whole number that an attribute says, of up to 9 digits; None if it says none."""
    return int(text) if _NUMBER.fullmatch(text) else None


@dataclass(frozen=True, slots=True)
class MemberRecord:
    """A member of a data type.

    Attributes:
        type: name of its type, `BIT` for a packed bit.
        dims: length per dimension.
        hidden: whether people do not see it.
        target: of a packed bit: the member in which it lies.
        bit: of a packed bit: its number there.
        wrong_dims: a text in place of dimensions that is not one, "" without one.
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
    """A data type.

    Attributes:
        family: `StringFamily` for a string type.
        members: in order.
        comment: its description.
    """

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
        type: name of its type.
        dims: length per dimension.
        target: of an alias: the address.
        usage: `Input`, `Output`, `InOut`, `Public`, `Local` or "".
        required: whether a call names it.
        comment: its description.
        comments: descriptions of its parts, by what follows its name.
        data: the elements that hold its values, until `L5xDocument.release`.
        wrong_dims: a text in place of dimensions that is not one, "" without one.
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
        number: its number as the document has it, else its place.
        kind: its Type: `N`, or a letter of an edit in progress.
        line: the line on which its text begins.
        texts: how many texts it has; the first one is read.
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
        comment: its description.
        rungs: of a routine of rungs.
        lines: of structured text: text and line.
        target: whether it is what was exported, not context.
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
    """An object whose source is not in the file.

    Attributes:
        kind: `Routine` or `AddOnInstructionDefinition`.
    """

    kind: str
    name: str
    line: int


@dataclass(frozen=True, slots=True)
class AddOnRecord:
    """An add-on instruction.

    Attributes:
        parameters: in order.
        locals: local tags.
        routines: Logic, Prescan, Postscan, EnableInFalse.
        comment: its description.
        encoded: whether its locals and routines are not in the file.
    """

    name: str
    parameters: tuple[TagRecord, ...]
    locals: tuple[TagRecord, ...]
    routines: tuple[RoutineRecord, ...]
    comment: str
    encoded: bool
    line: int


@dataclass(frozen=True, slots=True)
class ProgramRecord:
    """A program.

    Attributes:
        main: its main routine, "" without one.
        fault: its fault routine, "" without one.
        disabled: whether its task leaves it out.
        encoded: its routines whose source is not in the file.
        comment: its description.
    """

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
        programs: in order.
        inhibited: whether it does not run.
        comment: its description.
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
        suffix: what follows the module's name: `I`, `O`, `C`, `I1`.
        kind: `InputTag`, `OutputTag`, `ConfigTag`, `InAliasTag` or `OutAliasTag`.
        comments: descriptions of its parts, by what follows its name.
        data: the elements that hold its values, until `L5xDocument.release`.
        size: bytes of its connection, 0 if the document has no number.
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
        catalog: its catalog number.
        vendor: number of its vendor.
        type: number of its product type.
        code: its product code.
        parent: the module it hangs on.
        address: at its upstream port: a slot or a network address, "" without one.
        bus: type of that port: `ICP`, `Compact`, `PointIO`, `Ethernet`.
        rpi_us: the shortest RPI of its connections, us; 0 without one.
        inhibited: whether it is not connected.
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
        file: its path.
        revision: software revision.
        target: what was exported: `Controller`, `Program`, `Routine`, `Rung`, ...
        name: the controller's name.
        processor: the controller's catalog number.
        data_types: in order.
        add_ons: in order.
        tags: of the controller.
        programs: in order.
        tasks: in order.
        modules: in order.
        others: parts that the import does not read: name and line.
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
        """Release the XML of values, which takes ten times the memory of the rest."""
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
        """Whether it is a whole controller: it has everything that it names."""
        return self.target == "Controller"
