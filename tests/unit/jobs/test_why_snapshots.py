"""Snapshots in a recording: a question that begins at one has the answer of one that runs all scans."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest
import zstandard
from scanrack import open_bench
from scanrack.jobs.bench import of_trace
from scanrack.jobs.bench.moment import Question, ScanChoice
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program
from scanrack.ladder.state.snapshots import SavedValues, snapshot
from scanrack.traces import Attachment, ScanRecorder, SlotInfo, open_trace
from scanrack.traces.format.snapshots import SNAPSHOTS, SNAPSHOTS_BYTES
from scanrack.traces.read.snapshots import snapshots_of
from scanrack.traces.write.snapshots import EVERY, WORTH_SCANS, SnapshotLog

FEEDER = Path(__file__).parents[3] / "examples" / "feeder" / "feeder.toml"
PROGRAM = "PROGRAM p\nTAG Go : BOOL\nTAG Sums : DINT[2]\nROUTINE main\nXIC(Go)ADD(Sums[0],1,Sums[1]);\nEND\n"
SCANS = WORTH_SCANS + 300
TAGS = ("Feeding", "Strokes.ACC", "Trouble")


def recorded(path: Path) -> Path:
    """Record the feeder, until after its emergency stop."""
    with open_bench(FEEDER, record=path) as bench:
        bench.scan(SCANS)
    return path


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("run") / "run.mcap")


def answers(run: Path, folder: Path, tags: tuple[str, ...] = TAGS, at: str | None = None) -> list[str]:
    """Return the answers about some tags."""
    with open_trace(run) as trace:
        moment = ScanChoice(at=at)
        return [of_trace.why_of_trace(trace, folder, Question(tag, moment), trust=True).text for tag in tags]


def without_snapshots(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(of_trace, "snapshots_of", lambda _trace: {})


@pytest.fixture
def begun(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The scans from which questions began; empty if all were run from the first one on."""
    found: list[int] = []
    go_to = Debugger.go_to

    def noted(self: Debugger, past: object, scan: int) -> None:
        found.append(scan)
        go_to(self, past, scan)  # type: ignore[arg-type]

    monkeypatch.setattr(Debugger, "go_to", noted)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("at", [None, str(WORTH_SCANS)], ids=["end", "on a snapshot"])
def test_an_answer_is_the_same_from_a_snapshot(
    run: Path, tmp_path: Path, begun: list[int], monkeypatch: pytest.MonkeyPatch, at: str | None
) -> None:
    found = answers(run, tmp_path, at=at)
    row = SCANS - 1 if at is None else int(at)
    assert begun == [row - row % EVERY] * len(TAGS)
    without_snapshots(monkeypatch)
    assert found == answers(run, tmp_path, at=at)
    assert len(begun) == len(TAGS)


def test_equal_runs_have_equal_snapshots(run: Path, tmp_path: Path) -> None:
    assert recorded(tmp_path / "again.mcap").read_bytes() == run.read_bytes()
    with open_trace(run) as trace:
        assert list(snapshots_of(trace)) == list(range(EVERY, SCANS + 1, EVERY))


@pytest.mark.slow
def test_a_recording_without_its_end_is_asked_without_snapshots(
    run: Path, tmp_path: Path, begun: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    cut = tmp_path / "cut.mcap"
    with open_trace(run) as trace:
        second = [section for section in trace.sections if section.is_chunk][1]
    cut.write_bytes(run.read_bytes()[: second.span.offset])
    with open_trace(cut) as trace:
        whole = bool(snapshots_of(trace))
    found = answers(cut, tmp_path, ("Feeding",))
    assert bool(begun) == whole
    without_snapshots(monkeypatch)
    assert found == answers(cut, tmp_path, ("Feeding",))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[1,2",
        "[[",
        "{}",
        "[]",
        "[true,7]",
        "[true,[1,2,3],1]",
        "[true,[1,1e400],1]",
        "[true,7,[1]]",
    ],
    ids=["nothing", "half", "deep", "object", "empty", "short", "longer", "infinite", "list"],
)
def test_what_is_no_snapshot_of_the_program_is_refused(text: str) -> None:
    memory = parse_program(PROGRAM).compile().memory
    saved = SavedValues(memory)
    assert saved.values_in([saved.text()]) == [snapshot(memory)]
    with pytest.raises(ValueError, match=r"snapshot|Expecting|nested"):
        saved.values_in([text])


def changed(lines: Mapping[int, str]) -> dict[int, str]:
    """Return snapshots with other values: each has those of the next one's time."""
    return {scan - 5 * EVERY: line for scan, line in lines.items() if scan > 5 * EVERY}


@pytest.mark.slow
def test_a_snapshot_that_leads_elsewhere_is_not_used(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with open_trace(run) as trace:
        forged = changed(snapshots_of(trace))
    monkeypatch.setattr(of_trace, "snapshots_of", lambda _trace: forged)
    found = answers(run, tmp_path, ("Feeding",), at="300")
    without_snapshots(monkeypatch)
    assert found == answers(run, tmp_path, ("Feeding",), at="300")


@pytest.mark.parametrize(
    "data",
    [
        b"no zstd",
        zstandard.compress(b"x [1]"),
        zstandard.compress(b"-1 [1]"),
        zstandard.compress("1 [é]".encode()),
        zstandard.compress(bytes(SNAPSHOTS_BYTES + (2 << 20))),
    ],
    ids=["no zstd", "no number", "negative", "no ascii", "too large"],
)
def test_a_forged_attachment_has_no_snapshots(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "forged.mcap"
    slots = [SlotInfo(1, "amci3601", "4.1")]
    files = [Attachment(SNAPSHOTS, data)]
    ScanRecorder(path, bytearray(32), slots, scan_period_ns=2_000_000, attachments=files).close()
    with open_trace(path) as trace:
        assert snapshots_of(trace) == {}


def test_large_values_have_fewer_snapshots() -> None:
    log = SnapshotLog(lambda: "1" * 5_000)
    for scan in range(20_000):
        if not (scan + 1) % log.every:
            log.scan(scan)
    packed = log.packed()
    assert packed is not None
    lines = zstandard.decompress(packed).decode().splitlines()
    assert [int(line.partition(" ")[0]) for line in lines] == list(
        range(512, 20_001, 512)
    )  # 5,000 / 16 = 313


def test_a_program_that_can_t_be_saved_any_more_has_no_snapshots() -> None:
    texts = iter(["[1]"] * 100)
    log = SnapshotLog(lambda: next(texts, None))
    for number in range(1, 102):
        log.scan(number * EVERY - 1)
    assert log.packed() is None
