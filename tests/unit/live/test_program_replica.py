"""What a monitor keeps of a program: enough for any scan, and not more and more."""

import tracemalloc
from errno import ENOSPC

import pytest
from scanrack.runtime.live.ring import row_type
from scanrack.watch.history.lanes import ValueHistory
from scanrack.watch.history.program_replica import MOST_INPUTS, SnapshotStore
from scanrack.watch.history.recent import RecentRows
from scanrack.watch.history.stretch import Stretches
from scanrack.watch.history.timeline import Timeline
from scanrack.watch.history.watched_program import Inputs, Values


def stored(count):
    """Return the notes of a session at full speed, and the memory that they take."""
    tracemalloc.start()
    kept = SnapshotStore()
    for scan in range(0, 1024 * count, 1024):
        kept.take(Values(scan, {"a": [*range(scan, scan + 300)]}, 0))
        kept.take(
            Inputs(scan, (), {}, None, 0)
        )  # every value is followed by the forces, whether they changed
    taken = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    return kept, taken


def test_a_session_of_any_length_has_all_its_values_and_takes_no_more_memory():
    stored(10)  # loads what it needs
    (_, short), (kept, long) = stored(100), stored(400)
    assert long - short < 300 * 2 * 8 * 1.5  # the scan and the place of each value, and some room to grow
    for scan in (0, 1024 * 200 + 1023, 1024 * 399):
        place = kept.index_for(scan)
        assert place is not None
        assert kept.values(place)["a"][0] == scan // 1024 * 1024
    assert list(kept.inputs) == [0]


def test_forces_are_kept_from_where_they_change():
    kept = SnapshotStore()
    held = {("Run", 0): (None, True)}
    for scan, forces in ((0, {}), (5, held), (8, held), (9, {}), (12, {})):
        kept.take(Inputs(scan, (), forces, None, 0))
    assert list(kept.inputs) == [0, 5, 9]
    assert [kept.forces(scan) for scan in (5, 6, 9, 10)] == [{}, held, held, {}]


def test_values_that_the_disk_has_no_room_for_are_left_out(monkeypatch):
    kept = SnapshotStore()
    kept.take(Values(0, {"a": 1}, 0))
    file = kept._file._file
    assert file is not None

    class Full:
        seek, read = file.seek, file.read  # type: ignore[union-attr]

        def write(self, data):
            raise OSError(ENOSPC, "no space left on device")

    monkeypatch.setattr(kept._file, "_file", Full())
    kept.take(Values(512, {"a": 2}, 0))
    assert list(kept.scans) == [0]
    assert kept.values(0) == {"a": 1}


@pytest.mark.slow
def test_notes_of_inputs_are_bounded():
    kept = SnapshotStore()
    for scan in range(2 * MOST_INPUTS + 1):
        kept.take(Inputs(scan, (), {("Run", 0): (None, scan)}, None, 0))
    assert len(kept.inputs) == MOST_INPUTS + 1
    assert kept.forces(2 * MOST_INPUTS + 1) == {("Run", 0): (None, 2 * MOST_INPUTS)}


def test_each_program_of_a_session_has_values_of_its_own():
    programs = Stretches({}, Timeline(RecentRows(row_type(0, 0)), None), ValueHistory(2_000_000))
    programs.store(1).take(Values(256, {"a": 1}, 1))  # its notes may come before the edited program
    begins, edited = programs.add(0, None, None), programs.add(200, None, None)
    assert (list(begins.store.scans), list(edited.store.scans)) == ([], [256])
    assert [programs.at(scan).number for scan in (0, 199, 200, 10**6, None)] == [0, 0, 1, 1, 1]
