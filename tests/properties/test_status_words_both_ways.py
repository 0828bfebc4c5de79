"""Status: meaning to words and back, words to meaning and back, and the live view agrees with both."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scanrack.io_images.amci3601 import ConfigurationStatus, Firmware, Status, StatusView, status_names
from scanrack.io_images.image import Image

often = settings(max_examples=5 * settings().max_examples)
very_often = settings(max_examples=20 * settings().max_examples)

WORD = st.integers(-32_768, 32_767)
BITS = [name for name, kind in Status.__annotations__.items() if kind == "bool"]
# Whole thousands beyond 32,767,999 have an LSW of 0, which cannot tell the sign of a wrapped MSW.
VALUE = st.integers(-65_535_999, 65_535_999).filter(lambda value: abs(value) <= 32_767_999 or value % 1000)
STATUS = st.builds(
    Status,
    **{name: st.booleans() for name in BITS},
    **dict.fromkeys(("position", "encoder", "captured"), VALUE),
)
RESERVED = 1 << 6 | 1 << 11 | 1 << 13 | 1 << 14 | 1 << 15


def test_every_bit_is_a_field():
    """15 bits of the MSW, whose 16th is the mode, and 11 of the LSW [chapter 6]."""
    assert len(BITS) == 15 + 11


@pytest.mark.slow
@given(STATUS)
@often
def test_meaning_to_words_to_meaning(status):
    image = status.to_image()
    assert Status.from_image(image) == status
    view = StatusView(image)
    lit = [name for name in BITS if getattr(status, name)]
    assert [name for name in BITS if getattr(view, name.upper())] == lit
    assert [name.lower() for name in status_names(image[0], image[1])] == lit
    assert (view.position, view.encoder, view.captured) == (status.position, status.encoder, status.captured)


@pytest.mark.slow
@given(
    st.tuples(
        st.integers(0, 0x7FFF) | WORD,
        WORD.map(lambda word: word & 0xFFFF & ~RESERVED) | WORD,
        *[WORD, st.integers(-999, 999) | st.integers(-1001, 1001)] * 3,
    )
)
@very_often
def test_words_to_meaning_to_words(words):
    image = Image(words)
    legal = words[0] >= 0 and not words[1] & RESERVED and all(abs(words[index]) <= 999 for index in (3, 5, 7))
    if legal:
        assert Status.from_image(image).to_image() == image
    else:
        with pytest.raises(ValueError, match="word"):
            Status.from_image(image)


@pytest.mark.parametrize("name", ["position", "encoder", "captured"])
def test_values_out_of_range_are_refused(name):
    for value in (-65_536_000, 65_536_000):
        wrong: dict[str, Any] = {name: value}
        with pytest.raises(ValueError, match=f"{name} {value} is out of range"):
            Status(**wrong)


CONFIGURATION_STATUS = st.builds(
    ConfigurationStatus,
    st.tuples(st.integers(0, 0x1FFF), WORD, WORD, WORD),
    st.booleans(),
    st.booleans(),
    st.builds(Firmware, st.integers(0, 99), st.integers(0, 99)),
)


@given(CONFIGURATION_STATUS)
@often
def test_configuration_mode_meaning_to_words_to_meaning(status):
    assert ConfigurationStatus.from_image(status.to_image()) == status


@given(st.tuples(WORD, WORD, WORD, WORD, *[st.sampled_from([0, 0, 0, 1])] * 2, WORD, WORD))
@often
def test_configuration_mode_words_to_meaning_to_words(words):
    image = Image(words)
    if words[0] < 0 and words[4:6] == (0, 0):
        assert ConfigurationStatus.from_image(image).to_image() == image
    else:
        with pytest.raises(ValueError, match="word"):
            ConfigurationStatus.from_image(image)


@given(st.tuples(*[WORD] * 8))
@often
def test_view_reads_any_words(words):
    """What logic sees is never refused; it agrees with the names that people see."""
    view = StatusView(Image(words))
    names = [name.upper() for name in BITS] + ["MODE_CONFIG"]
    assert sorted(name for name in names if getattr(view, name)) == sorted(status_names(words[0], words[1]))
    assert all(isinstance(value, int) for value in (view.position, view.encoder, view.captured))
