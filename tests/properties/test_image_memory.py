"""The image: words, bits and bytes are three views of the same memory."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scanrack.io_images.image import IMAGE_BYTES, WORDS, Image, signed_word

SIGNED = st.integers(-32_768, 32_767)
EIGHT = st.lists(SIGNED, min_size=WORDS, max_size=WORDS)
often = settings(max_examples=5 * settings().max_examples)


@given(st.integers(-32_768, 65_535))
@often
def test_signed_word_keeps_the_bits(value):
    word = signed_word(value)
    assert -32_768 <= word <= 32_767
    assert word & 0xFFFF == value & 0xFFFF


@given(st.integers(65_536) | st.integers(max_value=-32_769))
@often
def test_values_beyond_a_word_are_refused(value):
    with pytest.raises(ValueError, match="out of range"):
        signed_word(value)
    with pytest.raises(ValueError, match="out of range"):
        Image([value])
    with pytest.raises(ValueError, match="out of range"):
        Image()[0] = value


@given(EIGHT)
@often
def test_words_and_bytes(words):
    image = Image(words)
    assert list(image) == words
    assert bytes(image) == b"".join(word.to_bytes(2, "little", signed=True) for word in words)
    assert Image(buffer=bytearray(bytes(image))) == image
    assert Image(word & 0xFFFF for word in words) == image


@given(EIGHT, st.integers(0, 7), st.integers(0, 15), st.booleans())
@often
def test_set_bit_touches_one_bit(words, word, bit, on):
    image = Image(words)
    image.set_bit(word, bit, on)
    assert image.bit(word, bit) is on
    before, after = words[word] & 0xFFFF, image[word] & 0xFFFF
    assert before & ~(1 << bit) == after & ~(1 << bit)
    assert [each for index, each in enumerate(image) if index != word] == words[:word] + words[word + 1 :]


@given(EIGHT)
@often
def test_views_are_live(words):
    memory = bytearray(3 * IMAGE_BYTES)
    middle = memoryview(memory)[IMAGE_BYTES : 2 * IMAGE_BYTES]
    image, twin = Image(buffer=middle), Image(buffer=middle)
    image.load(Image(words))
    assert list(twin) == words
    copy = twin.copy()
    twin.clear()
    assert list(image) == [0] * WORDS
    assert list(copy) == words
    assert memory == bytes(3 * IMAGE_BYTES)


@pytest.mark.parametrize(("word", "bit"), [(-1, 0), (8, 0), (0, -1), (0, 16)])
def test_addresses_outside_the_image_are_refused(word, bit):
    for access in (lambda: Image().bit(word, bit), lambda: Image().set_bit(word, bit, True)):
        with pytest.raises(ValueError, match=f"word {word}, bit {bit}"):
            access()


def test_wrong_sizes_are_refused():
    with pytest.raises(ValueError, match="has 8 words, got 9"):
        Image([0] * 9)
    with pytest.raises(ValueError, match="needs 16 writable bytes, got 15"):
        Image(buffer=bytearray(15))
    with pytest.raises(ValueError, match="needs 16 writable bytes"):
        Image(buffer=memoryview(bytes(16)))


def test_images_compare_by_words_and_do_not_hash():
    assert Image([1]) == Image([1, 0])
    assert Image([1]) != Image([2])
    assert Image() != [0] * WORDS
    with pytest.raises(TypeError):
        hash(Image())
