"""Files with more tags than are allowed: elements of arrays that are zero are not counted, nor read."""

import pytest
from l5x_files import after, document, ladder, program, tag
from scanrack.rockwell.l5x.xml import parsing as reading

MANY = 300
WHOLE, REALS = ("0", "2#0", "16#0000_0000", "8#000_000"), ("0.0", "0.00000000e+000", "0")


def large(kind, values, zeros):
    """Return a document with an array: values, and behind them zeros in several ways of writing."""
    texts = [*values, *(zeros[place % len(zeros)] for place in range(MANY))]
    elements = (f'<Element Index="[{place}]" Value="{each}"/>' for place, each in enumerate(texts))
    data = f'<Array DataType="{kind}" Dimensions="{len(texts)}">\n' + "\n".join(elements) + "\n</Array>"
    rungs = ladder("Main", "ADD(Count[1],Count[299],Count[0]);")
    return document(tags=[tag("Count", kind, str(len(texts)), data)], programs=[program("Main", rungs)])


@pytest.mark.parametrize(
    ("kind", "values", "zeros"), [("DINT", ("7", "16#0000_0010"), WHOLE), ("REAL", ("7.5", "16.0"), REALS)]
)
def test_zeros_are_left_out_and_the_other_values_stay(imported, monkeypatch, kind, values, zeros):
    text = large(kind, values, zeros)
    plain = imported(text)
    monkeypatch.setattr(reading, "MOST_MARKS", 2 * MANY)
    found = imported(text)
    assert found.report.rungs == found.report.ran == 1
    assert list(after(found).Count) == list(after(plain).Count) == [16, 16, *[0] * MANY]
    lines = [each.document.programs[0].routines[0].line for each in (found, plain)]
    assert lines[0] == lines[1] > MANY


def test_other_elements_count(imported, monkeypatch):
    monkeypatch.setattr(reading, "MOST_MARKS", 2 * MANY)
    with pytest.raises(reading.L5xError, match="tags, attributes and texts"):
        imported(large("DINT", ["1"] * MANY, WHOLE))
