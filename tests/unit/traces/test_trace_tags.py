"""Tags in a trace: their schema, their rows, and a trace without any that stays as it was."""

from __future__ import annotations

import hashlib
import json
import struct
from collections.abc import Mapping
from keyword import iskeyword
from pathlib import Path

import numpy as np
import pytest
from scanrack.traces import ScanRecorder, SlotInfo, Tag, TraceError, open_trace, read_columns
from scanrack.traces.format.schema import scan_schema
from scanrack.traces.format.tagplan import ROW_BYTES_MAX, VALUES_MAX, TagPlan, plan_of, read_plan

SLOTS = [SlotInfo(1, "amci3601", "4.1"), SlotInfo(2, "a toy")]

TAGS = [
    Tag("Run", "BOOL"),
    Tag(r"\Main.Step", "ENUM", 0, ("idle", "7up")),
    Tag("Fill.ACC", "DINT"),
    Tag("Count", "LINT"),
    Tag("Level", "REAL"),
    Tag("Ratio", "LREAL"),
    Tag("Recipe", "INT", 3),
    Tag("Small", "SINT"),
    Tag("Name", "TEXT"),
    Tag("Port", "UINT"),
    Tag("Byte", "USINT"),
]


class Values:
    """A source of tags whose values a test sets, in the order of the plan."""

    def __init__(self, memory: bytearray, tags: list[Tag]) -> None:
        self.plan: TagPlan = plan_of(tags)
        self.pending: list[tuple[str, Mapping[str, str | int]]] = []
        self.values: list[object] = []
        self._memory = memory

    def take(self) -> bytes:
        """Return memory block and row."""
        return bytes(self._memory) + struct.pack("<" + self.plan.letters, *self.values)


def test_no_field_of_a_scan_is_a_keyword_of_python() -> None:
    """pybag-sdk 0.13.0 can't read a message with such a field, and others rename it."""
    plan = plan_of([Tag("In", "BOOL"), Tag("From", "DINT"), Tag("Line", "DINT")])
    assert [field.name for field in plan.fields] == ["from_2", "line", "in_2"]
    lines = scan_schema(SLOTS, plan).text.splitlines()
    fields = [line.split()[1] for line in lines if line.split()[0] not in ("MSG:", "=" * 80)]
    assert {"inputs", "position_msw", "from_2"} < set(fields)
    assert not any(map(iskeyword, fields))


def test_fields_stand_widest_first_and_keep_their_order() -> None:
    plan = plan_of(TAGS)
    names = [field.name for field in plan.fields]
    assert names == [
        "count",
        "ratio",
        "fill_acc",
        "level",
        "main_step",
        "recipe",
        "name",
        "port",
        "run",
        "small",
        "byte",
    ]
    assert plan.dtype.itemsize == 8 + 8 + 4 + 4 + 2 + 3 * 2 + 2 + 2 + 1 + 1 + 1


def test_the_schema_tells_the_whole_plan() -> None:
    plan = plan_of(TAGS)
    schema = scan_schema(SLOTS, plan)
    again = read_plan(schema.text)
    assert again is not None
    assert [field.line for field in again.fields] == [field.line for field in plan.fields]
    assert again.dtype == plan.dtype
    assert scan_schema(SLOTS, again) == schema
    assert r"  # \Main.Step" in schema.text
    assert "uint16 T_7UP=1" in schema.text
    assert read_plan(scan_schema(SLOTS).text) is None


def test_rows_are_read_in_the_types_of_the_tags(tmp_path: Path) -> None:
    path, memory = tmp_path / "tags.mcap", bytearray(64)
    tags = Values(memory, TAGS)
    recorder = ScanRecorder(path, memory, SLOTS, scan_period_ns=2_000_000, tags=tags)
    for scan in range(5000):
        memory[0] = scan & 0xFF
        tags.values = [
            2**62 + scan,
            1 / 3,
            -scan,
            0.5,
            scan & 1,
            scan,
            2,
            3,
            0,
            0xFFFF,
            scan % 3 == 0,
            -7,
            255,
        ]
        recorder.scan(scan, scan * 2_000_000, 0)
    recorder.close()
    with open_trace(path) as trace:
        assert trace.head.metadata["format"] == "2"
        columns = read_columns(trace, tags=True)
        attached = {each.name: each.data for each in trace.attachments()}
        assert read_columns(trace).tags is None
        assert not trace.notes
    assert columns.tags is not None
    scans = np.arange(5000)
    assert (columns.tags["count"] == 2**62 + scans).all()
    assert (columns.tags["fill_acc"] == -scans).all()
    assert (columns.tags["main_step"] == scans % 2).all()
    assert (columns.tags["recipe"] == np.stack([scans, 0 * scans + 2, 0 * scans + 3], axis=1)).all()
    assert (columns.tags["run"] == (scans % 3 == 0)).all()
    assert (columns.tags["port"] == 0xFFFF).all()
    assert (columns.words[:, 0] == scans & 0xFF).all()
    rows = json.loads(attached["tags.json"])["tags"]
    assert {"name": "Recipe", "field": "tags.recipe", "type": "INT", "length": 3} in rows
    assert {
        "name": r"\Main.Step",
        "field": "tags.main_step",
        "type": "ENUM",
        "names": ["idle", "7up"],
    } in rows


def test_messages_follow_the_scan_that_gave_rise_to_them(tmp_path: Path) -> None:
    path, memory = tmp_path / "texts.mcap", bytearray(64)
    tags = Values(memory, [Tag("Name", "TEXT")])
    recorder = ScanRecorder(path, memory, SLOTS, scan_period_ns=2_000_000, tags=tags)
    for scan in range(10):
        code = 0 if scan < 5 else 1
        tags.values = [code]
        if scan in (0, 5):
            tags.pending.append(("/texts", {"tag": "Name", "code": code, "text": f"at {scan}"}))
        recorder.scan(scan, scan * 2_000_000, 0)
    recorder.close()
    with open_trace(path) as trace:
        told = [(each.scan, each.topic, dict(each.fields)) for each in trace.events()]
        assert [each.scan for each in trace.scans()] == list(range(10))
    assert told == [
        (0, "/texts", {"tag": "Name", "code": 0, "text": "at 0"}),
        (5, "/texts", {"tag": "Name", "code": 1, "text": "at 5"}),
    ]


def test_without_tags_there_is_neither_field_nor_topic(tmp_path: Path) -> None:
    path, memory = tmp_path / "plain.mcap", bytearray(64)
    recorder = ScanRecorder(path, memory, SLOTS, scan_period_ns=2_000_000)
    recorder.scan(0, 0, 0)
    recorder.close()
    with open_trace(path) as trace:
        assert trace.head.metadata["format"] == "1"
        assert trace.head.tags is None
        assert "/texts" not in trace.head.channels
        assert [each.name for each in trace.attachments()] == ["words.json"]
    # the schema of today, word for word: its hash is the name that other traces have
    text = scan_schema(SLOTS[:1]).text
    assert text.splitlines()[:3] == ["uint32 scan", "uint32 flags", "Amci3601 slot1"]
    assert scan_schema(SLOTS[:1]).layout == hashlib.sha256(text.encode()).hexdigest()[:12]


@pytest.mark.parametrize(
    ("tags", "says"),
    [
        ([], "no tag"),
        ([Tag("a", "BOOL"), Tag("a", "BOOL")], "a is given twice"),
        ([Tag("a", "BOOL", VALUES_MAX + 1)], "10,001 values"),
        ([Tag("a", "LINT", ROW_BYTES_MAX // 8 + 1)], "65,544 bytes"),
    ],
)
def test_a_row_has_bounds(tags: list[Tag], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        plan_of(tags)


@pytest.mark.parametrize(
    "damage", [("int32 fill_acc", "int33 fill_acc"), ("MSG: scanrack/Tags", "MSG: scanrack/Tugs")]
)
def test_a_schema_that_does_not_tell_its_tags_is_refused(tmp_path: Path, damage: tuple[str, str]) -> None:
    text = scan_schema(SLOTS, plan_of(TAGS)).text.replace(*damage)
    with pytest.raises(ValueError, match=r"unknown type|no message"):
        read_plan(text)


def test_a_later_format_is_refused_in_words(tmp_path: Path) -> None:
    path, memory = tmp_path / "later.mcap", bytearray(64)
    recorder = ScanRecorder(path, memory, SLOTS, scan_period_ns=2_000_000, metadata={"format": "3"})
    recorder.close()
    with pytest.raises(TraceError, match="format 3: must be 1 or 2"):
        open_trace(path)
