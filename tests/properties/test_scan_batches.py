"""The records of a batch of scans, read with numpy: each column is what was added, at its place."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
from amounts import amount
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scanrack.traces.format.batch import ScanBatch, TagBatch
from scanrack.traces.format.message_layout import message_layout
from scanrack.traces.format.tagplan import Tag, TagPlan, plan_of

CHANNEL = 0x0107
PLAN = plan_of([Tag("Level", "REAL"), Tag("Run", "BOOL")])
HEAD = {"opcode": 5, "channel": CHANNEL, "prefix": 0x0000_0100}
"""A message of MCAP; CDR, little-endian."""

scans = st.lists(
    st.tuples(
        st.integers(0, 2**40),
        st.integers(0, 2**32 - 1),
        st.binary(min_size=32, max_size=32),
        st.binary(min_size=5, max_size=5),
    ),
    min_size=1,
    max_size=12,
)
starts = st.tuples(st.integers(0, 2**33), st.integers(0, 2**63))


@dataclass
class Tags:
    """A source of tags that a test sets."""

    memory: bytearray
    plan: TagPlan = PLAN
    row: bytes = b""
    pending: list = field(default_factory=list)

    def take(self) -> bytes:
        return bytes(self.memory) + self.row


@pytest.mark.parametrize("tagged", [False, True], ids=["images", "tags"])
@settings(max_examples=amount(10))
@given(given=scans, start=starts)
@example(given=[(5, 1, bytes(32), bytes(5))] * 8, start=(2**32 - 3, 2**40))  # the number begins again
def test_every_column_is_what_was_added(tagged, given, start):
    memory = bytearray(32)
    tags = Tags(memory)
    batch = TagBatch(CHANNEL, memory, 99, tags) if tagged else ScanBatch(CHANNEL, memory, 99)
    layout = message_layout(32, PLAN.dtype if tagged else None)
    for turn in range(2):  # the second one with the same batch
        first, first_ns = start[0] + 1000 * turn, start[1]
        times_ns = [first_ns + int(sum(each[0] for each in given[:count])) for count in range(len(given))]
        for number, (scan, now_ns) in enumerate(zip(given, times_ns, strict=True), start=first):
            memory[:], tags.row = scan[2], scan[3]
            assert not batch.add(number, now_ns, scan[1])
        times, records = batch.take()
        rows = np.frombuffer(records, layout)
        numbers = [number % 2**32 for number in range(first, first + len(given))]
        for name, value in {**HEAD, "length": layout.itemsize - 9}.items():
            assert rows[name].tolist() == [value] * len(given)
        assert times.tolist() == rows["log_time"].tolist() == rows["publish_time"].tolist() == times_ns
        assert rows["sequence"].tolist() == rows["scan"].tolist() == numbers
        assert rows["flags"].tolist() == [each[1] for each in given]
        assert [row.tobytes() for row in rows["images"]] == [each[2] for each in given]
        if tagged:
            assert [row.tobytes() for row in rows["tags"]] == [each[3] for each in given]
        assert not len(batch)
