"""The rows of a monitor: of several rows of one scan the last one stays."""

import numpy as np
import pytest
from scanrack.watch.history.recent import RecentRows

ROW = np.dtype([("scan", np.int64), ("wall_ns", np.int64)])


@pytest.mark.parametrize("batches", [[[0, 1, 2, 2]], [[0, 1, 2], [2]], [[0], [1, 1], [1, 2, 2], [2]]])
def test_a_scan_that_is_told_again_is_one_row(batches):
    recent, wall_ns = RecentRows(ROW), 0
    for batch in batches:
        rows = np.zeros(len(batch), ROW)
        rows["scan"] = batch
        rows["wall_ns"] = range(wall_ns, wall_ns := wall_ns + len(batch))
        recent.add(rows)
    assert recent.rows["scan"].tolist() == [0, 1, 2]
    assert recent.rows["wall_ns"][-1] == wall_ns - 1
    assert len(recent.between(2, 2)) == 1
