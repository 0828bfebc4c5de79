"""An adapter that is advanced once or in pieces shows the same images."""

from __future__ import annotations

from adapterbench import MS, AdapterBench, move
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st

DISTANCE = 2000
"""At 5,000 steps/s and 100 steps/ms/s: 1000 to 5,000 in 40 ms; 0.448 s in all."""


@settings(max_examples=amount(4), deadline=None)
@given(st.lists(st.integers(1, 40), min_size=1, max_size=12))
def test_advancing_once_or_in_pieces_gives_the_same_images(pieces):
    whole, parts = AdapterBench().configured(), AdapterBench().configured()
    for bench in (whole, parts):
        bench.put(*move(DISTANCE, 5000, 100, 100))
    for piece in pieces:
        parts.now_ns += piece * MS // 4
        parts.image = parts.module.update(parts.now_ns, parts.outputs)
    whole.image = whole.module.update(parts.now_ns, whole.outputs)
    assert list(whole.image) == list(parts.image)
