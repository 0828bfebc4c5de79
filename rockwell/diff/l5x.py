"""An L5X as an outline: every attribute and every text is a field or a step of some item.

An unknown element becomes a field labeled with its path, so that no difference is missed.

    <Tag Name="Fill" DataType="TIMER"> … Name="PRE" Value="5000"/>     DataType = TIMER, .PRE = 5000
    <Port Id="1" Address="3"/> of a module                             Port 1.Address = 3
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from hashlib import sha256
from typing import Any

from ..l5x.xml.elements import line_of_text
from ..l5x.xml.parsing import ROOT, checked, parsed, root_of
from .outline import ELEMENT, LINE, RUNG, CommonPart, Field, Item, Step
from .pruning import CUT, PrunedDocument, pruned

KINDS: Mapping[str, str] = {
    ROOT: "export",
    "Controller": "controller",
    "DataType": "data type",
    "Module": "module",
    "AddOnInstructionDefinition": "add-on",
    "AddOnInstruction": "add-on",
    "EncodedData": "encoded source",
    "Parameter": "parameter",
    "LocalTag": "local tag",
    "Tag": "tag",
    "Program": "program",
    "Routine": "routine",
    "Task": "task",
    "Trend": "trend",
}
"""Elements that are items."""

DATES = frozenset(
    {
        *("ExportDate", "LastModifiedDate", "ProjectCreationDate", "CreatedDate", "EditedDate"),
        *("TargetLastEdited", "Owner", "CreatedBy", "EditedBy", "ExportOptions"),
    }
)
"""Attributes that say when, by whom and how a file was exported."""

PLACES = frozenset(("X", "Y", "HideDesc", "DescX", "DescY", "DescWidth", "Show", "ShowActions", "Width"))
"""Attributes of a chart's elements that affect only its picture."""

_KEYS = ("Name", "Id", "ID", "Operand", "Index", "Number", "Format", "Lang")
"""Attributes that name an element among its siblings."""

_GROUPS = frozenset(
    {
        *("DataTypes", "Modules", "AddOnInstructionDefinitions", "Tags", "Programs", "Tasks", "Trends"),
        *("Routines", "Parameters", "LocalTags", "Members", "Comments", "Ports", "Connections"),
        *("ScheduledPrograms", "Dependencies", "QuickWatchLists", "ParameterConnections", "DataLogs"),
    }
)
"""Elements that group others: an empty group is no field."""

_VALUES = {"Data": "", "DefaultData": "default", "ForceData": "force"}
_TEXTS = re.compile(r"('(?:[^'$]++|\$.)*+')")


def outlines(old: bytes, new: bytes, files: tuple[str, str]) -> tuple[Item, Item]:
    """Read two L5X files without what both have in common; raise an L5xError if one can't be read."""
    documents = [checked(data, file) for data, file in zip((old, new), files, strict=True)]
    root = root_of(documents[1], files[1])  # it contains everything that was cut out of either file
    if documents[0] == documents[1]:
        item = Item("export", "", int(root.sourceline or 1))
        return item, item
    before, after = (
        _L5xOutline(file, cut).root()
        for file, cut in zip(files, pruned(documents[0], documents[1]), strict=True)
    )
    return before, after


def outline(data: bytes, file: str) -> Item:
    """Read an L5X file; raise an L5xError if it can't be read."""
    return _L5xOutline(file, PrunedDocument(checked(data, file), [])).root()


def rung_key(text: str) -> str:
    """Return a rung's text without the white space outside its strings.

    >>> rung_key("EQU( S ,'a b') ;")
    "EQU(S,'a b');"
    """
    parts = _TEXTS.split(text)
    return "".join(part if number % 2 else "".join(part.split()) for number, part in enumerate(parts))


def _marks(rung: Any) -> Iterator[str]:
    """Yield a rung's attributes and elements other than its number, text and comment."""
    if rung.get("Type", "N") != "N":
        yield rung.get("Type")
    yield from (f"{name}={text}" for name, text in rung.attrib.items() if name not in ("Number", "Type"))
    yield from (_markup(child) for child in rung.iterchildren("*") if child.tag not in ("Text", "Comment"))


def _add(item: Item, name: str, label: str, text: str) -> None:
    """Add an attribute; dates do not count as differences."""
    (item.dates if name in DATES else item.fields).append((label, text))


def _label(label: str, seen: Counter[str]) -> str:
    """Count a label, and return it; the second and later ones get a number."""
    seen[label] += 1
    return label if seen[label] == 1 else f"{label} #{seen[label]}"


class _L5xOutline:
    """Builds items from elements; `shift` is the line of the document's beginning."""

    def __init__(self, file: str, document: PrunedDocument, shift: int = 0) -> None:
        self._file, self._document, self._shift = file, document, shift

    def root(self) -> Item:
        return self._item(root_of(self._document.data, self._file))

    def _line(self, element: Any) -> int:
        return int(element.sourceline or 0) + self._shift

    def _shared(self, element: Any) -> CommonPart:
        content = self._document.cuts[int(element.get("N"))]
        noun = KINDS[content[1:60].split(None, 1)[0].decode().rstrip("/>")]
        return CommonPart(noun, content, self._line(element), self._read)

    def _read(self, content: bytes, line: int) -> list[Item]:
        inner = _L5xOutline(self._file, PrunedDocument(content, []), line - 1)
        parts = parsed(b"<Cut>%b</Cut>" % content, self._file, line)
        return [inner._item(part) for part in parts]

    def _item(self, element: Any) -> Item:
        noun = KINDS[element.tag]
        is_named = noun not in ("export", "controller")  # a file has only one of each
        item = Item(noun, element.get("Name", "") if is_named else "", self._line(element))
        skipped = {"Name"} if is_named else set()
        for name, text in element.attrib.items():
            if name not in skipped:
                _add(item, name, name, text)
        if noun == "encoded source":
            digest = sha256("".join(element.itertext()).encode()).hexdigest()
            item.fields.append(("SHA-256 of its content", digest))
            return item
        self._inside(element, "", item, Counter())
        return item

    # --- fields

    def _inside(self, element: Any, path: str, item: Item, seen: Counter[str]) -> None:
        """Add the children of an element, and its text."""
        decorated = any(
            data.get("Format") == "Decorated" for data in element.iterchildren("Data", "DefaultData")
        )
        for child in element.iterchildren("*"):
            tag = child.tag
            if tag == CUT and self._document.cuts:
                item.items.append(self._shared(child))
            elif tag in KINDS and (child.get("Name") is not None or tag == "Controller"):
                item.items.append(self._item(child))
            elif tag in _STEPS:
                item.steps += _STEPS[tag](self, child, len(item.steps))
            elif tag in _VALUES:
                self._values(child, path, item, repeated=decorated)
            elif tag == "Member":
                self._member(child, item, seen)
            elif tag == "ScheduledPrograms":
                names = [member.get("Name", "") for member in child.iterchildren("*")]
                item.fields.append(("programs", ", ".join(names)))
            else:
                self._other(child, path, item, seen)

    def _other(self, element: Any, path: str, item: Item, seen: Counter[str]) -> None:
        """Add the attributes and the text of an unknown element, labeled with its path.

        An element without either only groups others.
        """
        text = _own_text(element)
        attributes = element.attrib
        if not attributes and not text and (len(element) or element.tag in _GROUPS):
            self._inside(element, path, item, seen)
            return
        key = next((name for name in _KEYS if name in attributes), "")
        label = _label(_joined(path, f"{element.tag} {attributes[key]}" if key else element.tag), seen)
        shown = [(name, value) for name, value in attributes.items() if name != key]
        for name, value in shown:
            _add(item, name, f"{label}.{name}", value)
        if text or not (shown or len(element)):
            item.fields.append((label, text))
        self._inside(element, label, item, seen)

    def _member(self, element: Any, item: Item, seen: Counter[str]) -> None:
        """Add a member of a data type: its type and its other attributes."""
        fields = dict(element.attrib)
        label = f"member {fields.pop('Name', '')}"
        kind, dims = fields.pop("DataType", ""), fields.pop("Dimension", fields.pop("Dimensions", "0"))
        settings = ", ".join(f"{name} {text}" for name, text in fields.items())
        item.fields.append(
            (label, f"{kind}{'' if dims in ('0', '') else f'[{dims}]'}{settings and f' ({settings})'}")
        )
        self._inside(element, label, item, seen)

    def _values(self, element: Any, path: str, item: Item, *, repeated: bool) -> None:
        """Add the values of a tag by member; a repeated form of the values is a detail."""
        form, begin = element.get("Format", ""), f"{path} {_VALUES[element.tag]}".strip()
        if form == "Decorated":
            for value, member in _decorated(element, ""):
                item.fields.append((f"{begin}{member}" or "value", value))
            item.details.append((f"{begin or 'values'}, as decorated data", _markup(element)))
        elif form in ("L5K", "String", "") and not len(element):
            label, text = begin or "value", _text(element)
            if form == "L5K":
                label, text = f"{label} L5K", " ".join(text.split())
            (item.details if repeated else item.fields).append((label, text))
        else:
            self._other(element, begin, item, Counter())

    # --- steps

    def rungs(self, content: Any, number: int) -> Iterator[Step]:
        """Yield the rungs of a routine."""
        for place, rung in enumerate(content.iterchildren("*"), number):
            texts = list(rung.iterchildren("Text"))
            text = (texts[0].text or "").strip() if len(texts) == 1 else "\n".join(map(_text, texts))
            comment = "\n".join(_text(inner) for inner in rung.iterchildren("Comment"))
            marks = list(_marks(rung))
            shown = f"{', '.join(marks)}: {text}" if marks else text
            line = line_of_text(texts[0]) + self._shift if texts else self._line(rung)
            yield Step(RUNG, place, shown, rung_key(shown), comment, line)

    def lines(self, content: Any, number: int) -> Iterator[Step]:
        """Yield the lines of structured text that are not blank."""
        kind = content.get("OnlineEditType", "")
        printed = list(content.iterchildren("Line")) or [content]
        blanks = place = 0
        for text_node in printed:
            for offset, line in enumerate("".join(text_node.itertext()).strip("\r\n").splitlines()):
                words = " ".join(line.split())
                place += 1
                if not words:
                    blanks += 1
                    continue
                shown = f"{kind}: {line.rstrip()}" if kind else line.rstrip()
                line_number = line_of_text(text_node) + self._shift + offset
                yield Step(
                    LINE, number + place, shown, f"{kind} {words}", "", line_number, layout=f"{blanks}{line}"
                )
                blanks = 0

    def chart(self, content: Any, number: int) -> Iterator[Step]:
        """Yield the elements of a chart or of a diagram's sheets, with connections by name."""
        edit_type = content.get("OnlineEditType", "")
        place = number
        for sheet in [content, *content.iterchildren("Sheet")]:
            names = _names(sheet)
            nodes = sheet.iter("*") if sheet.tag == "Sheet" else _outside_of_sheets(sheet)
            for node in nodes:
                text = _element_text(node, names)
                if text:
                    places = [
                        f"{name}={position}" for name, position in node.attrib.items() if name in PLACES
                    ]
                    shown = f"{edit_type}: {text}" if edit_type else text
                    key, name = " ".join(shown.split()), names.get(node.get("ID", ""), "")
                    layout = " ".join(places)
                    yield Step(ELEMENT, place, shown, key, "", self._line(node), name, layout)
                    place += 1


_STEPS: Mapping[str, Callable[[_L5xOutline, Any, int], Iterator[Step]]] = {
    "RLLContent": _L5xOutline.rungs,
    "STContent": _L5xOutline.lines,
    "FBDContent": _L5xOutline.chart,
    "SFCContent": _L5xOutline.chart,
}
"""Contents of routines."""


def _joined(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name


def _text(element: Any) -> str:
    return "".join(element.itertext()).strip()


def _own_text(element: Any) -> str:
    """Return an element's own text, without the text of elements inside it."""
    if not len(element):
        return (element.text or "").strip()
    return " ".join(
        filter(None, ((text or "").strip() for text in (element.text, *(inner.tail for inner in element))))
    )


def _markup(element: Any) -> str:
    """Return an element's full markup on one line; it is only shown if nothing else differs."""
    parts = []
    for node in element.iter("*"):
        attributes = " ".join(f'{name}="{text}"' for name, text in sorted(node.attrib.items()))
        parts.append(" ".join(filter(None, (str(node.tag), attributes, (node.text or "").strip()))))
    return "; ".join(parts)


def _decorated(element: Any, path: str) -> Iterator[Field]:
    """Yield decorated values with their paths, such as `.PRE` or `[3].Name`; a force has its own path."""
    for child in element.iterchildren("*"):
        index = child.get("Index")
        name = child.get("Name")
        child_path = path + (index if index is not None else f".{name}" if name is not None else "")
        for attribute, mark in (("Value", ""), ("ForceValue", " forced")):
            if attribute in child.attrib:
                yield child.get(attribute), child_path + mark
        text = (child.text or "").strip()
        if text:
            yield text, child_path
        yield from _decorated(child, child_path)


def _outside_of_sheets(content: Any) -> Iterator[Any]:
    """Yield a content element and all elements in it, except sheets."""
    yield content
    for child in content.iterchildren("*"):
        if child.tag != "Sheet":
            yield from child.iter("*")


def _names(sheet: Any) -> dict[str, str]:
    """Return names of a sheet's elements by ID: operand, else name, else the number among its kind."""
    names: dict[str, str] = {}
    counts: Counter[str] = Counter()
    for node in sheet.iter("*"):
        ident = node.get("ID")
        if ident is not None:
            counts[node.tag] += 1
            name = node.get("Operand") or node.get("Name") or f"{node.tag} {counts[node.tag]}"
            names.setdefault(ident, name)
    return names


def _element_text(element: Any, names: Mapping[str, str]) -> str:
    """Return an element of a chart as text; "" if it only groups others."""
    attributes = [
        f"{name}={names.get(text, text) if name.endswith('ID') else text}"
        for name, text in element.attrib.items()
        if name not in PLACES and name not in ("ID", "OnlineEditType")
    ]
    if element.tag == "Line":
        return _text(element)
    text = " ".join((element.text or "").split())
    return " ".join((element.tag, *attributes, *filter(None, [text]))) if attributes or text else ""
