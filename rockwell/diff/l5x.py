"""Reads an L5X as an outline. Every attribute and every text becomes a field or a step of an item.

An unknown element becomes a field labeled with its path, so no difference is missed.

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
"""Attributes with the time, the author and the options of an export."""

PLACES = frozenset(("X", "Y", "HideDesc", "DescX", "DescY", "DescWidth", "Show", "ShowActions", "Width"))
"""Attributes of chart elements that affect only the picture."""

_KEYS = ("Name", "Id", "ID", "Operand", "Index", "Number", "Format", "Lang")
"""Attributes that name an element among its siblings."""

_GROUPS = frozenset(
    {
        *("DataTypes", "Modules", "AddOnInstructionDefinitions", "Tags", "Programs", "Tasks", "Trends"),
        *("Routines", "Parameters", "LocalTags", "Members", "Comments", "Ports", "Connections"),
        *("ScheduledPrograms", "Dependencies", "QuickWatchLists", "ParameterConnections", "DataLogs"),
    }
)
"""Elements that only group other elements; an empty group does not become a field."""

_VALUES = {"Data": "", "DefaultData": "default", "ForceData": "force"}
"""Elements with values, and the words in their labels."""

_STRINGS = re.compile(r"('(?:[^'$]++|\$.)*+')")


def outlines(old: bytes, new: bytes, files: tuple[str, str]) -> tuple[Item, Item]:
    """Read two L5X files, without the content of common parts; raise an L5xError if one can't be read."""
    old_file, new_file = files
    old_document, new_document = checked(old, old_file), checked(new, new_file)
    root = root_of(new_document, new_file)  # common parts are cut out, so refuse errors in them here
    if old_document == new_document:
        item = Item("export", "", int(root.sourceline or 1))
        return item, item
    old_pruned, new_pruned = pruned(old_document, new_document)
    return _L5xOutline(old_file, old_pruned).root(), _L5xOutline(new_file, new_pruned).root()


def outline(data: bytes, file: str) -> Item:
    """Read an L5X file; raise an L5xError if it can't be read."""
    return _L5xOutline(file, PrunedDocument(checked(data, file), [])).root()


def rung_key(text: str) -> str:
    """Return a rung's text without the white space outside its strings.

    >>> rung_key("EQU( S ,'a b') ;")
    "EQU(S,'a b');"
    """
    pieces = _STRINGS.split(text)  # every second piece is a string
    return "".join(piece if index % 2 else "".join(piece.split()) for index, piece in enumerate(pieces))


def _marks(rung: Any) -> Iterator[str]:
    """Yield a rung's edit type, and all attributes and elements except its number, text and comment."""
    if rung.get("Type", "N") != "N":
        yield rung.get("Type")
    for name, text in rung.attrib.items():
        if name not in ("Number", "Type"):
            yield f"{name}={text}"
    for child in rung.iterchildren("*"):
        if child.tag not in ("Text", "Comment"):
            yield _markup(child)


def _add_attribute(item: Item, name: str, label: str, text: str) -> None:
    """Add an attribute to an item; dates do not count as differences."""
    (item.dates if name in DATES else item.fields).append((label, text))


def _numbered(label: str, counts: Counter[str]) -> str:
    """Count a label; return it, with a number from its second occurrence on."""
    counts[label] += 1
    return label if counts[label] == 1 else f"{label} #{counts[label]}"


class _L5xOutline:
    """Builds items from elements.

    Args:
        lines_before: number of lines of the file before the document.
    """

    def __init__(self, file: str, document: PrunedDocument, lines_before: int = 0) -> None:
        self._file, self._document, self._lines_before = file, document, lines_before

    def root(self) -> Item:
        return self._item(root_of(self._document.data, self._file))

    def _line(self, element: Any) -> int:
        return int(element.sourceline or 0) + self._lines_before

    def _common_part(self, cut: Any) -> CommonPart:
        """Return the common part for a placeholder, whose number identifies the content in the document."""
        content = self._document.cuts[int(cut.get("N"))]
        first_tag = content[1:60].split(None, 1)[0].decode().rstrip("/>")
        return CommonPart(KINDS[first_tag], content, self._line(cut), self._items_in)

    def _items_in(self, content: bytes, line: int) -> list[Item]:
        """Return the items in the content of a common part that begins on a line."""
        outline_of_part = _L5xOutline(self._file, PrunedDocument(content, []), line - 1)
        elements = parsed(b"<Cut>%b</Cut>" % content, self._file, line)
        return [outline_of_part._item(element) for element in elements]

    def _item(self, element: Any) -> Item:
        """Return an element as an item, with its attributes and everything in it."""
        noun = KINDS[element.tag]
        is_named = noun not in ("export", "controller")  # a file has only one of each
        item = Item(noun, element.get("Name", "") if is_named else "", self._line(element))
        skipped = {"Name"} if is_named else set()
        for name, text in element.attrib.items():
            if name not in skipped:
                _add_attribute(item, name, name, text)
        if noun == "encoded source":
            digest = sha256("".join(element.itertext()).encode()).hexdigest()
            item.fields.append(("SHA-256 of its content", digest))
            return item
        self._add_children(element, "", item, Counter())
        return item

    # --- fields

    def _add_children(self, element: Any, path: str, item: Item, counts: Counter[str]) -> None:
        """Add the children of an element to an item; their labels contain the path of the element.

        Args:
            counts: how often each label occurs in the item.
        """
        has_decorated = any(
            data.get("Format") == "Decorated" for data in element.iterchildren("Data", "DefaultData")
        )
        for child in element.iterchildren("*"):
            tag = child.tag
            if tag == CUT and self._document.cuts:
                item.items.append(self._common_part(child))
            elif tag in KINDS and (child.get("Name") is not None or tag == "Controller"):
                item.items.append(self._item(child))
            elif tag in _STEPS:
                item.steps += _STEPS[tag](self, child, len(item.steps))
            elif tag in _VALUES:
                self._add_values(child, path, item, repeated=has_decorated)
            elif tag == "Member":
                self._add_member(child, item, counts)
            elif tag == "ScheduledPrograms":
                names = [member.get("Name", "") for member in child.iterchildren("*")]
                item.fields.append(("programs", ", ".join(names)))
            else:
                self._add_unknown(child, path, item, counts)

    def _add_unknown(self, element: Any, path: str, item: Item, counts: Counter[str]) -> None:
        """Add the attributes, the text and the children of an unknown element, labeled with its path.

        An element without attributes and text only groups its children.
        """
        text = _own_text(element)
        attributes = dict(element.attrib)
        if not attributes and not text and (len(element) or element.tag in _GROUPS):
            self._add_children(element, path, item, counts)
            return
        key = next((name for name in _KEYS if name in attributes), None)
        name = element.tag if key is None else f"{element.tag} {attributes.pop(key)}"
        label = _numbered(_joined(path, name), counts)
        for attribute, value in attributes.items():
            _add_attribute(item, attribute, f"{label}.{attribute}", value)
        if text or not (attributes or len(element)):
            item.fields.append((label, text))
        self._add_children(element, label, item, counts)

    def _add_member(self, element: Any, item: Item, counts: Counter[str]) -> None:
        """Add a member of a data type: its type, and its other attributes in parentheses."""
        attributes = dict(element.attrib)
        label = f"member {attributes.pop('Name', '')}"
        text = attributes.pop("DataType", "")
        dims = attributes.pop("Dimension", attributes.pop("Dimensions", "0"))
        if dims not in ("0", ""):
            text += f"[{dims}]"
        if attributes:
            text += f" ({', '.join(f'{name} {value}' for name, value in attributes.items())})"
        item.fields.append((label, text))
        self._add_children(element, label, item, counts)

    def _add_values(self, element: Any, path: str, item: Item, *, repeated: bool) -> None:
        """Add the values of a tag; decorated values are added by member.

        Args:
            repeated: whether the file also has the values as decorated data, so that this form is only a
                detail.
        """
        form, prefix = element.get("Format", ""), f"{path} {_VALUES[element.tag]}".strip()
        if form == "Decorated":
            for value_path, value in _decorated(element, ""):
                item.fields.append((f"{prefix}{value_path}" or "value", value))
            item.details.append((f"{prefix or 'values'}, as decorated data", _markup(element)))
        elif form in ("L5K", "String", "") and not len(element):
            label, text = prefix or "value", _text(element)
            if form == "L5K":
                label, text = f"{label} L5K", " ".join(text.split())
            (item.details if repeated else item.fields).append((label, text))
        else:
            self._add_unknown(element, prefix, item, Counter())

    # --- steps

    def rungs(self, content: Any, first_number: int) -> Iterator[Step]:
        """Yield the rungs of a routine."""
        for number, rung in enumerate(content.iterchildren("*"), first_number):
            texts = list(rung.iterchildren("Text"))
            text = (texts[0].text or "").strip() if len(texts) == 1 else "\n".join(map(_text, texts))
            comment = "\n".join(_text(inner) for inner in rung.iterchildren("Comment"))
            marks = list(_marks(rung))
            shown = f"{', '.join(marks)}: {text}" if marks else text
            line = line_of_text(texts[0]) + self._lines_before if texts else self._line(rung)
            yield Step(RUNG, number, shown, rung_key(shown), comment, line)

    def lines(self, content: Any, first_number: int) -> Iterator[Step]:
        """Yield the lines of structured text that are not blank."""
        edit_type = content.get("OnlineEditType", "")
        number, blank_lines = first_number, 0
        for element in list(content.iterchildren("Line")) or [content]:
            first_line = line_of_text(element) + self._lines_before
            text = "".join(element.itertext()).strip("\r\n")
            for line_number, line in enumerate(text.splitlines(), first_line):
                number += 1
                words = " ".join(line.split())
                if not words:
                    blank_lines += 1
                    continue
                shown = f"{edit_type}: {line.rstrip()}" if edit_type else line.rstrip()
                layout = f"{blank_lines}{line}"
                key = f"{edit_type} {words}"
                yield Step(LINE, number, shown, key, comment="", line=line_number, layout=layout)
                blank_lines = 0

    def chart(self, content: Any, first_number: int) -> Iterator[Step]:
        """Yield the elements of a chart or of a diagram's sheets, with connections by name."""
        edit_type = content.get("OnlineEditType", "")
        number = first_number
        for sheet in [content, *content.iterchildren("Sheet")]:
            names = _names(sheet)
            nodes = sheet.iter("*") if sheet.tag == "Sheet" else _outside_of_sheets(sheet)
            for node in nodes:
                text = _element_text(node, names)
                if not text:
                    continue
                shown = f"{edit_type}: {text}" if edit_type else text
                key, name = " ".join(shown.split()), names.get(node.get("ID", ""), "")
                layout = " ".join(
                    f"{label}={value}" for label, value in node.attrib.items() if label in PLACES
                )
                line = self._line(node)
                yield Step(ELEMENT, number, shown, key, comment="", line=line, name=name, layout=layout)
                number += 1


_STEPS: Mapping[str, Callable[[_L5xOutline, Any, int], Iterator[Step]]] = {
    "RLLContent": _L5xOutline.rungs,
    "STContent": _L5xOutline.lines,
    "FBDContent": _L5xOutline.chart,
    "SFCContent": _L5xOutline.chart,
}
"""The methods that read the contents of routines, by tag; they get the number of the first step."""


def _joined(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name


def _text(element: Any) -> str:
    return "".join(element.itertext()).strip()


def _own_text(element: Any) -> str:
    """Return the text of an element, without the text of elements in it."""
    texts = [element.text, *(child.tail for child in element)]
    return " ".join(text.strip() for text in texts if text and text.strip())


def _markup(element: Any) -> str:
    """Return the tags, attributes and texts of an element and of all elements in it, on one line."""
    texts = []
    for node in element.iter("*"):
        attributes = " ".join(f'{name}="{text}"' for name, text in sorted(node.attrib.items()))
        texts.append(" ".join(filter(None, (str(node.tag), attributes, (node.text or "").strip()))))
    return "; ".join(texts)


def _decorated(element: Any, path: str) -> Iterator[Field]:
    """Yield decorated values, labeled with their paths such as `.PRE` or `[3].Name`; forces are separate."""
    for child in element.iterchildren("*"):
        child_path = path
        if "Index" in child.attrib:
            child_path += child.get("Index")
        elif "Name" in child.attrib:
            child_path += f".{child.get('Name')}"
        if "Value" in child.attrib:
            yield child_path, child.get("Value")
        if "ForceValue" in child.attrib:
            yield f"{child_path} forced", child.get("ForceValue")
        text = (child.text or "").strip()
        if text:
            yield child_path, text
        yield from _decorated(child, child_path)


def _outside_of_sheets(content: Any) -> Iterator[Any]:
    """Yield a content element and all elements in it, except sheets."""
    yield content
    for child in content.iterchildren("*"):
        if child.tag != "Sheet":
            yield from child.iter("*")


def _names(sheet: Any) -> dict[str, str]:
    """Return the operand or name of each element of a sheet by ID, or else its tag and a number."""
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
    """Return an element of a chart as text, with names for IDs; "" if it only groups others."""
    if element.tag == "Line":
        return _text(element)
    words = [
        f"{name}={names.get(text, text) if name.endswith('ID') else text}"
        for name, text in element.attrib.items()
        if name not in PLACES and name not in ("ID", "OnlineEditType")
    ]
    words += (element.text or "").split()
    return " ".join((element.tag, *words)) if words else ""
