"""The words of a Python program by kind, in the units in which a browser counts.

Broken on purpose: letters in place of UTF-16 units, the lines between of a long string: a test turns red.
"""

import pytest
from scanrack.watch.history.python_source import spans_of

LINES = [
    "def go(scan):  # 🚀",
    '    "🚀 up"; x = 0x10',
    '    text = """a',
    "  b",
    'c"""',
    "    return None",
]


def words(lines, spans):
    """Return each span's kind and text, as a browser would cut it."""
    return {
        number: [
            (kind, lines[number - 1].encode("utf-16-le")[2 * begin : 2 * end].decode("utf-16-le"))
            for begin, end, kind in each
        ]
        for number, each in spans.items()
    }


def test_words_have_their_kinds():
    assert words(LINES, spans_of(LINES)) == {
        1: [("keyword", "def"), ("defined", "go"), ("comment", "# 🚀")],
        2: [("string", '"🚀 up"'), ("number", "0x10")],
        3: [("string", '"""a')],
        4: [("string", "  b")],
        5: [("string", 'c"""')],
        6: [("keyword", "return"), ("keyword", "None")],
    }


@pytest.mark.parametrize("rest", ['"""open', "(", "  1", "\x00", "$"])
def test_a_text_that_cannot_be_read_is_colored_up_to_there(rest):
    spans = spans_of(["pass", "if 1:", "    2", " 3", rest])
    assert spans[1] == [(0, 4, "keyword")]


def test_an_empty_text_has_no_spans():
    assert spans_of([]) == {}
