"""The page of rack files, docs/rack-file.md, from their JSON schema: each table with its keys."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from scanrack.runtime.config.rack_schema import rack_schema

PAGE = Path(__file__).parents[2] / "docs/rack-file.md"
REMEDY = "python -m tests.tools.generate rack"
INTRO = """\
# The rack file

All keys of a rack file, with their meaning, limits and defaults. `scanrack editor schema --write` gives an
[editor](editor.md) the same; [Run](run.md) and [the machine](machine.md) show files. Any other key is
refused.
A rack can be a Python file, too: its function `rack()` returns a `scanrack.RackSpec` with the same keys.
`python -m tests.tools.generate` makes this page from the schema; don't edit it.
"""
REFERENCE = "#/$defs/"


def tables(schema: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield each table below its heading, and after it those within it; one at several keys has them all."""
    rows = [("The file", schema)]
    while rows:
        heading, table = rows.pop(0)
        yield heading, table
        path = "" if table is schema else f"{heading.strip('`[]')}."
        below = [row for key, each in table["properties"].items() for row in parts(path, key, each)]
        below += [(f"Options of {modules(each)}", target(each)) for each in table.get("anyOf", ())]
        places: dict[str, list[str]] = {}
        for words, name in below:
            places.setdefault(name, []).append(words)
        rows[:0] = [(", ".join(words), schema["$defs"][name]) for name, words in places.items() if name]


def parts(path: str, key: str, node: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the heading and the name of the table that a key holds: one, a list of them, or one by name."""
    full = f"{'slot.options.' if path.startswith('Options of ') else path}{key}"
    held = (node, node.get("items"), node.get("additionalProperties"))
    for words, inner in zip((f"[{full}]", f"[[{full}]]", f"[{full}.NAME]"), held, strict=True):
        if isinstance(inner, Mapping) and "$ref" in inner:
            yield f"`{words}`", inner["$ref"].removeprefix(REFERENCE)


def modules(branch: Mapping[str, Any]) -> str:
    """Return the modules of a branch, as a heading names them."""
    names = branch["properties"]["module"].get("enum", [])
    return "cards" if len(names) > 1 else "".join(names)


def target(branch: Mapping[str, Any]) -> str:
    """Return the name of the table of a branch's options; none of the branch for unknown modules."""
    return str(branch["properties"].get("options", {}).get("$ref", "")).removeprefix(REFERENCE)


def lines() -> Iterator[str]:
    """Yield the lines of all tables: a heading, what it is, and a row for each key."""
    for heading, table in tables(rack_schema()):
        required = table.get("required", [])
        yield from ("", f"## {heading}", "", table["description"], "")
        yield from ("| key | meaning | allowed | if left out |", "|---|---|---|---|")
        for key, node in table["properties"].items():
            default = "required" if key in required else json_of(node["default"]) if "default" in node else ""
            row = (f"`{key}`", node["description"], allowed(node), default)
            yield f"| {' | '.join(cell(each) for each in row)} |"


def allowed(node: Mapping[str, Any]) -> str:
    """Return what a key takes: names, a kind of value, its limits."""
    if "anyOf" in node:
        return " or ".join(allowed(each) for each in node["anyOf"])
    if "enum" in node or "const" in node:
        return ", ".join(json_of(each) for each in node.get("enum", [node.get("const")]))
    if "examples" in node:
        return f"{', '.join(map(json_of, node['examples']))}, or a name of `modules`"
    kind = node.get("type", "table" if "$ref" in node else "any value")
    if kind == "array":
        return f"list: {allowed(node['items'])}"
    words = " or ".join([kind] if isinstance(kind, str) else kind).replace("object", "table")
    return f"{words.replace('string', 'text').replace('boolean', 'true, false')}{limits(node)}"


def limits(node: Mapping[str, Any]) -> str:
    """Return the limits of a number."""
    low, above, high = (node.get(each) for each in ("minimum", "exclusiveMinimum", "maximum"))
    words = [f"above {number(above)}"] if above is not None else []
    words += [f"from {number(low)}"] if low is not None and above is None else []
    words += [f"to {number(high)}"] if high is not None else []
    return f", {' '.join(words)}" if words else ""


def number(value: float) -> str:
    """Return a number as text: 1,000,000 and 0.01."""
    return f"{int(value):,}" if value == int(value) else f"{value:f}".rstrip("0")


def json_of(value: Any) -> str:
    """Return a value as TOML has it."""
    return f"`{json.dumps(value)}`"


def cell(text: str) -> str:
    """Return a text as it stands in a table."""
    return re.sub(r"\s+", " ", text).strip().replace("|", "\\|")


def page() -> str:
    """Return the page as it should be."""
    return INTRO + "\n".join(lines()) + "\n"
