"""Chapter 5, Blend Move Programming: the layout of the blocks."""

import pytest
from scanrack.io_images.amci3601 import Acceleration, BlendHeader, BlendSegment
from scanrack.io_images.image import Image

C, T, Z = Acceleration.CONSTANT, Acceleration.TRIANGULAR, Acceleration.TRAPEZOIDAL

# Segment, word that holds its type (LSW is word 4, MSW word 3), its lower bit; two rows of each table half.
PAIRS = [(1, 4, 0), (2, 4, 2), (8, 4, 14), (9, 3, 0), (15, 3, 12), (16, 3, 14)]


@pytest.mark.parametrize(
    ("segment", "word", "bit"),
    [pytest.param(*row, id=f"chapter 5 Acceleration Type: segment {row[0]}") for row in PAIRS],
)
@pytest.mark.parametrize(("kind", "pair"), [(C, 0b00), (T, 0b01), (Z, 0b11)])
def test_acceleration_type_pairs(segment, word, bit, kind, pair):
    types = tuple(kind if number == segment else C for number in range(1, 17))
    image = BlendHeader(types, 1).to_image()
    assert image[word] & 0xFFFF == pair << bit
    assert image[7 - word] == 0  # the other one of words 3 and 4
    assert BlendHeader.from_image(image).types == types


@pytest.mark.parametrize(
    ("kind", "bits"),
    [
        pytest.param(C, 0b00, id="chapter 5 Final Segment: 00"),
        pytest.param(T, 0b01, id="chapter 5 Final Segment: 01"),
        pytest.param(Z, 0b11, id="chapter 5 Final Segment: 11"),
    ],
)
def test_final_deceleration_word(kind, bits):
    image = BlendHeader((C, C), 2000, kind).to_image()
    assert image[5] & 0xFFFF == bits << 14 | 2000


def test_final_type_10_is_invalid():
    image = Image([0, 0x0300, 2, 0, 0, 0b10 << 14 | 20, 0, 0])
    with pytest.raises(ValueError, match="10b"):
        BlendHeader.from_image(image)


def test_first_block():
    """Words 0 to 7: command MSW and LSW (bits 8 and 9), segments, types, final deceleration, 0, 0."""
    assert list(BlendHeader((Z, C, T), 10).to_image()) == [0, 0x0300, 3, 0, 0b01_00_11, 10, 0, 0]


def test_segment_block():
    """Words 2 to 7: length MSW and LSW, speed MSW and LSW, rate, 0."""
    assert list(BlendSegment(12_345, 6_789, 20).to_image()) == [0, 0x0300, 12, 345, 6, 789, 20, 0]


@pytest.mark.parametrize(
    ("block", "least", "greatest"),
    [
        pytest.param(lambda v: BlendHeader((C,) * v, 1), 2, 16, id="chapter 5 Number of Segments"),
        pytest.param(lambda v: BlendHeader((C, C), v), 1, 2000, id="chapter 5 Final Segment Deceleration"),
        pytest.param(lambda v: BlendSegment(v, 1, 1), 1, 8_388_607, id="chapter 5 Segment Length"),
        pytest.param(lambda v: BlendSegment(1, v, 1), 1, 1_000_000, id="chapter 5 note 6"),
        pytest.param(lambda v: BlendSegment(1, 1, v), 1, 2000, id="chapter 5 note 8"),
    ],
)
def test_ranges(block, least, greatest):
    for value in (least, greatest):
        assert type(block(value)).from_image(block(value).to_image()) == block(value)
    for value in (least - 1, greatest + 1):
        with pytest.raises(ValueError, match=f" {value} is out of range: must be {least} to {greatest}"):
            block(value)
