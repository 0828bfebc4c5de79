"""Keys and values at a position in a rack file, from the schema and the enclosing tables."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any

from scanrack.runtime.config.rack_schema import rack_schema

from .rungs import Offer

_HEADER = re.compile(r"^\s*\[\[?\s*([\w.\-\"]+)\s*\]\]?")
_KEY = re.compile(r"([A-Za-z_][\w-]*)\s*=")
_VALUE = re.compile(r"([A-Za-z_][\w-]*)\s*=\s*\[?\s*\"?[\w.-]*$")

Node = Mapping[str, Any]


@cache
def _schema() -> Node:
    return rack_schema()


def offers(text: str, line: int, column: int) -> list[Offer]:
    """Return the keys or the values that are allowed at a position.

    Args:
        line: from 0.
        column: from 0.
    """
    lines = text.splitlines()
    line_start = lines[line][:column] if line < len(lines) else ""
    path, entry = _context(lines[:line], line_start)
    value = _VALUE.search(entry)
    if value:
        nodes = _nodes_at([*path, value[1]])
        return [Offer(value_text, "value") for node in nodes for value_text in _values(node)]
    offers_by_key: dict[str, Offer] = {}
    for table in _nodes_at(path):
        for key, node in table.get("properties", {}).items():
            offers_by_key.setdefault(key, Offer(key, "key", _kind(node), node.get("description", "")))
    return list(offers_by_key.values())


def meaning(text: str, line: int, column: int) -> str:
    """Return the meaning of the key at a position, in Markdown; "" if there is no key."""
    lines = text.splitlines()
    for match in _KEY.finditer(lines[line].partition("#")[0]) if line < len(lines) else ():
        if match.start(1) <= column <= match.end(1):
            path, _ = _context(lines[:line], lines[line][: match.start(1)])
            for node in _nodes_at([*path, match[1]]):
                values_text = ", ".join(_values(node)) or _kind(node)
                default = f"; {node['default']} if left out" if "default" in node else ""
                return f"**{match[1]}**: {node.get('description', '')}\n\n{values_text}{default}"
    return ""


def _context(lines_above: Sequence[str], line_start: str) -> tuple[list[str], str]:
    """Return the keys of the tables around a position, and the text of the entry before the position."""
    headers = [
        (number, match[1]) for number, line in enumerate(lines_above) if (match := _HEADER.match(line))
    ]
    header_line, header = headers[-1] if headers else (-1, "")
    path = header.replace('"', "").split(".") if headers else []
    code = [line.partition("#")[0] for line in lines_above[header_line + 1 :]]
    table_text = "\n".join([*code, line_start])
    open_tables = _open_tables(table_text)
    _, begin = open_tables[-1] if open_tables else ("", 0)
    entry = table_text[begin:].rpartition(",")[2].rpartition("\n")[2]
    return [*path, *(key for key, _ in open_tables)], entry


def _open_tables(table_text: str) -> list[tuple[str, int]]:
    """Return the key and the offset of the contents of each inline table that is still open."""
    open_tables: list[tuple[str, int]] = []
    for match in re.finditer(r'"[^"\n]*"?|[{}]', table_text):
        if match[0] == "{":
            keys = _KEY.findall(re.sub(r"\{[^{}]*\}", "", table_text[: match.start()]))
            open_tables.append((keys[-1] if keys else "", match.end()))
        elif match[0] == "}" and open_tables:
            open_tables.pop()
    return open_tables


def _nodes_at(path: Sequence[str]) -> list[Node]:
    """Return the nodes of the schema at a path; options have a node for each kind of module."""
    nodes = list(_resolved(_schema()))
    for key in path:
        nodes = [child for node in nodes for child in _children(node, key)]
    return nodes


def _children(node: Node, key: str) -> Iterator[Node]:
    """Yield the nodes of a key in a table of the schema; a table with free keys has one for all of them."""
    inner = node.get("properties", {}).get(key)
    if inner is None and isinstance(node.get("additionalProperties"), dict):
        inner = node["additionalProperties"]
    if inner is not None:
        yield from _resolved(inner)


def _resolved(node: Node) -> Iterator[Node]:
    """Resolve references, arrays and choices; yield the resulting nodes with their own descriptions."""
    own_fields = {key: node[key] for key in ("description", "default") if key in node}
    if "$ref" in node:
        node = {**_schema()["$defs"][node["$ref"].rpartition("/")[2]], **own_fields}
    if "properties" in node or not {"anyOf", "items"} & node.keys():
        yield node
    for inner in node.get("anyOf", ()):
        yield from (
            branch if "properties" in branch else {**branch, **own_fields} for branch in _resolved(inner)
        )
    if isinstance(node.get("items"), dict):
        yield from ({**item, **own_fields} for item in _resolved(node["items"]))


def _values(node: Node) -> Iterator[str]:
    """Yield the values that a node allows, as TOML; nothing if it does not list them."""
    for choice in node.get("enum", [node["const"]] if "const" in node else ()):
        yield f'"{choice}"' if isinstance(choice, str) else str(choice).lower()
    if node.get("type") == "boolean":
        yield from ("true", "false")


def _kind(node: Node) -> str:
    """Return the type of a value and its limits."""
    name = str(node.get("type", "one of several" if "enum" in node else "table"))
    low, high = node.get("minimum"), node.get("maximum")
    if low is None:
        return name
    return f"{name}, {low:g} or more" if high is None else f"{name}, {low:g} to {high:g}"
