"""`scanrack rules`: what it prints, what it leaves out, what it refuses."""

from __future__ import annotations

import json
import re

import pytest
from drive_unit import MODELS
from scanrack.commands import build
from scanrack.commands.programs import rules as command
from scanrack.io_images.amci3601 import RULES, Firmware, bit_names
from scanrack.io_images.drives.rules import rules_of
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
    assert text.splitlines()[-1].startswith(f"{len(RULES)} rules, ")
    assert "\x1b" not in text


def test_lines_fit_80_columns_but_for_sections():
    _, text, _ = said()
    long = [line for line in text.splitlines() if len(line) > 80]
    assert all(re.search(r"^[A-Z]+-\w+ +chapter", line) for line in long), long


def test_an_entry_tells_everything():
    assert list(command.entry(RULES["HOM-01"])) == [
        "HOM-01   chapter 6, Home Invalid 1",
        "         A Find Home command had a programmed speed below the starting speed.",
        "         sets: HOME_INVALID",
        "         with: CMD-05, PRF-01",
        "         reading: A-21",
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


def test_the_count_tells_how_many_no_image_can_show():
    hidden = sum(bool(rule.untestable_because) for rule in RULES.values())
    assert command.count(list(RULES.values())) == f"{len(RULES)} rules, {hidden} in no image"
    assert command.count([RULES["CMD-03"]]) == "1 rule, 0 in no image"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--id", "CMD-99"), "unknown rule 'CMD-99' (did you mean CMD-29?); choose from CMD-01 to CMD-36"),
        (("--id", "CMX"), "unknown rule 'CMX' (did you mean CMD?); choose from IOM, HWS,"),
        (
            ("--bit", "COMAND_ERROR"),
            "unknown status bit 'COMAND_ERROR' (did you mean COMMAND_ERROR?); choose from",
        ),
        (("--bit", "7"), "unknown status bit '7'; choose from MOVING_CW, MOVING_CCW,"),
        (("--firmware", "3.0"), "unknown 3601 firmware '3.0'; choose from 2.0, 2.1, 2.2, 3.1, 4.1"),
    ],
)
def test_refusals(arguments, message):
    status, text, errors = said(*arguments)
    assert (status, text) == (2, "")
    assert errors.startswith(f"scanrack: {message}")


class TestDrives:
    def said(self, *arguments):
        result = CliRunner().invoke(build(), ["rules", *arguments])
        return result.exit_code, result.stdout, result.stderr

    @pytest.mark.parametrize("name", sorted(MODELS))
    def test_the_rules_of_a_model(self, name):
        status, text, errors = self.said(name)
        assert (status, errors) == (0, "")
        rules = rules_of(MODELS[name])
        assert text.splitlines()[-1] == f"{len(rules)} rules, 0 in no image"
        assert all(rule.id in text for rule in rules)

    def test_an_anf2_has_its_own(self):
        ids = {rule.id for rule in rules_of(MODELS["anf2"])}
        assert {"CFG-02", "CFG-11", "CMD-19"} <= ids
        assert not ids & {"CFG-01", "JOG-01", "DRV-01"}
        assert "CFG-11" not in {rule.id for rule in rules_of(MODELS["smd23e2"])}

    def test_by_bit(self):
        _, text, _ = self.said("smd23e2", "--bit", "stall_detected", "--json")
        assert [row["id"] for row in json.loads(text)["rules"]] == ["DRV-03"]

    def test_no_firmware(self):
        status, _, errors = self.said("smd23e2", "--firmware", "4.1")
        assert status == 2
        assert "--firmware 4.1: the rules of a smd23e2 do not differ by version" in errors
