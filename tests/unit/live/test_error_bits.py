"""Error bits of modules: the scan in which one comes on [3601 manual, chapter 6, Status Word MSW].

Broken on purpose: the first row of a batch left out, a configuration's mirror read as status.
"""

import numpy as np
import pytest
from scanrack.io_images.amci3601 import WORDS_3601
from scanrack.io_images.module_words import BitPlace, ModuleWords, numbered
from scanrack.watch.monitors.troubles import ErrorWatch

ROW = np.dtype([("scan", np.uint32), ("words", np.int16, (32,))])
CARD = ModuleWords(
    "Analog",
    numbered(8),
    numbered(8),
    {"status": {"level_over": BitPlace("I", 5, 1), "level_under": BitPlace("I", 5, 2)}},
    errors=("level_over", "level_under"),
)
INPUT_ERROR, COMMAND_ERROR, CONFIG_ERROR, MODE_CONFIG = 1 << 11, 1 << 12, 1 << 13, -(1 << 15)


def rows(*status, card=()):
    """Return rows with a 3601's status word MSW, and word 5 of a card's inputs."""
    made = np.zeros(len(status), ROW)
    made["words"][:, 8] = status
    made["words"][: len(card), 16 + 8 + 5] = card
    return made


def watch():
    return ErrorWatch({1: WORDS_3601, 2: CARD})


@pytest.mark.parametrize(
    ("given", "found"),
    [
        (rows(0, 0, INPUT_ERROR, INPUT_ERROR), (2, 1, "INPUT_ERROR", "Local:1:I.Data[0].11")),
        (rows(COMMAND_ERROR, 0, COMMAND_ERROR), (2, 1, "COMMAND_ERROR", "Local:1:I.Data[0].12")),
        (rows(0, 1 << 10), None),  # POSITION_INVALID is no error
        (rows(0, MODE_CONFIG | COMMAND_ERROR), None),  # a mirror of the configuration
        (rows(0, MODE_CONFIG | CONFIG_ERROR), (1, 1, "CONFIG_ERROR", "Local:1:I.Data[0].13")),
        (rows(0, 0, 0, card=(0, 4, 4)), (1, 2, "level_under", "Local:2:I.Data[5].2")),
        (rows(0, INPUT_ERROR, 0, card=(0, 0, 2)), (1, 1, "INPUT_ERROR", "Local:1:I.Data[0].11")),
    ],
)
def test_the_first_error_bit_that_comes_on_is_found(given, found):
    first = watch().first(given)
    assert (None if first is None else (first[0], first[1].slot, first[1].name, first[1].address)) == found


def test_a_bit_that_comes_on_between_two_batches_is_found_and_one_that_is_on_is_not():
    errors = watch()
    assert errors.first(rows(0, 0)) is None
    assert errors.first(rows()) is None
    found = errors.first(rows(INPUT_ERROR, INPUT_ERROR))
    assert found is not None
    assert found[0] == 0
    assert errors.first(rows(INPUT_ERROR)) is None
    errors.clear()
    assert errors.first(rows(0 | INPUT_ERROR)) is None  # the first row of all
