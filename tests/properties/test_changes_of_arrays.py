"""Changes found in arrays of scans are those found scan by scan."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_traces import A3601, record
from scanrack.traces import SlotInfo, open_trace
from scanrack.traces.format.flags import flag_names
from scanrack.traces.read.changes import ChangeRows, Row
from scanrack.traces.signals import ALL

SLOTS = (A3601, SlotInfo(2, "a toy"), SlotInfo(3, "amci3601", "4.1"))
COLUMNS = 16 * len(SLOTS)

changing = st.tuples(
    st.sampled_from([0, 8, 9, 10, 11, 12, 13, 14, 16, 24, 40, 42, 43, 45]),  # words of outputs and inputs
    st.sampled_from([0, 1, 2, -32768, 0x4000]),
)
scripts = st.lists(st.lists(changing, max_size=3), min_size=1, max_size=60)


@given(scripts, st.booleans(), st.integers(0, 20), st.integers(20, 70), st.sampled_from([1, 7, 50]))
def test_rows_of_arrays(
    script: list[list[tuple[int, int]]], every: bool, first: int, last: int, chunk: int
) -> None:
    words = np.zeros((len(script), COLUMNS), np.int16)
    for scan, changes in enumerate(script):
        words[scan:, [column for column, _ in changes]] = [value for _, value in changes]
    with (
        TemporaryDirectory() as folder,
        open_trace(record(Path(folder) / "run.mcap", words, SLOTS, chunk_scans=chunk)) as trace,
    ):
        one_by_one, by_arrays = (ChangeRows(SLOTS, flag_names, every=every) for _ in range(2))
        expected: list[Row] = []
        for each in trace.scans():
            if first <= each.scan <= last:
                expected += one_by_one.rows(each)
            else:
                one_by_one.skip(each)
        found: list[Row] = []
        for section in trace.sections:
            for rows in trace.scan_rows(section):
                inside = (rows["scan"] >= first) & (rows["scan"] <= last)
                found += by_arrays.rows_of(rows, inside, trace.as_scans)
        assert [*found, *by_arrays.rest()] == [*expected, *one_by_one.rest()]


def test_a_limit_stops_at_the_end_of_the_chunk_in_which_it_is_reached(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from scanrack.commands.recordings.show import Contents
    from scanrack.traces import Trace

    words = np.zeros((1000, 16), np.int16)
    words[::2, 0] = 1
    path = record(tmp_path / "run.mcap", words, chunk_scans=100, events={5: ("/events", {"kind": "rule"})})
    read = []
    whole = Trace.entries

    def counted(trace, section):
        read.append(section)
        return whole(trace, section)

    monkeypatch.setattr(Trace, "entries", counted)
    with open_trace(path) as trace:
        contents = Contents(trace, every=False, limit=1, selected=ALL)
    assert len(read) == 1
    assert len(contents.rows.kept) == len(contents.events.kept) == 1
    assert contents.rows.stopped
    assert (contents.count, contents.first, contents.last) == (1000, 0, 999)
