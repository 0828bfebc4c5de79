"""Reads and writes the file of an operator panel, `feeder.panel` beside `feeder.toml`.

    # a comment stays with the table that it precedes
    [[item]]
    name = "E-stop"
    kind = "maintained"
    tag = "slot1.input.estop"
    at = [0, 0]
    size = [3, 2]

It has a TOML table per item, and a line per key. Tables keep their order; keys have the order of `FIELDS`. A
change of an item changes only its own lines.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from decimal import Decimal
from typing import Any, NamedTuple

from scanrack.io_images.doors import toml_tables

Json = dict[str, Any]

COLUMNS, ROWS = 12, 60
"""Numbers of cells in the grid."""

MOST_ITEMS = 100
COLORS = ("green", "red", "amber", "blue", "white")
COMMENT = "comment"
"""Key of an item's comment lines; it is not a key in the file."""


class Kind(NamedTuple):
    """A kind of items."""

    title: str  # its name in HMI editors
    types: str  # allowed types of its tag
    operates: bool = False  # whether it sets its tag
    needs: tuple[str, ...] = ()  # required fields in addition to those of every item
    may: tuple[str, ...] = ()
    size: tuple[int, int] = (3, 2)  # size of a new item, cells


ALWAYS = ("name", "kind", "tag", "at", "size")
BIT, NUMBER, ANY = "BOOL", "a number", "one value"
_LIMITS, _FORM = ("least", "most"), ("unit", "decimals")

KINDS: Mapping[str, Kind] = {
    "momentary": Kind("momentary push button", BIT, True, may=("color",)),
    "maintained": Kind("maintained push button", BIT, True, may=("color",)),
    "selector": Kind("selector switch", NUMBER, True, needs=("positions",), may=("values",), size=(4, 2)),
    "lamp": Kind("indicator lamp", BIT, may=("color",), size=(2, 2)),
    "display": Kind("numeric display", ANY, may=_FORM),
    "entry": Kind("numeric entry", NUMBER, True, needs=_LIMITS, may=_FORM, size=(4, 2)),
    "gauge": Kind("gauge", NUMBER, needs=_LIMITS, may=_FORM, size=(3, 3)),
}
"""The kinds of items, by `kind`."""

Check = Callable[[Any], bool]


def _text(most: int) -> Check:
    return lambda value: isinstance(value, str) and 0 < len(value) <= most and value.isprintable()


def _whole(within: range) -> Check:
    return lambda value: type(value) is int and value in within


def _number(value: object) -> bool:
    return type(value) in (int, float) and abs(value) < 1 << 53  # type: ignore[arg-type]


def _pair(first: range, second: range) -> Check:
    takes_first, takes_second = _whole(first), _whole(second)
    return lambda value: (
        isinstance(value, list) and len(value) == 2 and takes_first(value[0]) and takes_second(value[1])
    )


def _different(of: Check) -> Check:
    return lambda value: (
        isinstance(value, list)
        and 2 <= len(value) <= 8
        and all(map(of, value))
        and len(set(value)) == len(value)
    )


FIELDS: Mapping[str, tuple[Check, str]] = {
    "name": (_text(40), "text of 1 to 40 printable characters"),
    "kind": (lambda value: isinstance(value, str) and value in KINDS, ", ".join(KINDS)),
    "tag": (_text(400), "the name of a tag, or slot1.input.home for an input"),
    "at": (
        _pair(range(COLUMNS), range(ROWS)),
        f"[column, row], columns 0 to {COLUMNS - 1}, rows 0 to {ROWS - 1}",
    ),
    "size": (_pair(range(1, COLUMNS + 1), range(1, 9)), f"[width, height], 1 to {COLUMNS} and 1 to 8"),
    "positions": (_different(_text(40)), "2 to 8 different texts"),
    "values": (_different(_number), "different numbers, one for each position"),
    "least": (_number, "a number"),
    "most": (_number, "a number"),
    "unit": (_text(12), "text of 1 to 12 printable characters"),
    "decimals": (_whole(range(7)), "0 to 6"),
    "color": (lambda value: isinstance(value, str) and value in COLORS, ", ".join(COLORS)),
}
"""The check of each field, by name, in file order."""


class Panel(NamedTuple):
    """An operator panel."""

    items: Sequence[Json] = ()
    head: Sequence[str] = ()  # comment lines at the top of the file


def parse_panel(text: str) -> Panel:
    """Return the panel in the text of a file.

    Raises:
        ValueError: it is not TOML, or an item is refused; the message has item, value and allowed values.
    """
    try:
        tables = _plain(toml_tables(text))
    except ValueError as error:
        raise ValueError(f"not TOML: {error}") from None
    for key in tables:
        if key != "item":
            raise ValueError(f"no key {key}: a panel has [[item]] tables only")
    items = tables.get("item", [])
    for refusal in refusals(items).values():
        raise ValueError(refusal)
    head, comments = _comments(text)
    if len(comments) == len(items):  # otherwise the items are written in another form
        for item, lines in zip(items, comments, strict=True):
            item.update({COMMENT: lines} if lines else {})
    return Panel(items, head)


def _plain(value: Any) -> Any:
    """Return a TOML value with its decimals as floats."""
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [_plain(inner) for inner in value]
    return float(value) if isinstance(value, Decimal) else value


def _comments(text: str) -> tuple[list[str], list[list[str]]]:
    """Return the comment lines at the top, up to an empty line, and the comment lines of each item."""
    head: list[str] = []
    comments: list[list[str]] = []
    waiting: list[str] = []
    for line in map(str.strip, text.split("\n")):
        if line.startswith("#"):
            waiting.append("".join(character if character.isprintable() else " " for character in line))
            continue
        if line == "[[item]]":
            comments.append([])
        elif not line and comments:
            continue  # the following lines belong to the next item, or to the last one
        (comments[-1] if comments else head).extend(waiting)
        waiting = []
    (comments[-1] if comments else head).extend(waiting)
    return head, comments


def panel_text(panel: Panel) -> str:
    """Return the text of a panel file; `parse_panel` reads it.

    >>> lamp = {"kind": "lamp", "name": "Run", "tag": "Run", "at": [0, 0], "size": [2, 1]}
    >>> print(panel_text(Panel([lamp])))
    [[item]]
    name = "Run"
    kind = "lamp"
    tag = "Run"
    at = [0, 0]
    size = [2, 1]
    <BLANKLINE>
    """
    parts = ["\n".join(panel.head)] if panel.head else []
    parts += ["\n".join(_lines(item)) for item in panel.items]
    return "\n\n".join(parts) + "\n" if parts else ""


def _lines(item: Json) -> Iterable[str]:
    yield from item.get(COMMENT, ())
    yield "[[item]]"
    for key in FIELDS:
        if key in item:  # the JSON of these values is also TOML
            yield f"{key} = {json.dumps(item[key], ensure_ascii=False)}"


def refusals(items: object) -> dict[int, str]:
    """Return the mistakes in items, by place: the item's name, the value, and the allowed values."""
    if not isinstance(items, list) or not all(isinstance(entry, dict) for entry in items):
        raise ValueError("item must be tables: [[item]]")
    if len(items) > MOST_ITEMS:
        raise ValueError(f"{len(items)} items: a panel has up to {MOST_ITEMS}")
    errors: dict[int, str] = {}
    names: set[str] = set()
    cells: dict[tuple[int, int], str] = {}
    for place, item in enumerate(items):
        try:
            _check(item, place)
            if item["name"] in names:
                raise ValueError(f"item {item['name']}: another item has this name")
            _take(item, cells)
        except ValueError as error:
            errors[place] = str(error)
        names.add(str(item.get("name")))
    return errors


def _check(item: Json, place: int) -> None:
    """Check a single item; raise ValueError for a mistake."""
    takes, _ = FIELDS["name"]
    subject = f"item {item['name'] if takes(item.get('name')) else place + 1}"
    kind = KINDS.get(str(item.get("kind")))
    needs, may = ((), ()) if kind is None else (kind.needs, kind.may)
    fields = (*ALWAYS, *needs, *may)
    for key, value in item.items():
        if key in FIELDS and not FIELDS[key][0](value):
            raise ValueError(f"{subject}: {key} {_shown(value)}: must be {FIELDS[key][1]}")
        if kind is not None and key not in (*fields, COMMENT):
            raise ValueError(f"{subject}: {key} {_shown(value)}: {item['kind']} has {', '.join(fields)}")
    for key in (*ALWAYS, *needs):
        if key not in item:
            raise ValueError(f"{subject}: it needs {key}, {FIELDS[key][1]}")
    _check_comment(item.get(COMMENT, []), subject)
    _check_together(item, subject)


def _check_comment(comment: object, who: str) -> None:
    if not isinstance(comment, list) or not all(_text(1000)(line) and line[0] == "#" for line in comment):
        raise ValueError(f"{who}: {COMMENT} {_shown(comment)}: must be lines that begin with #")


def _check_together(item: Json, who: str) -> None:
    """Check that the fields of an item fit each other; raise ValueError if not."""
    (column, row), (width, height) = item["at"], item["size"]
    if column + width > COLUMNS or row + height > ROWS:
        subject = f"{who}: at {item['at']} size {item['size']}"
        raise ValueError(f"{subject}: must end within {COLUMNS} columns and {ROWS} rows")
    if "least" in item and item["least"] >= item["most"]:
        raise ValueError(f"{who}: most {item['most']}: must be more than least, {item['least']}")
    if "values" in item and len(item["values"]) != len(item["positions"]):
        raise ValueError(f"{who}: values {_shown(item['values'])}: must be {FIELDS['values'][1]}")


def _take(item: Json, cells: dict[tuple[int, int], str]) -> None:
    """Reserve the cells of an item; raise ValueError if one is taken."""
    (column, row), (width, height) = item["at"], item["size"]
    own_cells = [(x, y) for x in range(column, column + width) for y in range(row, row + height)]
    for cell in own_cells:
        if cell in cells:
            raise ValueError(f"item {item['name']}: at {item['at']}: {cells[cell]} is there; must be free")
    cells.update((cell, item["name"]) for cell in own_cells)


def _shown(value: object) -> str:
    text = json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= 60 else f"{text[:57]}..."
