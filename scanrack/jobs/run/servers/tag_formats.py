"""Lists of tags as files that HMI software imports; each format has a row in `FORMATS`.

| software | file | source |
|---|---|---|
| Kepware | CSV of a device | help of KEPServerEX, "CSV Import and Export", and of its Logix driver |
| FactoryTalk View | CSV of HMI tags | "CSV File Column Ordering" [2711E-6.12, p. 6-23]; heads as exported |
| Ignition | JSON of tags | manual of 8.1, "Exporting and Importing Tags", "Tag Properties" |
| Node-RED | a flow | node-red-contrib-cip-ethernet-ip |

No file has been imported into any of these programs; the file for Node-RED is read by its library,
st-ethernet-ip.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Any

from scanrack.io_images.csv_cells import cell, csv_text, line_text
from scanrack.runtime.tag_servers.tag_list import TagRow
from scanrack.runtime.tag_servers.variables import ELEMENTS_MOST

SHORTCUT = "PLC"
"""Device shortcut of FactoryTalk Linx in addresses."""

OPC_SERVER = "scanrack"
"""Name of the connection to the rack's OPC UA server in Ignition."""

SCAN_MS = 100


@dataclass
class TagFile:
    """A file for HMI software to import.

    Attributes:
        left_out: names of tags that the format can't represent.
    """

    text: str = ""
    left_out: list[str] = field(default_factory=list)

    def single_values(self, rows: Iterable[TagRow], types: Mapping[str, Any]) -> Iterator[TagRow]:
        """Yield rows of the given types, arrays as elements; add the rest to `left_out`."""
        for row in rows:
            count = 1
            for size in row.dims:
                count *= size
            if row.type_name not in types or count > ELEMENTS_MOST:
                self.left_out.append(row.name)
            elif row.dims:
                yield from row.elements()
            else:
                yield row


# --- Kepware

_KEPWARE_HEAD = (
    "Tag Name,Address,Data Type,Respect Data Type,Client Access,Scan Rate,Scaling,Raw Low,Raw High,"
    "Scaled Low,Scaled High,Scaled Data Type,Clamp Low,Clamp High,Eng Units,Description,Negate Value"
)
_KEPWARE: Mapping[str, str] = {
    "BOOL": "Boolean",
    "SINT": "Char",
    "INT": "Short",
    "DINT": "Long",
    "LINT": "LLong",
    "USINT": "Byte",
    "UINT": "Word",
    "UDINT": "DWord",
    "DWORD": "DWord",
    "ULINT": "QWord",
    "REAL": "Float",
    "LREAL": "Double",
    "STRING": "String",
}
_MAX_TEXT = 82


def kepware(rows: Iterable[TagRow], title: str) -> TagFile:
    """Return a CSV for a device of the Allen-Bradley ControlLogix Ethernet driver.

    A dot in a name makes a tag group. `Grid{3}{4}` is an array of one or two dimensions, and `Text.DATA/82`
    is a text.
    """
    file = TagFile()
    table: list[list[object]] = [[*_KEPWARE_HEAD.split(",")]]
    for row in _with_arrays(file, rows):
        kind = _KEPWARE[row.type_name] + (" Array" if row.dims else "")
        address = row.enip + "".join(f"{{{size}}}" for size in row.dims)
        if row.type_name == "STRING" and not row.in_files:
            address += f".DATA/{_MAX_TEXT}"
        access = "R/W" if row.writable else "RO"
        shown = line_text(row.description)
        table.append([_group_path(row.name, "."), address, kind, 1, access, SCAN_MS, *[""] * 9, shown, ""])
    file.text = csv_text(table)
    return file


def _with_arrays(file: TagFile, rows: Iterable[TagRow]) -> Iterator[TagRow]:
    """Yield rows for Kepware: arrays that it supports as one row, other arrays as elements."""
    for row in rows:
        is_array = 0 < len(row.dims) <= 2 and row.type_name not in ("STRING", "BOOL") and not row.in_files
        yield from [row] if is_array else file.single_values([row], _KEPWARE)


def _group_path(name: str, separator: str) -> str:
    """Return a name with a group separator and without subscripts and colons.

    >>> _group_path("Program:Main.Steps[2,1].Time", ".")
    'Program_Main.Steps_2_1.Time'
    """
    return re.sub(r"[\[:,]", "_", name.replace("]", "")).replace(".", separator)


# --- FactoryTalk View

_FACTORYTALK_HEAD = (
    ";Tag Type, Tag Name, Tag Description, Read Only, Data Source, Security Code, Alarmed, Native Type,"
    " Value Type, Min Analog, Max Analog, Initial Analog, Scale, Offset, DeadBand, Units, Off Label Digital,"
    " On Label Digital, Initial Digital, Length String, Initial String, Retentive, Address,"
    " System Source Name, System Source Index, RIO Address, Element Size Block, Number Elements Block,"
    " Initial Block"
)
_FACTORYTALK_FIRST = ";###002 - THIS LINE CONTAINS VERSION INFORMATION. DO NOT REMOVE!!!"
_COLUMNS = _FACTORYTALK_HEAD.count(",") + 1
_LIMITS: Mapping[str, tuple[float, float]] = {
    "SINT": (-128, 127),
    "INT": (-(1 << 15), (1 << 15) - 1),
    "DINT": (-(1 << 31), (1 << 31) - 1),
    "USINT": (0, 255),
    "UINT": (0, (1 << 16) - 1),
    "UDINT": (0, (1 << 32) - 1),
    "DWORD": (0, (1 << 32) - 1),
    "REAL": (-3.4e38, 3.4e38),
}
"""Minimum and maximum of analog tags."""

_FACTORYTALK = {**_LIMITS, "BOOL": None, "STRING": None}


def factorytalk(rows: Iterable[TagRow], title: str) -> TagFile:
    r"""Return a CSV for the Tag Import and Export Wizard of FactoryTalk View.

    Tags are digital, analog or string, with `::[PLC]Name` as the address; a dot in a name makes a folder.
    Texts are quoted, but numbers are not. Column D, whether the tag may be edited in the database, is always
    set.
    """
    file = TagFile()
    folders: dict[str, None] = {}
    lines = []
    for row in file.single_values(rows, _FACTORYTALK):
        name = _group_path(row.name, "\\")
        folders |= dict.fromkeys(accumulate(name.split("\\")[:-1], "{}\\{}".format))
        lines.append(_hmi_tag(row, name))
    head = [_FACTORYTALK_HEAD, _FACTORYTALK_FIRST, "", ";Folders Section (Must define folders before tags)"]
    head += [_cells("F", folder, "", "F") for folder in folders]
    file.text = "\n".join([*head, "", ";Tag Section", *lines]) + "\n"
    return file


def _hmi_tag(row: TagRow, name: str) -> str:
    """Return a line: columns A to G are common to all tags; the others depend on the type or address."""
    limits = _LIMITS.get(row.type_name)
    # string, digital or analog
    kind = "S" if row.type_name == "STRING" else "D" if limits is None else "A"
    cells: list[object] = [None] * _COLUMNS
    cells[:7] = kind, name, line_text(row.description), "F", "D", "*", "F"
    if limits is not None:  # types, minimum, maximum, initial value, scale, offset, deadband
        cells[7:15] = "D", "F" if row.type_name == "REAL" else "L", *limits, 0, 1, 0, 0
    elif kind == "D":
        cells[16:19] = "Off", "On", "Off"
    else:
        cells[19:21] = _MAX_TEXT, ""
    cells[22] = f"::[{SHORTCUT}]{row.enip}"
    return _cells(*cells)


def _cells(*cells: object) -> str:
    """Return a line of cells: texts are quoted, and `None` is empty."""

    def quoted(value: object) -> str:
        if isinstance(value, str):
            return '"' + value.replace('"', "'") + '"'
        return "" if value is None else str(value)

    return ",".join(quoted(cell(value)) for value in cells)


# --- Ignition

_IGNITION: Mapping[str, str] = {
    "BOOL": "Boolean",
    "SINT": "Int1",
    "INT": "Int2",
    "DINT": "Int4",
    "LINT": "Int8",
    "USINT": "Int2",
    "UINT": "Int4",
    "UDINT": "Int8",
    "DWORD": "Int8",
    "ULINT": "Int8",
    "REAL": "Float4",
    "LREAL": "Float8",
    "STRING": "String",
}
"""Ignition's types; it has no unsigned types."""


def ignition(rows: Iterable[TagRow], title: str) -> TagFile:
    """Return JSON with a folder of OPC tags, in which structures are folders.

    The connection to `opc.tcp://127.0.0.1:4840/scanrack` must be named `scanrack`.
    """
    file = TagFile()
    root: dict[str, Any] = {"name": title, "tagType": "Folder", "tags": []}
    folders = {"": root}
    for row in rows:
        if not row.node:
            file.left_out.append(row.name)
            continue
        for tag_row in [row] if len(row.dims) < 2 else file.single_values([row], _IGNITION):
            folder, _, last = _group_path(tag_row.name, "/").rpartition("/")
            _folder(folders, folder)["tags"].append(_opc_tag(tag_row, last))
    file.text = json.dumps(root, indent=2) + "\n"
    return file


def _folder(folders: dict[str, dict[str, Any]], path: str) -> dict[str, Any]:
    """Return the folder of a path; add it to its parent folder if it does not exist."""
    if path not in folders:
        parent, _, name = path.rpartition("/")
        folders[path] = {"name": name, "tagType": "Folder", "tags": []}
        _folder(folders, parent)["tags"].append(folders[path])
    return folders[path]


def _opc_tag(row: TagRow, name: str) -> dict[str, Any]:
    """Return the JSON object of a tag that reads an OPC UA node."""
    tag = {
        "name": name,
        "tagType": "AtomicTag",
        "valueSource": "opc",
        "opcServer": OPC_SERVER,
        "opcItemPath": row.node,
        "dataType": _IGNITION[row.type_name] + ("Array" if row.dims else ""),
        "readOnly": not row.writable,
    }
    return tag | ({"documentation": row.description} if row.description else {})


# --- Node-RED

_NODE_RED = dict.fromkeys(("BOOL", "SINT", "INT", "DINT", "REAL"))


def node_red(rows: Iterable[TagRow], title: str) -> TagFile:
    """Return a flow: an endpoint, a node that shows all tags, and a node for each writable tag.

    Node-RED skips members that are arrays with several dimensions, and finds an element of a BOOL array only
    as a BIT_STRING (`Tag` of ethernet-ip 1.2).
    """
    file = TagFile()
    table: dict[str, dict[str, dict[str, str]]] = {}
    writable_tags = []
    rows = list(rows)
    # members that are arrays with several dimensions
    unsupported = [row for row in rows if len(row.dims) > 1 and "." in _program_and_name(row.enip)[1]]
    file.left_out += [row.name for row in unsupported]
    for row in file.single_values((row for row in rows if row not in unsupported), _NODE_RED):
        program, name = _program_and_name(row.enip)
        kind = "BIT_STRING" if row.type_name == "BOOL" and name.endswith("]") else row.type_name
        table.setdefault(program, {})[name] = {"type": kind}
        if row.writable:
            writable_tags.append((program, name))
    flow: list[dict[str, Any]] = [
        {"id": "rack-flow", "type": "tab", "label": title},
        {
            "id": "rack-endpoint",
            "type": "eth-ip endpoint",
            "address": "127.0.0.1",
            "slot": "0",
            "cycletime": "200",
            "name": title,
            "vartable": table,
        },
        _node(
            "rack-all", "eth-ip in", 0, [["rack-show"]], mode="all", variable="", program="", name="all tags"
        ),
        _node("rack-show", "debug", 0, [], active=True, complete="payload", targetType="msg", name="tags")
        | {"x": 400},
    ]
    for number, (program, name) in enumerate(writable_tags, 1):
        flow.append(
            _node(f"rack-out-{number}", "eth-ip out", number, [], variable=name, program=program, name="")
        )
    file.text = json.dumps(flow, indent=2) + "\n"
    return file


def _program_and_name(path: str) -> tuple[str, str]:
    """Return the program in a name, "" for the controller, and the name within it."""
    match = re.fullmatch(r"Program:(\w+)\.(.+)", path)
    return (match[1], match[2]) if match else ("", path)


def _node(ident: str, kind: str, row: int, wires: list[list[str]], **more: object) -> dict[str, Any]:
    node = {"id": ident, "type": kind, "z": "rack-flow", "x": 160, "y": 60 + 60 * row, "wires": wires, **more}
    return node | ({"endpoint": "rack-endpoint"} if kind.startswith("eth-ip") else {})


FORMATS: Mapping[str, Callable[[Iterable[TagRow], str], TagFile]] = {
    "ignition": ignition,
    "kepware": kepware,
    "factorytalk": factorytalk,
    "node-red": node_red,
}
"""Functions that make a file from tags and the rack's name, by the value of `--for`."""
