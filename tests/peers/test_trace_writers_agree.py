"""The chunk writer's files and those of the `mcap` library's writer hold the same, read by the library."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from scanrack.traces import Attachment, ScanRecorder, SlotInfo
from scanrack.traces.write import recorder
from stockwriter import StockWriter

happenings = st.lists(
    st.one_of(
        st.tuples(st.just("scan"), st.binary(min_size=64, max_size=64)),
        st.tuples(st.sampled_from(["/events", "/stimuli", "/faults"]), st.text(max_size=20)),
    ),
    max_size=80,
)


def record(path, script, chunk_scans):
    """Record a script of scans and events; return what the library's reader makes of the file."""
    memory = bytearray(64)
    slots = [SlotInfo(1, "amci3601", "4.1"), SlotInfo(4, "amci3601", "3.1")]
    writer = ScanRecorder(
        path,
        memory,
        slots,
        scan_period_ns=2_000_000,
        program=Attachment("logic.py", b"def logic(scan): ..."),
        metadata={"name": "both"},
        chunk_scans=chunk_scans,
    )
    scan = 0
    for what, content in script:
        if what == "scan":
            memory[:] = content
            writer.scan(scan, scan * 2_000_000, 1)
            scan += 1
        else:
            writer.event(scan, scan * 2_000_000, what, {"text": content})
    writer.close()
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        messages = [
            (
                channel.topic,
                schema and schema.name,
                message.sequence,
                message.log_time,
                message.publish_time,
                message.data,
            )
            for schema, channel, message in reader.iter_messages(log_time_order=False)
        ]
        header = reader.get_header()
        summary = reader.get_summary()
        assert summary is not None
        statistics = summary.statistics
        assert statistics is not None
        records = list(reader.iter_metadata()), list(reader.iter_attachments())
    by_topic = {topic: [entry for entry in messages if entry[0] == topic] for topic, *_ in messages}
    counted = statistics.message_count, statistics.message_start_time, statistics.message_end_time
    return by_topic, counted, records, header


@pytest.mark.slow
@given(script=happenings, chunk_scans=st.sampled_from([1, 7, 4096]))
def test_both_writers_hold_the_same(tmp_path_factory, script, chunk_scans):
    folder = tmp_path_factory.mktemp("writers")
    fast = record(folder / "fast.mcap", script, chunk_scans)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorder, "ChunkWriter", StockWriter)
        slow = record(folder / "slow.mcap", script, chunk_scans)
    assert fast == slow
