"""Blend blocks: meaning to words and back, words to meaning and back, and nothing illegal gets through."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scanrack.io_images.amci3601 import Acceleration, BlendHeader, BlendSegment
from scanrack.io_images.image import Image

often = settings(max_examples=5 * settings().max_examples)
very_often = settings(max_examples=20 * settings().max_examples)

WORD = st.integers(-32_768, 32_767)
TYPE = st.sampled_from(Acceleration)
HEADERS = st.builds(
    BlendHeader, st.lists(TYPE, min_size=2, max_size=16).map(tuple), st.integers(1, 2000), TYPE
)
SEGMENTS = st.builds(BlendSegment, st.integers(1, 8_388_607), st.integers(1, 1_000_000), st.integers(1, 2000))


def header_legal(words):
    """Chapter 5, first programming block, written out a second time."""
    msw, lsw, count, late, early, last, *rest = (word & 0xFFFF for word in words)
    if (msw, lsw, rest) != (0, 0x0300, [0, 0]) or not 2 <= count <= 16:
        return False
    pairs = [word >> shift & 3 for word in (early, late) for shift in range(0, 16, 2)]
    types = all(pair in (0b00, 0b01, 0b11) for pair in pairs[:count]) and not any(pairs[count:])
    return types and last >> 14 != 0b10 and 1 <= last & 0x3FFF <= 2000


def segment_legal(words):
    """Chapter 5, programming blocks 2 to 17, written out a second time."""
    if words[:2] != [0, 0x0300] or words[7] != 0 or not 1 <= words[6] <= 2000:
        return False
    lsws = all(0 <= word <= 999 for word in (words[3], words[5]))
    length, speed = 1000 * words[2] + words[3], 1000 * words[4] + words[5]
    return lsws and 1 <= length <= 8_388_607 and 1 <= speed <= 1_000_000


def spoiled(blocks):
    @st.composite
    def one(draw):
        words = list(draw(blocks).to_image())
        index = draw(st.integers(0, 7))
        flipped = st.integers(0, 15).map(lambda bit: words[index] & 0xFFFF ^ 1 << bit)
        words[index] = draw(st.one_of(flipped, st.sampled_from([-1, 0, 1, 2, 16, 17, 999, 1000, 2001]), WORD))
        return list(Image(words))

    return one()


@given(HEADERS | SEGMENTS)
@often
def test_meaning_to_words_to_meaning(block):
    image = block.to_image()
    assert type(block).from_image(image) == block
    assert (header_legal if isinstance(block, BlendHeader) else segment_legal)(list(image))


@pytest.mark.slow
@given(spoiled(HEADERS) | st.lists(WORD, min_size=8, max_size=8))
@very_often
def test_header_words_to_meaning_to_words(words):
    judge(BlendHeader, words, header_legal(words))


@pytest.mark.slow
@given(spoiled(SEGMENTS) | st.lists(WORD, min_size=8, max_size=8))
@very_often
def test_segment_words_to_meaning_to_words(words):
    judge(BlendSegment, words, segment_legal(words))


def judge(block, words, legal):
    if legal:
        assert list(block.from_image(Image(words)).to_image()) == words
    else:
        with pytest.raises(ValueError, match=r"words|out of range|acceleration type"):
            block.from_image(Image(words))
