"""Names of words and bits as a trace has them, and as a forged one may have them."""

from __future__ import annotations

import json

import pytest
from scanrack.io_images.amci3601 import WORDS_3601
from scanrack.io_images.module_words import BitPlace, ModuleWords
from scanrack.traces import SlotInfo
from scanrack.traces.format.named_words import names_key, names_text, recorded_words
from scanrack.traces.format.schema import scan_schema

CARD = ModuleWords(
    "Card",
    tuple(f"out{index}" for index in range(8)),
    tuple(f"in{index}" for index in range(8)),
    {"input": {"start": BitPlace("I", 0, 3)}, "output": {"lamp": BitPlace("O", 7, 15)}},
)
SCHEMA = scan_schema([SlotInfo(1, "amci3601"), SlotInfo(4, "a card", "", CARD), SlotInfo(6, "toy")]).text


def test_what_is_written_is_read() -> None:
    found = recorded_words(SCHEMA, {names_key(4): names_text(CARD)})
    assert (found[1], found[4], found[6].message) == (WORDS_3601, CARD, "Plain")
    assert found[1].groups is WORDS_3601.groups
    assert found[4].groups == CARD.groups


def test_a_module_that_answers_as_a_3601_is_known_by_its_words_and_not_by_its_name() -> None:
    text = scan_schema([SlotInfo(2, "made by somebody else", "", WORDS_3601)]).text
    assert recorded_words(text, {})[2] is WORDS_3601


@pytest.mark.parametrize(
    "names",
    [
        [],
        {"input": []},
        {"input": {"start": 5}},
        {"input": {"start": ["I", 0]}},
        {"input": {"start": ["X", 0, 0]}},
        {"input": {"start": ["I", 8, 0]}},
        {"input": {"start": ["I", 0, 16]}},
        {"input": {"start": ["I", True, 0]}},
        {"input": {"start": [["I"], 0, 0]}},
        {"input": {"\x1b[2J": ["I", 0, 0]}},
    ],
)
def test_names_that_cannot_be_are_refused(names: object) -> None:
    with pytest.raises(ValueError, match="bit"):
        recorded_words(SCHEMA, {names_key(4): json.dumps(names)})


def test_names_without_an_end_are_refused() -> None:
    with pytest.raises(ValueError, match="names of bits"):
        recorded_words(SCHEMA, {names_key(4): "[" * 9})


@pytest.mark.parametrize(
    "schema",
    [
        "",
        "uint32 scan\nuint32 flags\nCard slot4\n",
        SCHEMA.replace("int16 in1\n", "int16 in0\n"),
        SCHEMA[:200],
    ],
)
def test_words_that_the_schema_does_not_give_are_left_out(schema: str) -> None:
    assert 4 not in recorded_words(schema, {})
