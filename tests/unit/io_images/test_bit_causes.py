"""Each status bit of a 3601 has a row that says what makes it, beside the rules of the manual."""

import pytest
from scanrack.io_images.amci3601 import RULES
from scanrack.io_images.amci3601.bits import StatusLsw, StatusMsw
from scanrack.io_images.amci3601.rules.causes import ROWS, cause_of

BITS = [(0, bit) for bit in StatusMsw] + [(1, bit) for bit in StatusLsw]


@pytest.mark.parametrize(("word", "bit"), BITS, ids=lambda each: getattr(each, "name", str(each)))
def test_each_bit_has_a_row_with_rules_of_its_section(word, bit):
    number = bit.value.bit_length() - 1
    row = cause_of(word, number)
    assert row is not None
    assert row.bit is bit
    assert [RULES[each].section for each in row.rules] == [
        f"chapter 6, Status Word {'ML'[word]}SW bit {number}"
    ]
    assert row.on != row.off


def test_each_bit_has_one_row():
    assert len(ROWS) == len({(type(row.bit), row.bit) for row in ROWS}) == len(BITS)


def test_reserved_bits_and_other_words_have_none():
    assert [cause_of(1, 6), cause_of(1, 15), cause_of(2, 0)] == [None, None, None]
