"""The chunk writer's files and those of the `mcap` library's writer hold the same, read by the library.

The `mcap` library's own writer behind the recorder's interface: slow, and the oracle of the fast one.
"""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.data_stream import RecordBuilder
from mcap.reader import make_reader
from mcap.records import Channel, Schema
from mcap.writer import CompressionType, Writer
from scanrack.traces import Attachment, ScanRecorder, SlotInfo
from scanrack.traces.write import recorder
from scanrack.traces.write.chunks import ChunkWriter
from scanrack.traces.write.output import TraceFile


class StockWriter:
    """The `mcap` library's writer, with what it leaves to its user done.

    It compresses with zstd at the library's own level, writes all indexes and
    the CRCs of chunks and summary. It puts schemas and channels into the first
    chunk; they are written ahead of it as well, so that every whole chunk of a
    damaged file can be decoded.

    Args:
        file: where the records go.
        profile: the MCAP profile, "ros2".
        library: what the header names as the writing software.
        chunk_bytes: size at which a chunk is closed, before compression.
    """

    def __init__(self, file: TraceFile, *, profile: str, library: str, chunk_bytes: int) -> None:
        self._file = file
        self._writer = Writer(file, chunk_size=chunk_bytes, compression=CompressionType.ZSTD)  # type: ignore[arg-type]
        self._writer.start(profile, library)
        self.add_message = self._writer.add_message
        self.finish = self._writer.finish
        self.add_metadata = self._writer.add_metadata

    open_bytes = 0  # the library does not tell
    register, json_channel = ChunkWriter.register, ChunkWriter.json_channel  # they call `channel`
    add_event = ChunkWriter.add_event  # calls `add_message`

    def channel(self, topic: str, encoding: str, schema_name: str, schema_encoding: str, schema: str) -> int:
        """Register a channel with a schema of its own, and write both; return the channel's id."""
        data = schema.encode()
        schema_id = self._writer.register_schema(schema_name, schema_encoding, data)
        channel_id = self._writer.register_channel(topic, encoding, schema_id)
        records = RecordBuilder()
        Schema(id=schema_id, name=schema_name, encoding=schema_encoding, data=data).write(records)
        Channel(
            id=channel_id, topic=topic, message_encoding=encoding, metadata={}, schema_id=schema_id
        ).write(records)
        self._file.write(records.end())
        return channel_id

    def add_block(self, channel_id, log_times, block) -> None:
        """Take the messages of a block one by one."""
        stride = len(block) // len(log_times)
        for place, log_time in zip(range(0, len(block), stride), log_times.tolist(), strict=True):
            sequence = int.from_bytes(block[place + 11 : place + 15], "little")
            self.add_message(channel_id, log_time, block[place + 31 : place + stride], log_time, sequence)

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Write an attachment. It has no time of its own."""
        self._writer.add_attachment(create_time=0, log_time=0, name=name, media_type=media_type, data=data)


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
