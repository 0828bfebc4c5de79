"""The page of rules, docs/rules-amci3601.md: a heading a chapter and section, a row a rule."""

from __future__ import annotations

import re

from rule_proofs import PAGE, REMEDY
from rules_page import heading_of, page, row
from scanrack.io_images.amci3601 import RULES, Firmware
from scanrack.io_images.amci3601.rules import Rule


def test_the_page_has_a_row_for_every_rule_under_its_chapter():
    text = page(list(RULES.values()), lambda rule_id: ())
    assert re.findall(r"^\| \*\*(\S+?)\*\*", text, re.MULTILINE) == list(RULES)
    chapter_2 = text.split("## Chapter 2")[1].split("## Chapter 3")[0]
    assert re.findall(r"\*\*([A-Z]+)-", chapter_2) == ["PRO"] * 9
    assert "](readings.md)" in text


def test_the_page_says_of_every_rule_what_the_table_says():
    """All but its tests, which `tests/tools/rule_proofs.py` collects."""
    told = [re.sub(r"\| [^|]*\|$", "|", line) for line in PAGE.read_text("utf-8").splitlines()]
    stale = [
        rule.id for rule in RULES.values() if re.sub(r"\| [^|]*\|$", "|", row(rule, lambda _: ())) not in told
    ]
    assert stale == [], REMEDY


def test_a_row():
    rule = Rule(
        "X-01",
        "chapter 4, Hold Move note 1",
        "This | or that.",
        sets=0x0004,
        clears=0x0001,
        together_with=("CMD-01",),
        firmware_from=Firmware(3, 1),
        reading=("A-01", "A-02"),
    )
    assert row(rule, lambda rule_id: ("test_a.py::test_x", "test_a.py::test_y")) == (
        "| **X-01**<br>firmware from 3.1 | *chapter 4, Hold Move note 1*<br>This \\| or that. "
        "| + HOLD_STATE<br>- MOVING_CW<br>with CMD-01 | A-01, A-02 | test_a.py<br>· test_x<br>· test_y |"
    )
    assert heading_of(rule) == "Hold Move"


def test_part_of_the_table_is_a_page_too():
    text = page([RULES["CMD-03"]], lambda rule_id: ())
    assert text.count("\n## ") == text.count("\n### ") == 1
    assert "\n### Command Error\n" in text
