"""What a monitor keeps of a program: enough for any scan, and not more and more."""

from scanrack.runtime.app.watched_program import Inputs, Values
from scanrack.runtime.cli.watch.shadow import MOST_INPUTS, MOST_VALUES, THINNED, Kept


def test_values_of_long_ago_are_fewer_and_those_of_late_are_all_there():
    kept = Kept()
    scans = range(0, 256 * (MOST_VALUES + 1), 256)
    for scan in scans:
        kept.take(Values(scan, {"a": scan}, 0))
    old = [scan for scan in kept.scans if scan < 256 * (MOST_VALUES // 2)]
    assert old == list(range(0, 256 * (MOST_VALUES // 2), THINNED))
    assert kept.scans[-1] == scans[-1]
    place = kept.place(scans[-1])
    assert place is not None
    assert kept.values(place) == {"a": scans[-1]}


def test_notes_of_inputs_are_bounded():
    kept = Kept()
    for scan in range(2 * MOST_INPUTS + 1):
        kept.take(Inputs(scan, (), {("Run", 0): (None, scan)}, None))
    assert len(kept.inputs) == MOST_INPUTS + 1
    assert kept.forces(2 * MOST_INPUTS + 1) == {("Run", 0): (None, 2 * MOST_INPUTS)}


def test_values_of_another_program_are_not_kept():
    kept = Kept()
    kept.take(Values(0, {"a": 1}, 1))
    assert kept.scans == []
    kept.clear(1)
    kept.take(Values(256, {"a": 1}, 1))
    assert kept.scans == [256]
