"""Of a past scan the levels of inputs are those of its own status, and the shaft is not known.

The machine was looked at some scans before it.
"""

import numpy as np
import pytest
from scanrack.io_images.amci3601 import WORDS_3601, StatusLsw
from scanrack.runtime.live.ring import row_type
from scanrack.traces.read.number_formats import NumberFormats
from scanrack.watch.history.watched_machines import PER_SLOT
from scanrack.watch.monitors.picture import RowLayout

STATUS = 8  # word of the rack's memory: eight outputs come first


@pytest.mark.parametrize(("past", "level"), [(True, True), (False, False)])
def test_levels_of_inputs(past, level):
    rows = np.zeros(1, row_type(32, PER_SLOT))
    rows["wall_ns"] = 1  # of the ring
    rows["words"][0, STATUS + 1] = StatusLsw.IN_ESTOP.value
    shown = RowLayout({1: WORDS_3601}, (1,)).picture_of(rows[0], rows[:0], NumberFormats(), past=past)
    assert shown["machine"]["1"]["inputs"]["estop"] is level


@pytest.mark.parametrize(("past", "shaft"), [(True, None), (False, 700)])
@pytest.mark.parametrize("wall_ns", [1, 0], ids=["ring", "trace"])
def test_the_shaft_of_a_past_scan_is_not_known(past, shaft, wall_ns):
    rows = np.zeros(1, row_type(32, PER_SLOT))
    rows["wall_ns"] = wall_ns
    rows["figures"][0, 0] = 700
    shown = RowLayout({1: WORDS_3601}, (1,)).picture_of(rows[0], rows[:0], NumberFormats(), past=past)[
        "machine"
    ]["1"]
    assert shown["position"] == 0
    assert shown["shaft"] == (shaft if wall_ns else None)


def test_the_mirror_of_a_configuration_has_no_levels():
    rows = np.zeros(1, row_type(32, PER_SLOT))
    rows["words"][0, STATUS : STATUS + 2] = -0x8000, 0x7FFF
    shown = RowLayout({1: WORDS_3601}, (1,)).picture_of(rows[0], rows[:0], NumberFormats(), past=True)
    assert set(shown["machine"]["1"]["inputs"].values()) == {None}
