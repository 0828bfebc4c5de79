"""`scanrack rules`: what it prints, what it leaves out, what it refuses."""

from __future__ import annotations

import re

import pytest
from scanrack.io_images.amci3601 import RULES, Firmware, bit_names
from scanrack.io_images.amci3601.rules import Rule
from scanrack.runtime.cli import build
from scanrack.runtime.cli import rules as command
from scanrack.runtime.cli.rules_page import heading_of, page, row
from typer.testing import CliRunner


def said(*arguments):
    """Return exit status, standard output and standard error of `scanrack rules amci3601 ...`."""
    result = CliRunner().invoke(build(), ["rules", "amci3601", *arguments])
    return result.exit_code, result.stdout, result.stderr


def ids(text):
    """Return the ids that begin the entries of a listing."""
    return re.findall(r"^([A-Z]+-[A-Z]?\d+) +(?:chapter|Module|Manual)", text, re.MULTILINE)


def test_all_rules_are_printed_in_the_tables_order():
    status, text, errors = said()
    assert (status, errors) == (0, "")
    assert ids(text) == list(RULES)
    assert text.splitlines()[-1].startswith(f"{len(RULES)} rules: ")
    assert "\x1b" not in text


def test_lines_fit_80_columns_but_for_names_and_sections():
    _, text, _ = said()
    long = [line for line in text.splitlines() if len(line) > 80]
    assert all(re.search(r"^ +test_\S+$|^[A-Z]+-\w+ +chapter|tests: \S+$", line) for line in long), long


def test_an_entry_tells_everything(monkeypatch):
    tests = ("test_a.py::test_x", "test_a.py::test_y", "test_b.py::test_z")
    monkeypatch.setattr(command, "proofs", lambda rule_id: tests)
    assert list(command.entry(RULES["HOM-01"])) == [
        "HOM-01   chapter 6, Home Invalid 1",
        "         A Find Home command had a programmed speed below the starting speed.",
        "         sets: HOME_INVALID",
        "         with: CMD-05, PRF-01",
        "         reading: A-21",
        "         tests: test_a.py",
        "           test_x",
        "           test_y",
        "         tests: test_b.py",
        "           test_z",
    ]


def test_an_entry_says_why_there_is_no_test():
    assert "in no image: every command assumes it" in "\n".join(command.entry(RULES["IOM-05"]))


def test_id_takes_ids_and_prefixes_in_any_case():
    _, text, _ = said("--id", "cmd-03", "--id", "CER")
    assert ids(text) == ["CER-01", "CER-02", "CMD-03"] or ids(text) == ["CMD-03", "CER-01", "CER-02"]


def test_bit_finds_what_sets_or_clears_it():
    _, text, _ = said("--bit", "blend_ack")
    found = ids(text)
    assert found == [
        rule.id for rule in RULES.values() if "BLEND_ACK" in bit_names(rule.sets) + bit_names(rule.clears)
    ]
    assert "STS-L09" in found


def test_bits_of_the_two_words_are_not_mixed_up():
    """IN_CAPTURE is bit 0 of word 1, MOVING_CW bit 0 of word 0."""
    assert command.BITS["MOVING_CW"] == 1
    assert not set(ids(said("--bit", "IN_CAPTURE")[1])) & set(ids(said("--bit", "MOVING_CW")[1]))


def test_firmware_leaves_out_what_it_does_not_know():
    old, new = ids(said("--firmware", "2.1")[1]), ids(said("--firmware", "4.1")[1])
    assert "CMD-12" in old
    assert "CMD-12" not in new  # up to 3.1 [chapter 6, Command Error 12]
    assert "FOL-01" in new
    assert "FOL-01" not in old
    assert old == [rule.id for rule in RULES.values() if rule.applies_to(Firmware(2, 1))]


def test_untested_lists_what_could_be_tested_and_is_not(monkeypatch):
    monkeypatch.setattr(command, "proofs", lambda rule_id: () if rule_id == "CMD-03" else ("test_a.py::t",))
    status, text, _ = said("--untested")
    assert (status, ids(text)) == (1, ["CMD-03"])
    assert text.endswith("1 rule: 0 proved by tests, 0 not testable, 1 without a test\n")


def test_untested_is_content_when_there_is_none(monkeypatch):
    monkeypatch.setattr(command, "proofs", lambda rule_id: ("test_a.py::t",))
    assert said("--untested") == (0, "0 rules: 0 proved by tests, 0 not testable, 0 without a test\n", "")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--id", "CMD-99"), "unknown rule 'CMD-99' (did you mean CMD-29?): allowed are CMD-01 to CMD-36"),
        (("--id", "CMX"), "unknown rule 'CMX' (did you mean CMD?): allowed are IOM, HWS,"),
        (
            ("--bit", "COMAND_ERROR"),
            "unknown status bit 'COMAND_ERROR' (did you mean COMMAND_ERROR?): allowed",
        ),
        (("--bit", "7"), "unknown status bit '7': allowed are MOVING_CW, MOVING_CCW,"),
        (("--firmware", "3.0"), "unknown 3601 firmware '3.0': allowed are 2.0, 2.1, 2.2, 3.1, 4.1"),
    ],
)
def test_refusals(arguments, message):
    status, text, errors = said(*arguments)
    assert (status, text) == (2, "")
    assert errors.startswith(f"scanrack: {message}")


def test_markdown_has_a_row_for_every_rule_under_its_chapter():
    status, text, _ = said("--markdown")
    assert status == 0
    assert re.findall(r"^\| \*\*(\S+?)\*\*", text, re.MULTILINE) == list(RULES)
    chapter_2 = text.split("## Chapter 2")[1].split("## Chapter 3")[0]
    assert re.findall(r"\*\*([A-Z]+)-", chapter_2) == ["PRO"] * 9
    assert "](readings.md)" in text


def test_a_markdown_row():
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
