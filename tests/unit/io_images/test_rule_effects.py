"""A rule's effect stands in its row: whatever the module fires sets a bit that the rule table names."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from scanrack.io_images.amci3601 import RULES, WORDS_3601
from scanrack.io_images.amci3601.configuration import INVALID_CONFIGURATIONS
from scanrack.io_images.amci3601.rules.rule import COMMAND_ERROR, CONFIG_ERROR, INVALID_PROFILE
from scanrack.runtime.modules import amci3601
from scanrack.runtime.modules.amci3601.latches import BrokenRule, Latches, bits_of

FIRES = {"fire", "_refuse", "abort_homing", "BrokenRule", "RefusalRule"}


def fired() -> Iterator[str]:
    """Return every id of a rule that a call in the package gives to what fires it."""
    for file in Path(amci3601.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if (
                isinstance(node, ast.Call)
                and getattr(node.func, "attr", getattr(node.func, "id", "")) in FIRES
            ):
                constants = (each.value for each in node.args if isinstance(each, ast.Constant))
                yield from (each for each in constants if isinstance(each, str) and each in RULES)


@pytest.mark.parametrize("rule", sorted(set(fired())))
def test_whatever_is_fired_sets_a_bit(rule: str) -> None:
    assert BrokenRule(rule).all_bits(WORDS_3601)


def test_the_rules_fired_are_found() -> None:
    assert {"CMD-03", "REG-10", "LSW-08", "BLD-13", "HOM-05", "POS-02"} <= set(fired())


@pytest.mark.parametrize(
    ("rule", "bits"),
    [("RST-02", COMMAND_ERROR), ("BLD-12", INVALID_PROFILE), ("BLD-13", COMMAND_ERROR | INVALID_PROFILE)],
)
def test_a_rule_without_a_consequence_in_the_manual_sets_what_its_reading_says(rule: str, bits: int) -> None:
    assert RULES[rule].sets == 0
    assert bits_of(rule, WORDS_3601) == bits


def test_a_rejected_configuration_latches_its_error_and_not_the_mode() -> None:
    assert {bits_of(rule, WORDS_3601) for rule, _ in INVALID_CONFIGURATIONS} == {CONFIG_ERROR}


def test_a_rule_that_is_noted_only_sets_nothing_and_is_recorded() -> None:
    events: list = []
    latches = Latches(events)
    before = latches.bits
    latches.note(5, "PRG-01")
    assert latches.bits == before
    assert [(each.name, each.fields["bits"]) for each in events] == [("PRG-01", [])]
