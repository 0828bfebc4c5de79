"""Parts and attributes of a document that are not read; the file keeps them, and the report names them.

Each release of Studio 5000 adds some.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

from lxml.etree import XPath

_VALUES = ("Data", "DefaultData", "ForceData", "Description", "Comments", "CustomProperties")
_CONTENTS = ("RLLContent", "STContent", "FBDContent", "SFCContent")
_COMMON = ("Name", "Use", "Class", "DataExchangeId", "OldName", "TrackingGroups")
_LIMITS = ("EngineeringUnit", "EngineeringUnits", "Maxes", "Mins", "State0s", "State1s")
_DEFINED = ("Name", "DataType", "Dimension", "Dimensions", "Radix", "ExternalAccess")


class _KnownElement(NamedTuple):
    """Path of elements, with their known parts and attributes; None allows any attribute."""

    path: str
    parts: tuple[str, ...]
    attributes: tuple[str, ...] | None = None


def _tags(path: str) -> _KnownElement:
    parts = (*_VALUES, *_LIMITS, "ConsumeInfo", "ProduceInfo", "Libraries", "Instructions")
    extras = ("AliasFor", "Usage", "Required", "Visible", "IO", "OpcUaAccess", "Min", "Max", "Producer")
    return _KnownElement(path, parts, (*_DEFINED, "TagType", "Constant", *extras, *_COMMON))


_ADD_ON = "Controller/AddOnInstructionDefinitions"
_PROGRAMS = "Controller/Programs"
_PARTS = (
    _KnownElement(".", ("Controller",)),
    _KnownElement(
        "Controller",
        (
            *("DataTypes", "Modules", "AddOnInstructionDefinitions", "Tags", "Programs", "Tasks"),
            *("Description", "RedundancyInfo", "Security", "CST", "WallClockTime", "TimeSynchronize"),
            *("CommPorts", "EthernetPorts", "EthernetNetwork", "Trends", "QuickWatchLists"),
            *("AddOnDefinitions", "InternetProtocol", "DataLogs", "Timelines", "Commands"),
            *("CustomProperties", "SafetyInfo[not(@*)]"),
        ),
    ),
    _KnownElement("Controller/DataTypes", ("DataType",), ("Use",)),
    _KnownElement(
        "Controller/DataTypes/DataType",
        ("Members", "Description", "Dependencies", "CustomProperties", *_LIMITS),
        ("Family", *_COMMON),
    ),
    _KnownElement("Controller/DataTypes/DataType/Members", ("Member",)),
    _KnownElement(
        "Controller/DataTypes/DataType/Members/Member",
        ("Description", "CustomProperties", *_LIMITS),
        (*_DEFINED, "Hidden", "Target", "BitNumber", "Max", "Min", *_COMMON),
    ),
    _KnownElement("Controller/Modules", ("Module",), ("Use",)),
    _KnownElement(
        _ADD_ON,
        (
            *("AddOnInstructionDefinition", "AddOnInstruction"),
            "EncodedData[contains(@EncodedType, 'AddOn') or not(@EncodedType)]",
        ),
    ),
    _KnownElement(
        f"{_ADD_ON}/AddOnInstructionDefinition",
        (
            *("Description", "Parameters", "LocalTags", "Routines", "Dependencies", "RevisionNote"),
            *("AdditionalHelpText", "SignatureHistory", "CustomProperties"),
        ),
        (
            *(*_COMMON, "Revision", "RevisionExtension", "Vendor", "SoftwareRevision", "IsEncrypted"),
            *("ExecutePrescan", "ExecutePostscan", "ExecuteEnableInFalse"),
            *("CreatedBy", "CreatedDate", "EditedBy", "EditedDate", "SignatureID", "SignatureTimestamp"),
        ),
    ),
    _tags(f"{_ADD_ON}/*/Parameters/Parameter"),
    _tags(f"{_ADD_ON}/*/LocalTags/LocalTag"),
    _KnownElement(f"{_ADD_ON}/*/Routines", ("Routine", "EncodedData")),
    _KnownElement("Controller/Tags", ("Tag",), ("Use",)),
    _tags("Controller/Tags/Tag"),
    _KnownElement(_PROGRAMS, ("Program",), ("Use",)),
    _KnownElement(
        f"{_PROGRAMS}/Program", ("Description", "Tags", "Routines", "ChildPrograms", "CustomProperties")
    ),
    _KnownElement(f"{_PROGRAMS}/Program/Tags", ("Tag",)),
    _tags(f"{_PROGRAMS}/Program/Tags/Tag"),
    _KnownElement(f"{_PROGRAMS}/Program/Routines", ("Routine", "EncodedData")),
    _KnownElement(
        f"{_PROGRAMS}/Program/Routines/Routine",
        ("Description", "CustomProperties", "EncodedData", *_CONTENTS),
        ("Type", *_COMMON),
    ),
    _KnownElement("Controller/Tasks", ("Task",), ("Use",)),
)
"""The known parts of a document, as Studio 5000 writes them up to version 33."""


@cache
def _others() -> tuple[tuple[Any, ...], Mapping[str, frozenset[str]]]:
    """Return XPaths that find parts not in the table, and the table's attributes by element."""
    parts = (f"{part.path}/*[not({' or '.join(f'self::{name}' for name in part.parts)})]" for part in _PARTS)
    names = {
        part.path.rpartition("/")[2]: frozenset(part.attributes)
        for part in _PARTS
        if part.attributes is not None
    }
    return tuple(map(XPath, parts)), names


def unread(root: Any) -> list[tuple[str, str, int]]:
    """Return the name, a description and the line of each part or attribute that is not read."""
    parts, names = _others()
    rows = []
    for child in (element for find in parts for element in find(root)):
        around = child.getparent().tag
        place = "the controller" if around == "Controller" else around
        rows.append((_name(child), f"this part of {place} is kept, and not read", int(child.sourceline)))
    for child in root.iter(*names):
        known = names[child.tag]
        if not known.issuperset(present := child.keys()):
            text = f"this attribute of {child.tag} is kept, and not read"
            rows += [(name, text, int(child.sourceline)) for name in present if name not in known]
    return sorted(rows, key=lambda each: each[2])


def is_add_on(element: Any) -> bool:
    """Return whether an element in the definitions of add-on instructions is an add-on instruction."""
    return element.tag != "EncodedData" or "AddOn" in element.get("EncodedType", "AddOn")


def _name(element: Any) -> str:
    """Return the name of a part; for an encoded object, with its type and name."""
    if element.tag != "EncodedData":
        return str(element.tag)
    return " ".join(filter(None, (element.tag, element.get("EncodedType"), element.get("Name"))))
