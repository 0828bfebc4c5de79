"""What a monitor keeps of a program: enough for any scan, and not more and more."""

import pytest
from scanrack.runtime.live.ring import row_type
from scanrack.watch.history.lanes import ValueHistory
from scanrack.watch.history.program_replica import MOST_INPUTS, MOST_VALUES, THINNED, SnapshotStore
from scanrack.watch.history.recent import RecentRows
from scanrack.watch.history.stretch import Stretches
from scanrack.watch.history.timeline import Timeline
from scanrack.watch.history.watched_program import Inputs, Values


def test_values_of_long_ago_are_fewer_and_those_of_late_are_all_there():
    kept = SnapshotStore()
    scans = range(0, 256 * (MOST_VALUES + 1), 256)
    for scan in scans:
        kept.take(Values(scan, {"a": scan}, 0))
    old = [scan for scan in kept.scans if scan < 256 * (MOST_VALUES // 2)]
    assert old == list(range(0, 256 * (MOST_VALUES // 2), THINNED))
    assert kept.scans[-1] == scans[-1]
    place = kept.place(scans[-1])
    assert place is not None
    assert kept.values(place) == {"a": scans[-1]}


@pytest.mark.slow
def test_notes_of_inputs_are_bounded():
    kept = SnapshotStore()
    for scan in range(2 * MOST_INPUTS + 1):
        kept.take(Inputs(scan, (), {("Run", 0): (None, scan)}, None, 0))
    assert len(kept.inputs) == MOST_INPUTS + 1
    assert kept.forces(2 * MOST_INPUTS + 1) == {("Run", 0): (None, 2 * MOST_INPUTS)}


def test_each_program_of_a_session_has_values_of_its_own():
    programs = Stretches({}, Timeline(RecentRows(row_type(0, 0)), None), ValueHistory(2_000_000))
    programs.kept(1).take(Values(256, {"a": 1}, 1))  # its notes may come before the edited program
    begins, edited = programs.add(0, None, None), programs.add(200, None, None)
    assert (begins.kept.scans, edited.kept.scans) == ([], [256])
    assert [programs.at(scan).number for scan in (0, 199, 200, 10**6, None)] == [0, 0, 1, 1, 1]
