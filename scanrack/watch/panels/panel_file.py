"""The file of an operator panel, such as `feeder.panel` beside `feeder.toml`.

    # a comment belongs to the table after it
    [[item]]
    name = "E-stop"
    kind = "maintained"
    tag = "slot1.input.estop"
    at = [0, 0]
    size = [3, 2]

The file has one TOML table per item, and one line per key. Tables keep their order. Keys are in the order of
`FIELDS`. A change to an item changes only its own lines.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from decimal import Decimal
from typing import Any, NamedTuple

from scanrack.io_images.doors import toml_tables

Json = dict[str, Any]

COLUMNS, ROWS = 12, 60
"""Size of the grid, cells."""

MOST_ITEMS = 100
COLORS = ("green", "red", "amber", "blue", "white")
COMMENT = "comment"
"""Key of an item's comment lines, which is not a key in the file."""


class Kind(NamedTuple):
    """A kind of item."""

    title: str  # its name in HMI editors
    types: str  # allowed types of its tag, a key of `bindings.TYPES`
    operates: bool = False  # whether it sets its tag
    needs: tuple[str, ...] = ()  # required fields in addition to those of every item
    optional: tuple[str, ...] = ()  # optional fields
    size: tuple[int, int] = (3, 2)  # size of a new item, cells


REQUIRED = ("name", "kind", "tag", "at", "size")
BIT, NUMBER, ANY = "BOOL", "a number", "one value"
_LIMITS, _FORM = ("least", "most"), ("unit", "decimals")

KINDS: Mapping[str, Kind] = {
    "momentary": Kind("momentary push button", BIT, True, optional=("color",)),
    "maintained": Kind("maintained push button", BIT, True, optional=("color",)),
    "selector": Kind(
        "selector switch", NUMBER, True, needs=("positions",), optional=("values",), size=(4, 2)
    ),
    "lamp": Kind("indicator lamp", BIT, optional=("color",), size=(2, 2)),
    "display": Kind("numeric display", ANY, optional=_FORM),
    "entry": Kind("numeric entry", NUMBER, True, needs=_LIMITS, optional=_FORM, size=(4, 2)),
    "gauge": Kind("gauge", NUMBER, needs=_LIMITS, optional=_FORM, size=(3, 3)),
}
"""The kinds of items, by `kind`."""

Check = Callable[[Any], bool]


def _text(most: int) -> Check:
    return lambda value: isinstance(value, str) and 0 < len(value) <= most and value.isprintable()


def _integer(allowed: range) -> Check:
    return lambda value: type(value) is int and value in allowed


def _number(value: object) -> bool:
    return type(value) in (int, float) and abs(value) < 1 << 53  # type: ignore[arg-type]


def _pair(*allowed: range) -> Check:
    """Return a check for a list of two integers, each in its own range."""
    checks = list(map(_integer, allowed))
    return lambda value: (
        isinstance(value, list)
        and len(value) == 2
        and all(check(entry) for check, entry in zip(checks, value, strict=True))
    )


def _different(check: Check) -> Check:
    """Return a check for a list of 2 to 8 different values that all pass another check."""
    return lambda value: (
        isinstance(value, list)
        and 2 <= len(value) <= 8
        and all(map(check, value))
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
    "decimals": (_integer(range(7)), "0 to 6"),
    "color": (lambda value: isinstance(value, str) and value in COLORS, ", ".join(COLORS)),
}
"""By field name, in file order: the check of the field, and its allowed values as text for messages."""


class Panel(NamedTuple):
    """An operator panel."""

    items: Sequence[Json] = ()
    head: Sequence[str] = ()  # comment lines at the top of the file


def parse_panel(text: str) -> Panel:
    """Return the panel from the text of a file.

    Raises:
        ValueError: the text is not TOML, or an item is not allowed.
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
    if len(comments) == len(items):  # otherwise the items are not [[item]] tables, and comments are dropped
        for item, lines in zip(items, comments, strict=True):
            item.update({COMMENT: lines} if lines else {})
    return Panel(items, head)


def _plain(value: Any) -> Any:
    """Return a TOML value with decimals converted to floats."""
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
    """Return the text of a panel file.

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
    paragraphs = ["\n".join(panel.head)] if panel.head else []
    paragraphs += ["\n".join(_lines(item)) for item in panel.items]
    return "\n\n".join(paragraphs) + "\n" if paragraphs else ""


def _lines(item: Json) -> Iterable[str]:
    """Yield the lines of an item's table, with its comment above."""
    yield from item.get(COMMENT, ())
    yield "[[item]]"
    for key in FIELDS:
        if key in item:  # the JSON of these values is also valid TOML
            yield f"{key} = {json.dumps(item[key], ensure_ascii=False)}"


def refusals(items: object) -> dict[int, str]:
    """Return the mistakes in items by index, each with the item's name, value and allowed values."""
    if not isinstance(items, list) or not all(isinstance(entry, dict) for entry in items):
        raise ValueError("item must be tables: [[item]]")
    if len(items) > MOST_ITEMS:
        raise ValueError(f"{len(items)} items: a panel has up to {MOST_ITEMS}")
    errors: dict[int, str] = {}
    names: set[str] = set()
    cells: dict[tuple[int, int], str] = {}
    for index, item in enumerate(items):
        try:
            _check(item, index)
            if item["name"] in names:
                raise ValueError(f"item {item['name']}: another item has this name")
            _reserve(item, cells)
        except ValueError as error:
            errors[index] = str(error)
        names.add(str(item.get("name")))
    return errors


def _check(item: Json, index: int) -> None:
    """Check a single item; raise ValueError for a mistake."""
    is_name, _ = FIELDS["name"]
    subject = f"item {item['name'] if is_name(item.get('name')) else index + 1}"
    kind = KINDS.get(str(item.get("kind")))
    needs, optional = ((), ()) if kind is None else (kind.needs, kind.optional)
    fields = (*REQUIRED, *needs, *optional)
    for key, value in item.items():
        is_allowed, allowed_values = FIELDS.get(key, (None, ""))
        if is_allowed is not None and not is_allowed(value):
            raise ValueError(f"{subject}: {key} {_shown(value)}: must be {allowed_values}")
        if kind is not None and key not in (*fields, COMMENT):
            raise ValueError(f"{subject}: {key} {_shown(value)}: {item['kind']} has {', '.join(fields)}")
    for key in (*REQUIRED, *needs):
        if key not in item:
            _, allowed_values = FIELDS[key]
            raise ValueError(f"{subject}: it needs {key}, {allowed_values}")
    _check_comment(item.get(COMMENT, []), subject)
    _check_together(item, subject)


def _check_comment(comment: object, subject: str) -> None:
    if not isinstance(comment, list) or not all(_text(1000)(line) and line[0] == "#" for line in comment):
        raise ValueError(f"{subject}: {COMMENT} {_shown(comment)}: must be lines that begin with #")


def _check_together(item: Json, subject: str) -> None:
    """Check the fields of an item that limit each other; raise ValueError for a mistake."""
    (column, row), (width, height) = item["at"], item["size"]
    if column + width > COLUMNS or row + height > ROWS:
        fields = f"at {item['at']} size {item['size']}"
        raise ValueError(f"{subject}: {fields}: must end within {COLUMNS} columns and {ROWS} rows")
    if "least" in item and item["least"] >= item["most"]:
        raise ValueError(f"{subject}: most {item['most']}: must be more than least, {item['least']}")
    if "values" in item and len(item["values"]) != len(item["positions"]):
        raise ValueError(f"{subject}: values {_shown(item['values'])}: must be {FIELDS['values'][1]}")


def _reserve(item: Json, cells: dict[tuple[int, int], str]) -> None:
    """Reserve the cells of an item; raise ValueError if another item has one of them."""
    (column, row), (width, height) = item["at"], item["size"]
    own_cells = [(x, y) for x in range(column, column + width) for y in range(row, row + height)]
    for cell in own_cells:
        if cell in cells:
            raise ValueError(f"item {item['name']}: at {item['at']}: {cells[cell]} is there; must be free")
    cells.update((cell, item["name"]) for cell in own_cells)


def _shown(value: object) -> str:
    text = json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= 60 else f"{text[:57]}..."
