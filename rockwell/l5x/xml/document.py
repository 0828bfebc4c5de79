"""The XML reader. An L5X is untrusted: anything no export has is refused before or during parsing.

| refused | why |
|---|---|
| more than 64 MiB, or `MOST_MARKS` tags, attributes and texts | memory |
| a DOCTYPE | entities, external files; no export has one |
| elements more than 256 deep | libxml2's limit without `huge_tree` |
| bytes that are neither UTF-8 nor UTF-16, nor the encoding that the file declares | its text is unknown |
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any

from lxml import etree

from ....io_images.input_files import open_input
from ....io_images.site import Site
from ....ladder.lowering.addon import ROUTINES
from ....ladder.model.errors import LadderError
from ..edits import chosen_text
from .data import Data, cut_out
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

MOST_BYTES = 64 << 20
"""Maximum bytes of a file."""

MOST_MARKS = 1_350_000
"""Maximum tags, attributes and texts: libxml2 takes up to 260 bytes for each."""

ROOT = "RSLogix5000Content"

_BOMS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_DECLARED = re.compile(rb"""<\?xml[^>]{0,200}?encoding\s*=\s*["']([A-Za-z0-9._-]{1,40})["']""")
_ENCODINGS = {"iso-8859-1": "latin-1", "windows-1252": "cp1252", "us-ascii": "ascii"}
_PROLOG = re.compile(rb"\s+|<\?.*?\?>|<!--.*?-->", re.DOTALL)
_TEXT = re.compile(rb">\s*+[^<\s]")
_ZERO = re.compile(
    rb'<Element Index="\[[0-9,]{1,30}\]" Value="(?:0|0\.0|0\.0{8}e\+0{3}|(?:2|8|16)#[0_]{1,100})"/>'
)
"""An array element equal to the default."""

_NUMBER = re.compile(r"\d{1,9}")


class L5xError(LadderError):
    """An unusable L5X; the message has file and line."""

    def __init__(self, file: str, line: int, text: str) -> None:
        site = Site(file=file, line=line)
        super().__init__(f"{site.spot}: {text}", site)


def read_document(path: Path) -> L5xDocument:
    """Read an L5X file; an L5xError if it is not one, or has parts that no export has."""
    try:
        with open_input(path) as stream:
            data = stream.read(MOST_BYTES + 1)
    except OSError as error:
        raise L5xError(str(path), 0, f"it can't be read: {error.strerror}") from None
    return parse_document(data, str(path))


def parse_document(data: bytes, file: str) -> L5xDocument:
    """Read the bytes of an L5X file, see `read_document`."""
    text, cut = cut_out(_checked(data, file))
    del data
    root = _parsed(text, file)
    if root.tag != ROOT:
        raise L5xError(file, root.sourceline or 1, f"its root is {root.tag}, that of an L5X is {ROOT}")
    return _L5xReader(file, cut).document(root)


def whole_tree(data: bytes) -> Any:
    """Return the root of an L5X that is to be written again: as it is, with its sections of character data.

    Raises:
        L5xError: it can't be read, or is larger than what can be imported.
    """
    _checked(data, "the L5X")
    parser = etree.XMLParser(
        strip_cdata=False, resolve_entities=False, load_dtd=False, no_network=True, huge_tree=False
    )
    try:
        return etree.fromstring(data.removeprefix(codecs.BOM_UTF8).lstrip(), parser)  # blanks may lead
    except etree.XMLSyntaxError as error:
        raise L5xError("the L5X", error.lineno or 1, f"it is not XML: {error.msg}") from None


def _checked(data: bytes, file: str) -> bytes:
    """Return a document's bytes as UTF-8, or raise an L5xError for what no export has."""
    if len(data) > MOST_BYTES:
        raise L5xError(file, 0, f"it has more than {MOST_BYTES:,} bytes")
    data = _as_utf8(data, file)
    marks = _marks(data)
    if marks > MOST_MARKS:
        data = _ZERO.sub(b"", data)  # large controllers consist mostly of arrays of zeros
        marks = _marks(data)
    if marks > MOST_MARKS:
        raise L5xError(file, 0, f"it has {marks:,} tags, attributes and texts; {MOST_MARKS:,} are allowed")
    _refuse_doctype(data, file)
    return data


@cache
def _parser() -> Any:
    return etree.XMLParser(
        encoding="utf-8", resolve_entities=False, load_dtd=False, no_network=True, huge_tree=False
    )


def _parsed(data: bytes, file: str, line: int = 1) -> Any:
    """Return the root of a document, or of a part that begins on a line."""
    try:
        return etree.fromstring(data, _parser())
    except etree.XMLSyntaxError as error:
        raise L5xError(file, line - 1 + (error.lineno or 1), f"it is not XML: {error.msg}") from None
    except ValueError as error:
        raise L5xError(file, line, f"it is not XML: {error}") from None


def _marks(data: bytes) -> int:
    """Count tags, attributes and texts; more than the limit only if there are more."""
    tags, attributes = data.count(b"<"), data.count(b"=")
    if 2 * tags + attributes <= MOST_MARKS:  # at most one text behind each tag
        return tags + attributes
    return tags + attributes + sum(1 for _ in _TEXT.finditer(data))


def _as_utf8(data: bytes, file: str) -> bytes:
    """Decode: by byte order mark, UTF-16 zeros or the declaration, else UTF-8."""
    encoding = next((name for mark, name in _BOMS if data.startswith(mark)), None)
    if encoding is None and data[:2] in (b"<\0", b"\0<"):
        encoding = "utf-16-le" if data[:1] == b"<" else "utf-16-be"
    if encoding is None:
        declared = _DECLARED.match(data.lstrip()[:300])
        name = declared.group(1).decode("ascii").lower() if declared else ""
        encoding = _ENCODINGS.get(name, "utf-8")
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise L5xError(file, line, f"it is not {encoding.upper()} text: {error.reason}") from None
    if encoding == "utf-8":
        return data.removeprefix(codecs.BOM_UTF8).lstrip()
    return text.removeprefix("\ufeff").lstrip().encode("utf-8")


def _refuse_doctype(data: bytes, file: str) -> None:
    at = 0
    while found := _PROLOG.match(data, at):
        at = found.end()
    if data.startswith(b"<!", at):
        line = data.count(b"\n", 0, at) + 1
        raise L5xError(file, line, "it has a DOCTYPE; no export of an L5X has one")


# --- elements


def _text(element: Any) -> str:
    """Return the text of an element, the first language's if there are several."""
    if element is None:
        return ""
    if not len(element):
        return (element.text or "").strip()
    inner = next(iter(element), None)
    chosen = inner if inner is not None and isinstance(inner.tag, str) else element
    return "".join(chosen.itertext()).strip()


_DIMS = re.compile(r"\d{1,9}(?:[\s,]+\d{1,9})*")


def _dims(text: str) -> tuple[int, ...]:
    """Return dimensions: `4 3 2`, `4,3,2`; `0` and "" mean none."""
    lengths = tuple(map(int, _NUMBER.findall(text))) if _DIMS.fullmatch(text) else ()
    return lengths if any(lengths) else ()


def _wrong_dims(text: str) -> str:
    """Return a text that is no list of dimensions, else ""."""
    return "" if not text or _DIMS.fullmatch(text) else text


def _is_true(text: str) -> bool:
    return text.lower() in ("true", "1")


def _whole(text: str) -> int:
    return int(text) if _NUMBER.fullmatch(text) else 0


def _children(element: Any, *path: str) -> Iterator[Any]:
    """Yield the children at the end of a path of names."""
    if element is None:
        return
    *outer, name = path
    for each in element.iterchildren(outer[0] if outer else name):
        if outer:
            yield from _children(each, *path[1:])
        else:
            yield each


def _defined(element: Any, *path: str) -> Iterator[Any]:
    """Yield the children of an element that a partial export defines."""
    yield from (each for each in _children(element, *path) if each.get("Use") != "Reference")


def _defined_routines(program: Any) -> Iterator[Any]:
    """Yield the routines that a partial export defines: what is context without a content is only named."""
    for each in _defined(program, "Routines", "Routine"):
        if each.get("Use") != "Context" or any(str(part.tag).endswith("Content") for part in each):
            yield each


def _line_of_text(element: Any) -> int:
    """Return the line of an element's text, after white space."""
    text = element.text or ""
    return int(element.sourceline or 0) + text[: len(text) - len(text.lstrip())].count("\n")


_READ = frozenset(
    {
        *("DataTypes", "Modules", "AddOnInstructionDefinitions", "Tags", "Programs", "Tasks", "Description"),
        *("RedundancyInfo", "Security", "SafetyInfo", "CST", "WallClockTime", "TimeSynchronize"),
        *("CommPorts", "EthernetPorts", "EthernetNetwork", "Trends", "QuickWatchLists", "AddOnDefinitions"),
        *("InternetProtocol", "DataLogs", "Timelines", "Commands", "CustomProperties"),
    }
)
"""Children of a controller that are read, or irrelevant to logic."""


class _L5xReader:
    """Builds records from elements."""

    def __init__(self, file: str, cut: Sequence[bytes]) -> None:
        self._file, self._cut = file, cut

    def _data(self, element: Any) -> Data:
        return Data(element, self._cut, self._part)

    def _part(self, text: bytes, line: int) -> Any:
        return _parsed(text, self._file, line)

    def document(self, root: Any) -> L5xDocument:
        controller = root.find("Controller")
        if controller is None:
            raise L5xError(self._file, root.sourceline, "it has no Controller")
        get = controller.get
        target = root.get("TargetType") or "Controller"
        if target == "Controller" and get("Use", "Target") != "Target":
            target = ""  # an incomplete controller is context only
        add_ons = [
            self._add_on(each)
            for group in controller.iterchildren("AddOnInstructionDefinitions")
            for each in group.iterchildren("AddOnInstructionDefinition", "AddOnInstruction", "EncodedData")
            if each.get("Use") != "Reference"
        ]
        others = [
            (str(each.tag), int(each.sourceline))
            for each in chain(controller.iterchildren(), controller.iterfind("SafetyInfo/SafetyTagMap"))
            if isinstance(each.tag, str) and each.tag not in _READ
        ]
        return L5xDocument(
            self._file,
            root.get("SoftwareRevision", ""),
            target,
            get("Name") or root.get("TargetName") or "controller",
            get("ProcessorType", ""),
            tuple(map(self._data_type, _defined(controller, "DataTypes", "DataType"))),
            tuple(add_ons),
            tuple(map(self._tag, _defined(controller, "Tags", "Tag"))),
            tuple(map(self._program, _children(controller, "Programs", "Program"))),
            tuple(map(self._task, _defined(controller, "Tasks", "Task"))),
            tuple(map(self._module, _children(controller, "Modules", "Module"))),
            tuple(others),
            (get("SFCExecutionControl", ""), get("SFCRestartPosition", ""), get("SFCLastScan", "")),
        )

    # --- types and tags

    def _data_type(self, element: Any) -> DataTypeRecord:
        return DataTypeRecord(
            element.get("Name", ""),
            element.get("Family", ""),
            tuple(map(self._member, _children(element, "Members", "Member"))),
            _text(element.find("Description")),
            element.sourceline,
        )

    def _member(self, element: Any) -> MemberRecord:
        get = element.get
        dims = get("Dimension", get("Dimensions", "")).strip()
        return MemberRecord(
            get("Name", ""),
            get("DataType", ""),
            _dims(dims),
            _is_true(get("Hidden", "")),
            get("Target", ""),
            _whole(get("BitNumber", "")),
            element.sourceline,
            _wrong_dims(dims),
        )

    def _tag(self, element: Any) -> TagRecord:
        get = element.get
        data: list[Data] = []
        forced: list[Data] = []
        comment = ""
        comments: tuple[tuple[str, str], ...] = ()
        dims = get("Dimensions", get("Dimension", "")).strip()
        remote = rpi = ""
        for each in element:
            if each.tag == "Data" or each.tag == "DefaultData":
                data.append(self._data(each))
            elif each.tag == "ForceData":
                forced.append(self._data(each))
            elif each.tag == "Description":
                comment = _text(each)
            elif each.tag == "Comments":
                comments = _comments(each)
            elif each.tag == "ConsumeInfo":
                remote, rpi = each.get("RemoteTag", ""), each.get("RPI", "")
        return TagRecord(
            get("Name", ""),
            get("TagType", "Base"),
            get("DataType", ""),
            _dims(dims),
            get("AliasFor", ""),
            get("Usage", ""),
            _is_true(get("Required", "")),
            comment,
            comments,
            data,
            element.sourceline,
            _wrong_dims(dims),
            remote,
            rpi,
            forced + [each for each in data if each.shows_forces],
            get("ExternalAccess", ""),
        )

    # --- logic

    def _add_on(self, element: Any) -> AddOnRecord:
        encoded = element.tag == "EncodedData"
        return AddOnRecord(
            element.get("Name", ""),
            tuple(map(self._tag, _children(element, "Parameters", "Parameter"))),
            tuple(map(self._tag, _children(element, "LocalTags", "LocalTag"))),
            tuple(map(self._routine, _children(element, "Routines", "Routine"))),
            _text(element.find("Description")),
            encoded or element.find("Routines/EncodedData") is not None,
            frozenset(each for each in ROUTINES if element.get(f"Execute{each}", "").lower() == "false"),
            element.sourceline,
        )

    def _program(self, element: Any) -> ProgramRecord:
        get = element.get
        tested = _is_true(get("TestEdits", ""))
        return ProgramRecord(
            get("Name", ""),
            get("MainRoutineName") or get("PreStateRoutineName", ""),
            get("FaultRoutineName", ""),
            _is_true(get("Disabled", "")),
            get("Type") == "EquipmentPhase",
            tuple(map(self._tag, _defined(element, "Tags", "Tag"))),
            tuple(self._routine(each, tested=tested) for each in _defined_routines(element)),
            tuple(map(_encoded, _children(element, "Routines", "EncodedData"))),
            _text(element.find("Description")),
            element.sourceline,
        )

    def _routine(self, element: Any, *, tested: bool = False) -> RoutineRecord:
        rungs = [
            self._rung(each, place) for place, each in enumerate(_children(element, "RLLContent", "Rung"))
        ]
        contents = list(element.iterchildren("STContent"))
        types = [each.get("OnlineEditType", "") for each in contents]
        chosen = chosen_text(types, tested=tested)
        content = contents[chosen] if contents else None
        charts = list(element.iterchildren("SFCContent", "FBDContent"))
        edits = [each.get("OnlineEditType", "") for each in charts]
        chart = charts[chosen_text(edits, tested=tested)] if charts else None
        lines = [("".join(each.itertext()), int(each.sourceline)) for each in _children(content, "Line")]
        if content is not None and not lines:  # by other programs than Studio 5000
            lines = [(content.text or "", int(content.sourceline))]
        if chart is not None:
            lines = [("".join(each.itertext()), int(each.sourceline)) for each in chart.iter("Line")]
        kinds = {"RLLContent": "RLL", "STContent": "ST", "FBDContent": "FBD", "SFCContent": "SFC"}
        found = next((kinds[each.tag] for each in element if each.tag in kinds), "RLL")
        return RoutineRecord(
            element.get("Name", ""),
            element.get("Type") or found,
            _text(element.find("Description")),
            tuple(rungs),
            tuple(lines),
            element.sourceline,
            tested,
            tuple((kind, int(each.sourceline)) for kind, each in zip(types, contents, strict=True) if kind),
            chosen,
            None if chart is None else _element_record(chart),
        )

    def _rung(self, element: Any, place: int) -> L5xRungRecord:
        texts = element.findall("Text")
        text = texts[0] if texts else None
        number = element.get("Number", "")
        return L5xRungRecord(
            int(number) if _NUMBER.fullmatch(number) else place,
            element.get("Type", "N"),
            _text(text),
            _text(element.find("Comment")),
            element.sourceline if text is None else _line_of_text(text),
            len(texts),
        )

    def _task(self, element: Any) -> TaskRecord:
        get = element.get
        return TaskRecord(
            get("Name", ""),
            get("Type", "CONTINUOUS").upper(),
            get("Rate", ""),
            get("Priority", ""),
            tuple(
                each.get("Name", "") for each in _children(element, "ScheduledPrograms", "ScheduledProgram")
            ),
            _is_true(get("InhibitTask", "")),
            _text(element.find("Description")),
            element.sourceline,
        )

    # --- modules

    def _module(self, element: Any) -> ModuleRecord:
        get = element.get
        ports = list(_children(element, "Ports", "Port"))
        upstream = next((each for each in ports if _is_true(each.get("Upstream", ""))), None)
        rates = [_whole(each.get("RPI", "")) for each in element.iter("Connection")]
        return ModuleRecord(
            get("Name", ""),
            get("CatalogNumber", ""),
            get("Vendor", ""),
            get("ProductType", ""),
            get("ProductCode", ""),
            get("ParentModule", ""),
            "" if upstream is None else upstream.get("Address", ""),
            "" if upstream is None else upstream.get("Type", ""),
            min(filter(None, rates), default=0),
            tuple(self._module_tags(element)),
            _is_true(get("Inhibited", "")),
            element.sourceline,
        )

    def _module_tags(self, element: Any) -> Iterator[ModuleTagRecord]:
        for communications in element.iterchildren("Communications"):
            for tag in communications.iterchildren("ConfigTag"):
                yield self._module_tag(tag, "C", tag.get("ConfigSize", ""))
            for connection in communications.iter("Connection", "RackConnection"):
                for tag in connection.iterchildren("InputTag", "OutputTag", "InAliasTag", "OutAliasTag"):
                    way = "I" if tag.tag in ("InputTag", "InAliasTag") else "O"
                    name = "InputTagSuffix" if way == "I" else "OutputTagSuffix"
                    which = "InputSize" if way == "I" else "OutputSize"
                    size = connection.get(which) or communications.get(f"PrimCxn{which}", "")
                    yield self._module_tag(tag, connection.get(name) or way, size)

    def _module_tag(self, element: Any, suffix: str, size: str) -> ModuleTagRecord:
        data = list(map(self._data, element.iterchildren("Data")))
        forced = list(map(self._data, element.iterchildren("ForceData")))
        return ModuleTagRecord(
            suffix,
            element.tag,
            _comments(element.find("Comments")),
            data,
            _whole(size),
            element.sourceline,
            forced + [each for each in data if each.shows_forces],
        )


DEEPEST = 8
"""Levels of elements in a chart that are read: a line of an action is the fifth."""


def _element_record(element: Any, depth: int = 0) -> ElementRecord:
    inner = [each for each in element.iterchildren() if isinstance(each.tag, str)] if depth < DEEPEST else []
    text = _text(element.find("Text")) if element.tag == "TextBox" else (element.text or "")
    children = tuple(_element_record(each, depth + 1) for each in inner)
    return ElementRecord(element.tag, dict(element.attrib), text, children, int(element.sourceline or 0))


def _comments(element: Any) -> tuple[tuple[str, str], ...]:
    return tuple((each.get("Operand", ""), _text(each)) for each in _children(element, "Comment"))


def _encoded(element: Any) -> EncodedRecord:
    return EncodedRecord(element.get("EncodedType", ""), element.get("Name", ""), element.sourceline)
