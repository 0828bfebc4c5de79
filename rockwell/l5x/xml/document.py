"""Reads elements into records; `parsing` refuses content that no export has."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, count
from pathlib import Path
from typing import Any

from scanrack.io_images.input_files import open_input
from scanrack.ladder.lowering.addon import ROUTINES

from ..edits import chosen_text
from .data import Data, cut_out
from .elements import (
    children,
    defined,
    defined_routines,
    dims_in,
    is_true,
    line_of_text,
    number_of,
    text_of,
    whole_in,
    wrong_dims,
)
from .parsing import MOST_BYTES, L5xError, checked, parsed, root_of
from .records import (
    AddOnRecord,
    DataTypeRecord,
    ElementRecord,
    EncodedRecord,
    L5xDocument,
    L5xRungRecord,
    MemberRecord,
    ModuleRecord,
    ModuleTagRecord,
    ProgramRecord,
    RoutineRecord,
    TagRecord,
    TaskRecord,
)
from .unread import is_add_on, unread

_KINDS = {"RLLContent": "RLL", "STContent": "ST", "FBDContent": "FBD", "SFCContent": "SFC"}


def read_document(path: Path) -> L5xDocument:
    """Read an L5X file; raise an L5xError if it is not an L5X, or has content that no export has."""
    return parse_document(read_bytes(path), str(path))


def read_bytes(path: Path) -> bytes:
    """Read a file, up to just over the size limit of an L5X; raise an L5xError if that fails."""
    try:
        with open_input(path) as stream:
            return stream.read(MOST_BYTES + 1)
    except OSError as error:
        raise L5xError(str(path), 0, f"it can't be read: {error.strerror}") from None


def checked_bytes(path: Path) -> bytes:
    """Return the bytes of an L5X file; raise an L5xError for the same files as `read_document`."""
    data, file = read_bytes(path), str(path)
    root, _ = _parsed(data, file)
    _controller(root, file)
    return data


def parse_document(data: bytes, file: str) -> L5xDocument:
    """Read the bytes of an L5X file, see `read_document`."""
    root, cut = _parsed(data, file)
    return _L5xReader(file, cut).document(root)


def _parsed(data: bytes, file: str) -> tuple[Any, list[bytes]]:
    """Return the root of a document without its decorated data, and the decorated data; see `data`."""
    text, cut = cut_out(checked(data, file))
    return root_of(text, file), cut


def _controller(root: Any, file: str) -> Any:
    """Return the element of the controller; raise an L5xError if there is none."""
    controller = root.find("Controller")
    if controller is None:
        raise L5xError(file, root.sourceline, "it has no Controller")
    return controller


class _L5xReader:
    """Builds records from elements."""

    def __init__(self, file: str, cut: Sequence[bytes]) -> None:
        self._file, self._cut = file, cut

    def _data(self, element: Any) -> Data:
        return Data(element, self._cut, self._parsed_data)

    def _parsed_data(self, text: bytes, line: int) -> Any:
        return parsed(text, self._file, line)

    def document(self, root: Any) -> L5xDocument:
        """Return the record of the document; raise an L5xError if it has no controller."""
        controller = _controller(root, self._file)
        get = controller.get
        target = root.get("TargetType") or "Controller"
        if target == "Controller" and get("Use", "Target") != "Target":
            target = ""  # an incomplete controller is context only
        groups = controller.iterchildren("AddOnInstructionDefinitions")
        tags = ("AddOnInstructionDefinition", "AddOnInstruction", "EncodedData")
        definitions = chain.from_iterable(group.iterchildren(*tags) for group in groups)
        add_ons = [
            self._add_on(definition)
            for definition in definitions
            if definition.get("Use") != "Reference" and is_add_on(definition)
        ]
        return L5xDocument(
            file=self._file,
            revision=root.get("SoftwareRevision", ""),
            target=target,
            name=get("Name") or root.get("TargetName") or "controller",
            data_types=tuple(map(self._data_type, defined(controller, "DataTypes", "DataType"))),
            add_ons=tuple(add_ons),
            tags=tuple(map(self._tag, defined(controller, "Tags", "Tag"))),
            programs=tuple(map(self._program, children(controller, "Programs", "Program"))),
            tasks=tuple(map(self._task, defined(controller, "Tasks", "Task"))),
            modules=tuple(map(self._module, children(controller, "Modules", "Module"))),
            others=tuple(unread(root)),
            charts=(get("SFCExecutionControl", ""), get("SFCRestartPosition", ""), get("SFCLastScan", "")),
        )

    # --- types and tags

    def _data_type(self, element: Any) -> DataTypeRecord:
        return DataTypeRecord(
            name=element.get("Name", ""),
            members=tuple(map(self._member, children(element, "Members", "Member"))),
            line=element.sourceline,
        )

    def _member(self, element: Any) -> MemberRecord:
        get = element.get
        dims = get("Dimension", get("Dimensions", "")).strip()
        return MemberRecord(
            name=get("Name", ""),
            type=get("DataType", ""),
            dims=dims_in(dims),
            hidden=is_true(get("Hidden", "")),
            target=get("Target", ""),
            bit=whole_in(get("BitNumber", "")),
            wrong_dims=wrong_dims(dims),
        )

    def _tag(self, element: Any) -> TagRecord:
        """Return the record of a tag, or of a parameter or local tag of an add-on instruction."""
        get = element.get
        data: list[Data] = []
        forced: list[Data] = []
        comment = ""
        dims = get("Dimensions", get("Dimension", "")).strip()
        remote = rpi = ""
        for child in element:
            if child.tag == "Data" or child.tag == "DefaultData":
                data.append(self._data(child))
            elif child.tag == "ForceData":
                forced.append(self._data(child))
            elif child.tag == "Description":
                comment = text_of(child)
            elif child.tag == "ConsumeInfo":
                remote, rpi = child.get("RemoteTag", ""), child.get("RPI", "")
        return TagRecord(
            name=get("Name", ""),
            kind=get("TagType", "Base"),
            type=get("DataType", ""),
            dims=dims_in(dims),
            target=get("AliasFor", ""),
            usage=get("Usage", ""),
            required=is_true(get("Required", "")),
            comment=comment,
            data=data,
            line=element.sourceline,
            wrong_dims=wrong_dims(dims),
            remote=remote,
            rpi=rpi,
            forced=forced + [block for block in data if block.shows_forces],
            access=get("ExternalAccess", ""),
        )

    # --- logic

    def _add_on(self, element: Any) -> AddOnRecord:
        """Return the record of an add-on instruction; an encoded one has no local tags or routines."""
        return AddOnRecord(
            name=element.get("Name", ""),
            parameters=tuple(map(self._tag, children(element, "Parameters", "Parameter"))),
            locals=tuple(map(self._tag, children(element, "LocalTags", "LocalTag"))),
            routines=tuple(map(self._routine, children(element, "Routines", "Routine"))),
            comment=text_of(element.find("Description")),
            encoded=element.tag == "EncodedData" or element.find("Routines//EncodedData") is not None,
            switched_off=frozenset(
                routine for routine in ROUTINES if element.get(f"Execute{routine}", "").lower() == "false"
            ),
            line=element.sourceline,
        )

    def _program(self, element: Any) -> ProgramRecord:
        """Return the record of a program or an equipment phase."""
        get = element.get
        tested = is_true(get("TestEdits", ""))
        return ProgramRecord(
            name=get("Name", ""),
            main=get("MainRoutineName") or get("PreStateRoutineName", ""),
            fault=get("FaultRoutineName", ""),
            disabled=is_true(get("Disabled", "")),
            is_phase=get("Type") == "EquipmentPhase",
            tags=tuple(map(self._tag, defined(element, "Tags", "Tag"))),
            routines=tuple(self._routine(routine, tested=tested) for routine in defined_routines(element)),
            encoded=tuple(map(_encoded, element.iterfind("Routines//EncodedData"))),
            line=element.sourceline,
        )

    def _routine(self, element: Any, *, tested: bool = False) -> RoutineRecord:
        """Return the record of a routine, with the version that the controller executes.

        Args:
            tested: whether its program executes (tests) accepted edits.
        """
        rungs = tuple(map(self._rung, children(element, "RLLContent", "Rung"), count()))
        contents = list(element.iterchildren("STContent"))
        types = _edit_types(contents)
        chosen = chosen_text(types, tested=tested)
        content = contents[chosen] if contents else None
        charts = list(element.iterchildren("SFCContent", "FBDContent"))
        chart = charts[chosen_text(_edit_types(charts), tested=tested)] if charts else None
        lines = _text_lines(chart.iter("Line")) if chart is not None else _statement_lines(content)
        kind_by_content = next((_KINDS[child.tag] for child in element if child.tag in _KINDS), "RLL")
        texts = ((kind, int(body.sourceline)) for kind, body in zip(types, contents, strict=True) if kind)
        return RoutineRecord(
            name=element.get("Name", ""),
            kind=element.get("Type") or kind_by_content,
            comment=text_of(element.find("Description")),
            rungs=rungs,
            lines=tuple(lines),
            line=element.sourceline,
            tests_edits=tested,
            texts=tuple(texts),
            chosen=chosen,
            chart=None if chart is None else _element_record(chart),
        )

    def _rung(self, element: Any, index: int) -> L5xRungRecord:
        """Return the record of a rung; `index` is its number if it has none."""
        texts = element.findall("Text")
        text = texts[0] if texts else None
        number = number_of(element.get("Number", ""))
        return L5xRungRecord(
            number=index if number is None else number,
            kind=element.get("Type", "N"),
            text=text_of(text),
            comment=text_of(element.find("Comment")),
            line=element.sourceline if text is None else line_of_text(text),
            texts=len(texts),
        )

    def _task(self, element: Any) -> TaskRecord:
        get = element.get
        programs = children(element, "ScheduledPrograms", "ScheduledProgram")
        return TaskRecord(
            name=get("Name", ""),
            kind=get("Type", "CONTINUOUS").upper(),
            rate=get("Rate", ""),
            priority=get("Priority", ""),
            programs=tuple(program.get("Name", "") for program in programs),
            inhibited=is_true(get("InhibitTask", "")),
            comment=text_of(element.find("Description")),
            line=element.sourceline,
        )

    # --- modules

    def _module(self, element: Any) -> ModuleRecord:
        """Return the record of a module; its upstream port leads to its parent."""
        get = element.get
        ports = list(children(element, "Ports", "Port"))
        upstream = next((port for port in ports if is_true(port.get("Upstream", ""))), None)
        rates = [whole_in(connection.get("RPI", "")) for connection in element.iter("Connection")]
        return ModuleRecord(
            name=get("Name", ""),
            catalog=get("CatalogNumber", ""),
            parent=get("ParentModule", ""),
            address="" if upstream is None else upstream.get("Address", ""),
            bus="" if upstream is None else upstream.get("Type", ""),
            rpi_us=min(filter(None, rates), default=0),
            tags=tuple(self._module_tags(element)),
            line=element.sourceline,
        )

    def _module_tags(self, element: Any) -> Iterator[ModuleTagRecord]:
        """Yield the tags of a module: its configuration, and the inputs and outputs of its connections."""
        for communications in element.iterchildren("Communications"):
            for tag in communications.iterchildren("ConfigTag"):
                yield self._module_tag(tag, "C", tag.get("ConfigSize", ""))
            for connection in communications.iter("Connection", "RackConnection"):
                for tag in connection.iterchildren("InputTag", "OutputTag", "InAliasTag", "OutAliasTag"):
                    direction = "I" if tag.tag in ("InputTag", "InAliasTag") else "O"
                    suffix_key = "InputTagSuffix" if direction == "I" else "OutputTagSuffix"
                    size_key = "InputSize" if direction == "I" else "OutputSize"
                    size = connection.get(size_key) or communications.get(f"PrimCxn{size_key}", "")
                    yield self._module_tag(tag, connection.get(suffix_key) or direction, size)

    def _module_tag(self, element: Any, suffix: str, size: str) -> ModuleTagRecord:
        """Return the record of a module's tag; `size` is the text of its connection's size."""
        data = list(map(self._data, element.iterchildren("Data")))
        forced = list(map(self._data, element.iterchildren("ForceData")))
        return ModuleTagRecord(
            suffix=suffix,
            kind=element.tag,
            data=data,
            size=whole_in(size),
            line=element.sourceline,
            forced=forced + [block for block in data if block.shows_forces],
        )


DEEPEST = 8
"""Maximum depth of the elements of a chart that are read; a line of an action is at depth 5."""


def _edit_types(contents: Iterable[Any]) -> list[str]:
    """Return the edit type of each version of a routine's content; "" for a version that is not edited."""
    return [content.get("OnlineEditType", "") for content in contents]


def _text_lines(elements: Iterable[Any]) -> list[tuple[str, int]]:
    """Return the text and the line of each element."""
    return [("".join(element.itertext()), int(element.sourceline)) for element in elements]


def _statement_lines(content: Any) -> list[tuple[str, int]]:
    """Return the lines of structured text; software other than Studio 5000 writes it without `Line`."""
    lines = _text_lines(children(content, "Line"))
    if content is not None and not lines:
        lines = [(content.text or "", int(content.sourceline))]
    return lines


def _element_record(element: Any, depth: int = 0) -> ElementRecord:
    """Return the record of an element and of the elements in it, up to `DEEPEST` levels."""
    elements = element.iterchildren("*") if depth < DEEPEST else ()
    text = text_of(element.find("Text")) if element.tag == "TextBox" else (element.text or "")
    inner = tuple(_element_record(child, depth + 1) for child in elements)
    return ElementRecord(element.tag, dict(element.attrib), text, inner, int(element.sourceline or 0))


def _encoded(element: Any) -> EncodedRecord:
    return EncodedRecord(element.get("Name", ""), element.sourceline)
