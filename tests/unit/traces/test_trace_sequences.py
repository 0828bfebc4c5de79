"""Where sequences wait, in a trace: a message on change only, two signals each, a band of the chart."""

import csv
from pathlib import Path

import pytest
from scanrack.traces import ScanRecorder, SlotInfo, open_trace
from scanrack.traces.export import write_csv, write_mcap
from scanrack.traces.plot.chart import read_chart
from scanrack.traces.plot.envelope import Envelope
from scanrack.traces.query import query
from scanrack.traces.read.sequence_steps import sequence_steps
from scanrack.traces.signals import Catalog, Selection, SignalKind
from scanrack.traces.signals.catalog import UnknownSignalError

SCANS = 100
STEPS = [  # scan, sequence, line, wait
    (0, "cycle", 14, "start rises"),
    (10, "cycle", 15, "axis.move_to(4000)"),
    (20, "part", 30, "dwell 2 s"),
    (40, "cycle", 14, "start rises"),
    (90, "part", 0, ""),
]


@pytest.fixture
def trace(tmp_path: Path) -> Path:
    """Return a trace with two sequences."""
    path = tmp_path / "made.mcap"
    recorder = ScanRecorder(
        path, bytearray(32), [SlotInfo(1, "amci3601")], scan_period_ns=2_000_000, sequences=True
    )
    for scan in range(SCANS):
        for at, name, line, wait in STEPS:
            if at == scan:
                fields = {"sequence": name, "file": "line.py" if line else "", "line": line, "wait": wait}
                recorder.event(scan, scan * 2_000_000, "/sequences", fields)
        recorder.scan(scan, scan * 2_000_000, 1)
    recorder.close()
    return path


def test_steps_are_those_that_were_written(trace: Path) -> None:
    with open_trace(trace) as opened:
        found = sequence_steps(opened)
    for name, steps in found.items():
        read = [(step.scan, step.sequence, step.line, step.wait) for step in steps]
        assert read == [each for each in STEPS if each[1] == name]
    assert str(found["cycle"][1]) == (
        "cycle waits at line 15 of line.py for axis.move_to(4000) since 0.02 s"  # scan 10, 2 ms each
    )
    assert str(found["part"][-1]) == "part is over since 0.18 s"


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("cycle.line == 15", 1),  # scans 10 to 39
        ("sequences.cycle.line == 14", 2),  # scans 0 to 9, and from 40 on
        ("part.line == 0", 2),  # before scan 20, and from 90 on
        ("rose(cycle.line == 15)", 1),
        ("changed(cycle)", 2),
        ("changed(part)", 2),
    ],
)
def test_queries(trace: Path, text: str, count: int) -> None:
    with open_trace(trace) as opened:
        assert query(opened, f"count({text})").count == count


def test_codes_have_lines_and_waits_as_names(trace: Path) -> None:
    with open_trace(trace) as opened:
        catalog = Catalog.of(opened)
    assert [signal.name for signal in catalog.tags] == ["sequences.cycle", "sequences.part"]
    assert catalog["cycle"].kind is SignalKind.CODE
    assert list(catalog["part"].names.values()) == ["not begun", "line 30: dwell 2 s", "over"]


def test_csv_says_where_they_wait(trace: Path, tmp_path: Path) -> None:
    with open_trace(trace) as opened:
        write_csv(opened, tmp_path / "made.csv", ["sequences.*"])
    with (tmp_path / "made.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert rows[9]["sequences.cycle"] == "line 14: start rises"
    assert rows[10]["sequences.cycle"] == "line 15: axis.move_to(4000)"
    assert rows[10]["sequences.part"] == "not begun"
    assert rows[95]["sequences.part.line"] == "0"


def test_a_copy_with_decoded_values_has_them(trace: Path, tmp_path: Path) -> None:
    with open_trace(trace) as opened:
        write_mcap(opened, tmp_path / "copy.mcap", Selection(first=50))
    with open_trace(trace) as opened, open_trace(tmp_path / "copy.mcap") as copy:
        assert sequence_steps(copy) == sequence_steps(opened)  # also the step before, which holds in scan 50
        assert query(copy, "count(cycle.line == 14)").count == 1


def test_the_chart_has_a_band_for_each(trace: Path) -> None:
    with open_trace(trace) as opened:
        panel = read_chart(opened, Envelope).panels[-1]
    assert panel.about == "2 sequences"
    assert [(band.name, band.row.tolist()) for band in panel.bands] == [
        ("cycle", [0, 10, 40]),
        ("part", [0, 20, 90]),
    ]
    assert panel.bands[0].text(int(panel.bands[0].value[1])) == "line 15: axis.move_to(4000)"
    with open_trace(trace) as opened:
        chosen = read_chart(opened, Envelope, tags=["cycle"]).panels[-1]
    assert [band.name for band in chosen.bands] == ["cycle"]


def test_a_recorder_without_sequences_has_no_such_channel(tmp_path: Path) -> None:
    recorder = ScanRecorder(
        tmp_path / "plain.mcap", bytearray(32), [SlotInfo(1, "amci3601")], scan_period_ns=1
    )
    with pytest.raises(ValueError, match="'/sequences' is not recorded"):
        recorder.event(0, 0, "/sequences", {})
    recorder.scan(0, 0, 1)
    recorder.close()
    with open_trace(tmp_path / "plain.mcap") as opened:
        assert "/sequences" not in opened.head.channels
        assert sequence_steps(opened) == {}
        with pytest.raises(UnknownSignalError):
            Catalog.of(opened)["cycle.line"]
