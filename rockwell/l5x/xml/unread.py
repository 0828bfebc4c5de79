"""Finds the parts and attributes that scanrack does not read; the file keeps them, and the report names them.

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
    """An element with its known parts and attributes."""

    path: str  # from the root element
    parts: tuple[str, ...]  # tags of the elements in it, or XPath conditions on them
    attributes: tuple[str, ...] | None = None  # None allows any attribute


def _tags(path: str) -> _KnownElement:
    parts = (*_VALUES, *_LIMITS, "ConsumeInfo", "ProduceInfo", "Libraries", "Instructions")
    extras = ("AliasFor", "Usage", "Required", "Visible", "IO", "OpcUaAccess", "Min", "Max", "Producer")
    return _KnownElement(path, parts, (*_DEFINED, "TagType", "Constant", *extras, *_COMMON))


_ADD_ON = "Controller/AddOnInstructionDefinitions"
_PROGRAMS = "Controller/Programs"
_KNOWN_ELEMENTS = (
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


_KNOWN_ATTRIBUTES: Mapping[str, frozenset[str]] = {
    known.path.rpartition("/")[2]: frozenset(known.attributes)
    for known in _KNOWN_ELEMENTS
    if known.attributes is not None
}
"""Known attributes by tag."""


@cache
def _unknown_parts() -> tuple[XPath, ...]:
    """Return the XPaths that find elements missing in the table."""
    conditions = (
        (known.path, " or ".join(f"self::{part}" for part in known.parts)) for known in _KNOWN_ELEMENTS
    )
    return tuple(XPath(f"{path}/*[not({condition})]") for path, condition in conditions)


def unread(root: Any) -> list[tuple[str, str, int]]:
    """Return the name, description and line of each part or attribute that is not read, sorted by line."""
    rows = []
    for find in _unknown_parts():
        for child in find(root):
            parent = child.getparent().tag
            place = "the controller" if parent == "Controller" else parent
            rows.append((_name(child), f"this part of {place} is kept, but not read", int(child.sourceline)))
    for element in root.iter(*_KNOWN_ATTRIBUTES):
        known = _KNOWN_ATTRIBUTES[element.tag]
        text = f"this attribute of {element.tag} is kept, but not read"
        rows += [(name, text, int(element.sourceline)) for name in element.attrib if name not in known]
    return sorted(rows, key=lambda row: row[2])


def is_add_on(element: Any) -> bool:
    """Return whether an element in the definitions of add-on instructions is an add-on instruction."""
    return element.tag != "EncodedData" or "AddOn" in element.get("EncodedType", "AddOn")


def _name(element: Any) -> str:
    """Return the tag of a part; for an encoded object, with its type and name."""
    if element.tag != "EncodedData":
        return str(element.tag)
    return " ".join(filter(None, (element.tag, element.get("EncodedType"), element.get("Name"))))
