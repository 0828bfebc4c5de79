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
    before = lines[line][:column] if line < len(lines) else ""
    path, inner = _path_to(lines[:line], before)
    value = _VALUE.search(inner)
    if value:
        return [Offer(value_text, "value") for node in _at([*path, value[1]]) for value_text in _values(node)]
    offers_by_key: dict[str, Offer] = {}
    for table in _at(path):
        for key, node in table.get("properties", {}).items():
            offers_by_key.setdefault(key, Offer(key, "key", _kind(node), node.get("description", "")))
    return list(offers_by_key.values())


def meaning(text: str, line: int, column: int) -> str:
    """Return the meaning of the key at a position, in Markdown; "" if there is no key."""
    lines = text.splitlines()
    for match in _KEY.finditer(lines[line].partition("#")[0]) if line < len(lines) else ():
        if match.start(1) <= column <= match.end(1):
            path, _ = _path_to(lines[:line], lines[line][: match.start(1)])
            for node in _at([*path, match[1]]):
                values_text = ", ".join(_values(node)) or _kind(node)
                default = f"; {node['default']} if left out" if "default" in node else ""
                return f"**{match[1]}**: {node.get('description', '')}\n\n{values_text}{default}"
    return ""


def _path_to(above: Sequence[str], before: str) -> tuple[list[str], str]:
    """Return the keys of the tables around a place, and what is written in the innermost one so far."""
    headers = [(number, match[1]) for number, line in enumerate(above) if (match := _HEADER.match(line))]
    start, header = headers[-1] if headers else (-1, "")
    path = header.replace('"', "").split(".") if headers else []
    table_text = "\n".join([*(line.partition("#")[0] for line in above[start + 1 :]), before])
    open_tables = _open_tables(table_text)
    begin = open_tables[-1][1] if open_tables else 0
    return [*path, *(key for key, _ in open_tables)], table_text[begin:].rpartition(",")[2].rpartition("\n")[
        2
    ]


def _open_tables(inside: str) -> list[tuple[str, int]]:
    """Return the key of each inline table that is still open, and where its contents begin."""
    open_tables: list[tuple[str, int]] = []
    for match in re.finditer(r'"[^"\n]*"?|[{}]', inside):
        if match[0] == "{":
            keys = _KEY.findall(re.sub(r"\{[^{}]*\}", "", inside[: match.start()]))
            open_tables.append((keys[-1] if keys else "", match.end()))
        elif match[0] == "}" and open_tables:
            open_tables.pop()
    return open_tables


def _at(path: Sequence[str]) -> Iterator[Node]:
    """Yield the parts of the schema at a path; options have one for each kind of module."""
    nodes = list(_open(_schema()))
    for key in path:
        nodes = [inner for node in nodes for inner in _below(node, key)]
    yield from nodes


def _below(node: Node, key: str) -> Iterator[Node]:
    inner = node.get("properties", {}).get(key)
    if inner is None and isinstance(node.get("additionalProperties"), dict):
        inner = node["additionalProperties"]
    if inner is not None:
        yield from _open(inner)


def _open(node: Node) -> Iterator[Node]:
    """Resolve references, arrays and choices; yield the resulting nodes, each with its own description."""
    own = {key: node[key] for key in ("description", "default") if key in node}
    if "$ref" in node:
        node = {**_schema()["$defs"][node["$ref"].rpartition("/")[2]], **own}
    if "properties" in node or not {"anyOf", "items"} & node.keys():
        yield node
    for inner in node.get("anyOf", ()):
        yield from (branch if "properties" in branch else {**branch, **own} for branch in _open(inner))
    if isinstance(node.get("items"), dict):
        yield from ({**item, **own} for item in _open(node["items"]))


def _values(node: Node) -> Iterator[str]:
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
