"""Numbers and times of scans by row, and stretches of a condition, block by block beside all at once."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scanrack.traces.query.patterns import Stretches
from scanrack.traces.query.rows import RowIndex

BLOCKS = st.lists(st.lists(st.integers(-(2**40), 2**40), max_size=4), min_size=1, max_size=6)
EVEN = st.builds(
    lambda first, step, count: [first + step * n for n in range(count)], *[st.integers(0, 9)] * 3
)


@given(BLOCKS | st.lists(EVEN | st.lists(st.integers(0, 9), max_size=5), max_size=6), st.data())
def test_a_row_has_the_number_and_the_time_that_were_added(
    blocks: list[list[int]], data: st.DataObject
) -> None:
    index, whole = RowIndex(), [value for block in blocks for value in block]
    for block in blocks:
        index.add(np.array(block, np.int64), -np.array(block, np.int64))
    wanted = sorted(data.draw(st.lists(st.integers(0, len(whole) - 1)))) if whole else []
    rows = np.array(wanted, np.int64)
    assert index.scan(rows).tolist() == [whole[row] for row in wanted]
    assert index.time_ns(rows).tolist() == [-whole[row] for row in wanted]


@given(st.lists(st.lists(st.booleans(), max_size=4), max_size=6))
def test_stretches_are_those_of_the_whole(blocks: list[list[bool]]) -> None:
    found, begins, before = Stretches(), [], 0
    for block in blocks:
        begins += [before + row for row in found.add(np.array(block, bool)).tolist()]
        before += len(block)
    whole = [False, *(holds for block in blocks for holds in block)]
    assert begins == found.first.tolist() == [at for at in range(before) if whole[at + 1] > whole[at]]
    assert found.end.tolist() == [at for at in range(before) if whole[at + 1] < whole[at]]
