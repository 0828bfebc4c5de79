"""The thousands codec: splitting and joining are inverse, and illegal pairs are refused."""

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scanrack.io_images.thousands import (
    PARAMETER_MAX,
    PARAMETER_MIN,
    REPORTED_MAX,
    is_legal_pair,
    join_reported,
    join_thousands,
    split_reported,
    split_thousands,
)

WORDS = st.integers(-32_768, 32_767)
SPLITTABLE = 32_767_999
often = settings(max_examples=5 * settings().max_examples)


def plainly_legal(msw, lsw):
    """The rule in the manual's words: LSW within ±999, not one word negative and the other positive."""
    return abs(lsw) <= 999 and not (msw < 0 < lsw) and not (lsw < 0 < msw)


@given(st.integers(-SPLITTABLE, SPLITTABLE))
@often
def test_value_to_words_to_value(value):
    msw, lsw = split_thousands(value)
    assert join_thousands(msw, lsw) == value
    assert 1000 * msw + lsw == value
    assert plainly_legal(msw, lsw)


@given(WORDS, WORDS | st.integers(-1001, 1001))
@often
def test_words_to_value_to_words(msw, lsw):
    assert is_legal_pair(msw, lsw) is plainly_legal(msw, lsw)
    if not plainly_legal(msw, lsw):
        with pytest.raises(ValueError, match="not a value"):
            join_thousands(msw, lsw)
    elif msw != -32_768:  # the one thousand that has no counterpart of the other sign
        assert split_thousands(join_thousands(msw, lsw)) == (msw, lsw)


@given(st.integers(SPLITTABLE + 1))
@often
def test_values_beyond_two_words_are_refused(value):
    for each in (value, -value):
        with pytest.raises(ValueError, match="does not fit two words"):
            split_thousands(each)


@pytest.mark.parametrize("value", [PARAMETER_MIN, PARAMETER_MAX, -1000, -999, -1, 0, 1, 999, 1000])
def test_corners(value):
    assert join_thousands(*split_thousands(value)) == value
    assert join_reported(*split_reported(value)) == value


@given(st.integers(-REPORTED_MAX, REPORTED_MAX))
@often
def test_reported_value_to_words_to_value(value):
    """But for whole thousands beyond 32,767,999, whose LSW of 0 cannot tell the sign."""
    assume(abs(value) <= SPLITTABLE or value % 1000 != 0)
    assert join_reported(*split_reported(value)) == value


@given(WORDS, st.integers(-999, 999))
@often
def test_reported_words_to_value_to_words(msw, lsw):
    value = join_reported(msw, lsw)
    assert split_reported(value) == (msw, lsw)
    assert abs(value) <= REPORTED_MAX


@given(st.integers(-(10**12), 10**12))
@often
def test_reported_words_are_the_low_16_bits_and_the_rest(value):
    msw, lsw = split_reported(value)
    assert -32_768 <= msw <= 32_767
    magnitude = abs(value)
    sign = -1 if value < 0 else 1
    assert lsw == sign * (magnitude % 1000)
    assert (msw - sign * (magnitude // 1000)) % 65_536 == 0
