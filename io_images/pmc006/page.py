"""The tables of docs/pmc006.md, written from the instruction tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from .instructions import INSTRUCTIONS, InstructionRow, Kind, ParameterStorage
from .program import CMP_OPTIONS, USER_OPS, WAIT_OPTIONS, UserOp

_KEPT = {ParameterStorage.SAVED: "`t`", ParameterStorage.EEPROM: "at once", ParameterStorage.VOLATILE: ""}


def instruction_table() -> str:
    """Return the instruction summary as a Markdown table."""
    head = ("byte", "name", "", "data", "default", "kept", "meaning and notes")
    return _table(head, (_instruction(row) for row in INSTRUCTIONS))


def user_table() -> str:
    """Return the user instructions as a Markdown table."""
    return _table(("command", "option", "data", "meaning"), (_user(op) for op in USER_OPS.values()))


def option_table() -> str:
    """Return the meanings of WAIT and CMP options as a Markdown table."""
    numbers = sorted(WAIT_OPTIONS | CMP_OPTIONS)
    rows = ((str(n), WAIT_OPTIONS.get(n, "-"), CMP_OPTIONS.get(n, "-")) for n in numbers)
    return _table(("option", "WAIT", "CMP"), rows)


def _instruction(row: InstructionRow) -> Sequence[str]:
    parameter = row.kind is Kind.SET and row.name not in ("set_position", "speed_mode")
    return (
        f"`{row.char}` {row.code:02X}",
        f"`{row.name}`",
        row.kind.value,
        f"{row.allowed} {row.unit}".strip(),
        str(row.default) if parameter else "",
        _KEPT[row.keeping],
        "; ".join(text for text in (row.meaning, row.note) if text),
    )


def _user(op: UserOp) -> Sequence[str]:
    first, last = op.options
    usual = "" if op.usual is None else f" (manual: {op.usual[0]} to {op.usual[1]})"
    return op.name, str(first) if first == last else f"{first} to {last}", op.allowed_data + usual, op.meaning


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = (head, ["---"] * len(head), *rows)
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)
