"""docs/units.md: its examples run, and its tables are those of the codecs."""

from __future__ import annotations

import doctest
import re
from pathlib import Path

import pytest
from scanrack.io_images.amci3601 import CommandMsw
from scanrack.io_images.thousands import split_thousands

PAGE = Path(__file__).parents[3] / "docs" / "units.md"
TEXT = PAGE.read_text(encoding="utf-8")


def test_examples_of_the_page() -> None:
    results = doctest.testfile(str(PAGE), module_relative=False)
    assert results.attempted >= 5
    assert results.failed == 0


@pytest.mark.parametrize("row", re.findall(r"^\| (-?[\d,]+) \| (-?\d+) \| (-?\d+) \|$", TEXT, re.MULTILINE))
def test_the_words_of_a_value(row: tuple[str, str, str]) -> None:
    value, msw, lsw = (int(each.replace(",", "")) for each in row)
    assert split_thousands(value) == (msw, lsw)


def test_the_table_of_command_bits() -> None:
    (table,) = re.findall(r"## Command bits.*?(\| bit .*?)\n\n", TEXT, re.DOTALL)
    said = {
        int(bit): name.upper().replace(" ", "_")
        for bit, name in re.findall(r"(\d+) \| ([a-zC ]+[a-zW]) \|", table)
    }
    bits = {each.value.bit_length() - 1: str(each.name) for each in CommandMsw}
    assert said == {bit: name for bit, name in bits.items() if bit < 14}
