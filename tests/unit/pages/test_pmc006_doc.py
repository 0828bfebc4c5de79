"""The page about the PMC006: its tables are the project's, its examples run."""

from __future__ import annotations

import doctest
from collections.abc import Sequence
from pathlib import Path

import pytest
from scanrack.io_images.pmc006.instructions import INSTRUCTIONS, InstructionRow, Kind, ParameterStorage
from scanrack.io_images.pmc006.program import USER_OPS, UserOp
from scanrack.runtime.controllers.pmc006.interpreter import CMP_OPTIONS, WAIT_OPTIONS

PAGE = Path(__file__).parents[3] / "docs" / "pmc006.md"
KEPT = {ParameterStorage.SAVED: "`t`", ParameterStorage.EEPROM: "at once", ParameterStorage.VOLATILE: ""}


def instruction(row: InstructionRow) -> Sequence[str]:
    parameter = row.kind is Kind.SET and row.name not in ("set_position", "speed_mode")
    return (
        f"`{row.char}` {row.code:02X}",
        f"`{row.name}`",
        row.kind.value,
        f"{row.allowed} {row.unit}".strip(),
        str(row.default) if parameter else "",
        KEPT[row.keeping],
        "; ".join(text for text in (row.meaning, row.note) if text),
    )


def user_instruction(op: UserOp) -> Sequence[str]:
    first, last = op.options
    usual = "" if op.usual is None else f" (manual: {op.usual[0]} to {op.usual[1]})"
    return op.name, str(first) if first == last else f"{first} to {last}", op.allowed_data + usual, op.meaning


TABLES = {
    "byte name  data default kept meaning and notes": list(map(instruction, INSTRUCTIONS)),
    "command option data meaning": list(map(user_instruction, USER_OPS.values())),
    "option WAIT CMP": [
        (str(n), WAIT_OPTIONS.get(n, "-")[0], CMP_OPTIONS.get(n, "-")[0])
        for n in sorted(WAIT_OPTIONS | CMP_OPTIONS)
    ],
}


@pytest.mark.parametrize("rows", TABLES.values(), ids=TABLES)
def test_the_tables_are_those_that_the_code_goes_by(rows: Sequence[Sequence[str]]) -> None:
    text = "".join(f"| {' | '.join(cells)} |\n" for cells in [["---"] * len(rows[0]), *rows])
    assert text in PAGE.read_text(encoding="utf-8")


def test_examples_of_the_page() -> None:
    results = doctest.testfile(str(PAGE), module_relative=False)
    assert results.attempted >= 4
    assert results.failed == 0
