"""`scanrack export --mcap`: a copy that our reader takes like the recording; decoded values behind."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
from made_tags import MadeTags
from made_traces import A3601, cut_blocks, idle, record
from scanrack.commands import build
from scanrack.traces import Attachment, ScanRecorder, SlotInfo, Tag, TraceError, open_trace, read_columns
from scanrack.traces.compare import Tolerance, compare
from scanrack.traces.export import write_mcap
from scanrack.traces.format.cdr import leaves
from scanrack.traces.format.schema import ScanSchema, layout_of, rest_bytes, scan_schema
from scanrack.traces.format.tagplan import plan_of
from scanrack.traces.read.arrays import Selection
from scanrack.traces.repair import repair
from typer.testing import CliRunner

SCANS = 300


TAGS = [Tag("Medium", "TEXT"), Tag("Lamp", "BOOL")]


def texts(n: int) -> Mapping[str, Sequence[tuple[int, str]]]:
    """Return the text that changes in scans 0 and 100."""
    return {"Medium": [(n // 100, f"größe {n}")]} if n in (0, 100) else {}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    memory = bytearray(32)
    words = np.frombuffer(memory, np.int16)
    recorder = ScanRecorder(
        tmp_path / "a.mcap",
        memory,
        [A3601],
        scan_period_ns=2_000_000,
        chunk_scans=64,
        tags=MadeTags(memory, TAGS, lambda n: bytes([int(n >= 100), 0, n % 2]), texts),
        program=Attachment("line.py", b"print('hello')"),
        metadata={"name": "a rack"},
    )
    for n in range(SCANS):
        words[8], words[11] = 0x4001, n
        if n % 40 == 7:
            recorder.event(n, n * 2_000_000, "/events", {"slot": 1, "kind": "move", "name": "é", "text": "."})
        recorder.scan(n, n * 2_000_000, 1)
    recorder.close()
    return tmp_path / "a.mcap"


def copied(path: Path, selection: Selection | None = None) -> Path:
    with open_trace(path) as trace:
        write_mcap(trace, path.with_name("b.mcap"), selection or Selection())
    return path.with_name("b.mcap")


@pytest.mark.slow
@pytest.mark.parametrize("block", [1, 50, 1000])
def test_the_copy_holds_the_recording(path: Path, block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    cut_blocks(monkeypatch, block)
    with open_trace(path) as one, open_trace(copied(path)) as other:
        assert list(one) == list(other)  # scans, tags, events and texts, in the same order
        assert other.notes == []
        assert [each.name for each in one.attachments()] == [each.name for each in other.attachments()]
        assert {**one.head.metadata, "layout": ""} == {**other.head.metadata, "layout": ""}
        assert other.texts() == {0: "größe 0", 1: "größe 100"}
        a, b = read_columns(one, tags=True), read_columns(other, tags=True)
        assert a.tags is not None
        assert b.tags is not None
        assert (a.tags == b.tags).all()
    assert not repair(copied(path)).needed


def test_a_copy_of_a_copy_is_the_copy(path: Path) -> None:
    first = copied(path).rename(path.with_name("first.mcap"))
    assert copied(first).read_bytes() == first.read_bytes()


def test_the_copy_compares_equal(path: Path) -> None:
    with open_trace(path) as one, open_trace(copied(path)) as other:
        assert compare(one, other, Tolerance()).same


def test_a_selection_is_copied(path: Path) -> None:
    with open_trace(copied(path, Selection(first=90, end_ns=250 * 2_000_000))) as trace:
        assert [scan.scan for scan in trace.scans()] == list(range(90, 251))
        events = [event.scan for event in trace.events() if event.topic == "/events"]
        assert events == [scan for scan in range(90, 251) if scan % 40 == 7]
        assert trace.texts() == {0: "größe 0", 1: "größe 100"}


def test_an_old_trace_without_tags_is_copied(tmp_path: Path) -> None:
    path = record(tmp_path / "a.mcap", idle(100))
    with open_trace(path) as one, open_trace(copied(path)) as other:
        assert (one.head.metadata["format"], other.head.metadata["format"]) == ("1", "2")
        assert list(one) == list(other)
        assert other.head.tags is None


def test_a_rack_without_a_3601_is_refused_and_leaves_no_file(tmp_path: Path) -> None:
    path = record(tmp_path / "a.mcap", idle(3), [SlotInfo(5, "a toy")])
    with pytest.raises(ValueError, match=r"no 3601 or drive in the trace to decode \(slot 5: a toy\)"):
        copied(path)
    assert [each.name for each in tmp_path.iterdir()] == ["a.mcap"]


def test_an_empty_selection_leaves_no_file(path: Path) -> None:
    with pytest.raises(ValueError, match="no scan in scans from 900"):
        copied(path, Selection(first=900))
    assert [each.name for each in path.parent.iterdir()] == ["a.mcap"]


def test_a_copy_goes_to_a_stream(path: Path) -> None:
    stream = io.BytesIO()
    with open_trace(path) as trace:
        write_mcap(trace, stream)
    assert stream.getvalue() == copied(path).read_bytes()


def run(*words: object) -> tuple[int, str, str]:
    result = CliRunner().invoke(build(), [str(word) for word in words])
    return result.exit_code, result.stdout, result.stderr


def test_the_command_writes_a_copy(path: Path, tmp_path: Path) -> None:
    target = tmp_path / "c.mcap"
    assert run("export", path, "--mcap", target)[:2] == (
        0,
        f"{target}: 300 scans, {target.stat().st_size:,} bytes\n",
    )
    assert run("query", target, "count(rose(Lamp))")[:2] == (0, "150\n")
    assert (
        "--signal: not possible for a copy as MCAP"
        in run("export", path, "--mcap", target, "--signal", "x")[2]
    )
    assert "is the trace itself" in run("export", path, "--mcap", path)[2]


# -- fields behind the tags ----------------------------------------------------------------------------

KNOWN = scan_schema([A3601])


def extended(line: str, *messages: str) -> str:
    head, bar, rest = KNOWN.text.partition("=" * 80)
    return head + f"{line}\n" + bar + rest + "".join(f"{'=' * 80}\n{each}\n" for each in messages)


@pytest.mark.parametrize(
    ("text", "size"),
    [
        (KNOWN.text, 0),
        (extended("uint8 more"), 1),
        (extended("float64 more"), 8),  # a scan of one slot is 40 bytes, a multiple of 8
        (extended("bool[3] flags"), 3),
        (extended("New more", "MSG: scanrack/New\nuint8 A=1\nbool a\nuint32 b  # why"), 8),
        (extended("pkg/New[2] more", "MSG: pkg/New\nuint16 a\nuint8 b"), 7),  # 0, 2, 4, 6
        (KNOWN.text.replace("uint32 flags", "uint32 other"), None),
        (KNOWN.text.replace("int16 command_msw", "int16 command"), None),
    ],
)
def test_the_size_of_what_stands_behind_is_read_off_the_schema(text: str, size: int | None) -> None:
    assert rest_bytes(text.replace("MSG: pkg/", "MSG: scanrack/"), KNOWN) == size


@pytest.mark.parametrize("line", ["string name", "uint8[] many", "uint8[<=3] some", "Unknown more"])
def test_a_field_without_a_fixed_size_is_refused(line: str) -> None:
    with pytest.raises(ValueError, match="has no fixed size"):
        rest_bytes(extended(line), KNOWN)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "messages"),
    [
        ("uint8[999999999] more", ()),
        ("A[999999999] more", ("MSG: scanrack/A\nB[999999999] b", "MSG: scanrack/B\nbool on")),
    ],
)
def test_a_schema_that_asks_for_the_moon_is_refused_at_once(line: str, messages: tuple[str, ...]) -> None:
    with pytest.raises(ValueError, match="more than 100,000 values or 1,048,576 bytes"):
        rest_bytes(extended(line, *messages), KNOWN)


def test_empty_messages_take_no_room_and_no_time() -> None:
    empty = ("MSG: scanrack/A\nB[999999999] b", "MSG: scanrack/B")
    assert rest_bytes(extended("A[999999999] more", *empty), KNOWN) == 0


def test_messages_that_hold_themselves_are_refused() -> None:
    with pytest.raises(ValueError, match="nested more than 16 deep"):
        list(leaves(["A a"], {"A": ["A a"]}, 0))


def test_a_trace_with_unknown_fields_says_so(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def with_text(*given: object) -> ScanSchema:
        text = scan_schema([A3601], plan_of(TAGS)).text
        text = text.replace("\n=", "\nstring note\n=", 1)
        return ScanSchema(layout_of(text), text)

    monkeypatch.setattr("scanrack.traces.export.mcapfile.scan_schema", with_text)
    with pytest.raises(TraceError, match="fields after the tags: field 'string note' has no fixed size"):
        open_trace(copied(path))
