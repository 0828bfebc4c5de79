"""The image: words, bits and bytes are three views of the same memory."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scanrack.io_images.image import WORDS, Image, signed_word

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
    memory = bytearray(3 * 2 * WORDS)
    middle = memoryview(memory)[2 * WORDS : 4 * WORDS]
    image, twin = Image(buffer=middle), Image(buffer=middle)
    image.load(Image(words))
    assert list(twin) == words
    copy = twin.copy()
    twin.clear()
    assert list(image) == [0] * WORDS
    assert list(copy) == words
    assert memory == bytes(3 * 2 * WORDS)


@pytest.mark.parametrize(("word", "bit"), [(-1, 0), (8, 0), (0, -1), (0, 16)])
def test_addresses_outside_the_image_are_refused(word, bit):
    for access in (lambda: Image().bit(word, bit), lambda: Image().set_bit(word, bit, True)):
        with pytest.raises(ValueError, match=f"word {word}, bit {bit}"):
            access()


def test_wrong_sizes_are_refused():
    with pytest.raises(ValueError, match="has 8 words, got 9"):
        Image([0] * 9)
    with pytest.raises(ValueError, match="needs 2 to 500 writable bytes, two a word: got 15"):
        Image(buffer=bytearray(15))
    with pytest.raises(ValueError, match="got 16, read-only"):
        Image(buffer=memoryview(bytes(16)))


@pytest.mark.parametrize("size", [1, 2, 31, 250])
def test_an_image_has_as_many_words_as_its_size_or_its_buffer_says(size):
    image = Image(range(size), size=size)
    assert (len(image), list(image), len(bytes(image))) == (size, list(range(size)), 2 * size)
    view = Image(buffer=bytearray(bytes(image)))
    view.set_bit(size - 1, 15, True)
    assert view[-1] == signed_word(size - 1 | 0x8000)
    assert view.bit(size - 1, 15)
    twin = view.copy()
    view.clear()
    assert list(view) == [0] * size
    view.load(twin)
    assert view == twin
    for access in (lambda: image[size], lambda: image.bit(size, 0), lambda: image.set_bit(size, 0, True)):
        with pytest.raises(ValueError, match=f"words are 0 to {size - 1}"):
            access()


@pytest.mark.parametrize("size", [0, 251, True, 1.0])
def test_an_image_of_another_size_is_refused(size):
    with pytest.raises(ValueError, match="words is not allowed: 1 to 250"):
        Image(size=size)


def test_an_image_of_another_size_is_not_loaded():
    with pytest.raises(ValueError, match="an image of 2 words does not fit into one of 8"):
        Image().load(Image(size=2))


def test_images_compare_by_words_and_do_not_hash():
    assert Image([1]) == Image([1, 0])
    assert Image([1]) != Image([2])
    assert Image() != [0] * WORDS
    with pytest.raises(TypeError):
        hash(Image())
