"""The flight recorder, which writes every scan to an MCAP file, and events to separate topics.

    /scan      one message per scan: its number, flags and the rack's memory block
    /events /stimuli /indicators /forces /cpu /faults      JSON, on change only

`sequence` is the scan number (modulo 2**32), `log_time` and `publish_time` are
virtual ns. Nothing in the file depends on the date, the location or the process, so that equal runs write
equal bytes.

An exception in the middle of a call, such as KeyboardInterrupt, would damage the file. The caller must
therefore handle Ctrl-C between scans, with a signal handler that sets a flag.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Never

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.versions import distribution_version

from ..files.keeping import RecordingKeeper
from ..format.batch import HEAD_BYTES, ScanBatch, TagBatch
from ..format.layout import SlotInfo, block_layout, check_slots
from ..format.named_words import facts_of
from ..format.schema import FORMAT, FORMAT_WITH_TAGS, LIBRARY, METADATA, PROFILE, scan_schema
from ..format.snapshots import SNAPSHOTS
from ..format.tagplan import TagSource
from ..format.topics import ORDERS, SCAN_TOPIC, SEQUENCES, TEXTS, TOPICS, Topic
from ..format.wordmap import word_map
from .chunks import ChunkWriter
from .output import SUMMARY_ROOM, TraceFile, TraceFull, open_trace_file
from .snapshots import SnapshotLog

CHUNK_BYTES_MAX = 1024 * 1024
CHUNK_SCANS = 4096
"""Maximum scans in a chunk; a killed process loses the open chunk's scans since its last draft."""

Value = str | int | float | bool | None | list[int] | list[str] | Mapping[str, str | int | float | bool]


@dataclass(frozen=True, slots=True)
class Attachment:
    """A file that is attached to the trace."""

    name: str  # its name, without a path on this machine
    data: bytes
    media_type: str = "text/plain"


class ScanRecorder:
    """Records the scans of a rack; a listener of the scan loop.

    Args:
        target: path of the trace, replaced if it exists, or an open file of traces.output.
        memory: the rack's memory block, read at every scan; for each slot it has the output image, then the
            input image.
        slots: the slots in the order of the memory block.
        program: source of the logic, which is attached. Its SHA-256 is in the metadata.
        rack_file: the rack file, which is attached. Its SHA-256 is in the metadata.
        chunk_scans: maximum number of scans in a chunk; a smaller number limits the loss if the process is
            killed.
        tags: source of the recorded tags' values; None = no tags.
        orders: whether users can operate the rack while it runs; if so, the trace has /orders.
        sequences: whether events of /sequences will follow.
        keeping: keeps earlier recordings; if None, `target` is replaced.
        snapshots: snapshots of the program's values, written at the end; None = no snapshots.

    Raises:
        ValueError: the slots and memory block do not match, or a slot is given twice.
        OSError: the target can't be written; TraceFull on a full disk.
    """

    def __init__(
        self,
        target: Path | str | TraceFile,
        memory: bytearray,
        slots: Sequence[SlotInfo],
        *,
        scan_period_ns: int,
        seed: int = 0,
        program: Attachment | None = None,
        rack_file: Attachment | None = None,
        metadata: Mapping[str, str] | None = None,
        attachments: Sequence[Attachment] = (),
        chunk_scans: int = CHUNK_SCANS,
        tags: TagSource | None = None,
        orders: bool = False,
        sequences: bool = False,
        keeping: RecordingKeeper | None = None,
        snapshots: SnapshotLog | None = None,
    ) -> None:
        self._sequences = sequences
        self._snapshots = snapshots
        self._slots = check_slots(slots)
        size = block_layout(self._slots).size
        if len(memory) != size:
            raise ValueError(f"{len(slots)} slots need a memory block of {size} bytes, got {len(memory)}")
        self._memory = memory
        self._tags = tags
        self._orders = orders
        plan = None if tags is None else tags.plan
        self._schema = scan_schema(self._slots, plan)
        self._states: dict[str, Mapping[str, Value]] = {}  # the last message of each topic in `_STATES`
        self._closed = False
        head = {
            **self._facts(scan_period_ns, seed),
            **_hashes(program=program, rack=rack_file),
            **(metadata or {}),
        }
        files = [file for file in (program, rack_file, *attachments) if file is not None]
        files.append(Attachment("words.json", word_map(self._slots).encode(), "application/json"))
        if plan is not None:
            files.append(Attachment("tags.json", plan.to_json().encode(), "application/json"))
        message_bytes = HEAD_BYTES + len(memory) + (0 if plan is None else plan.size)
        self._batch_scans = max(1, min(chunk_scans, CHUNK_BYTES_MAX // message_bytes))
        self._chunk_bytes = self._batch_scans * message_bytes
        if not isinstance(target, TraceFile):
            # for the open chunk with its index, and for all that is written besides
            reserve = 2 * self._chunk_bytes + sum(len(file.data) for file in files) + SUMMARY_ROOM
            target = open_trace_file(Path(target), reserve, keeping)
        self._file = target
        self._begin(head, files)

    def _begin(self, head: dict[str, str], files: Sequence[Attachment]) -> None:
        """Write everything before the first chunk."""
        library = LIBRARY + head["scanrack"]
        try:
            self._writer = ChunkWriter(
                self._file, profile=PROFILE, library=library, chunk_bytes=self._chunk_bytes
            )
            self._channels = self._writer.register(self._schema, self._topics())
            self._channel = self._channels.pop(SCAN_TOPIC)
            self._writer.add_metadata(METADATA, head)
            for file in files:
                self._writer.add_attachment(file.name, file.media_type, file.data)
        except OSError:
            self._file.close()
            raise
        batch = self._channel, self._memory, self._batch_scans
        self._batch = ScanBatch(*batch) if self._tags is None else TagBatch(*batch, self._tags)
        self._refusal: str | None = None  # the message of `TraceFull` once the disk is full
        self._draft_due = False  # the next scan writes a draft
        self._drafts = False  # a draft was requested before
        if self._file.full:
            self.close()
            self._refuse("before the first scan")

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Record a finished scan, with the current memory block.

        Args:
            scan: number of the scan, 0 or more.
            flags: flags of the controller, 0 to 2**32 - 1.

        Raises:
            TraceFull: the disk is full. This scan is in the trace, but later scans will not be; `close`
                still writes the summary.
        """
        if self._batch.add(scan, now_ns, flags):
            self._write_batch(scan, now_ns)
        if self._snapshots is not None and not (scan + 1) % self._snapshots.every:
            self._snapshots.scan(scan)

    @property
    def look(self) -> Callable[[], bool] | None:
        """The function to call after the logic of each scan recorded as a row, see `ScanBatch.look`."""
        return self._batch.look

    def begin_rows(self, scan: int) -> int:
        """Return the maximum number of scans for `rows`, up to the batch's end or the next snapshot."""
        rows_free, snapshots = self._batch.begin_rows(), self._snapshots
        return rows_free if snapshots is None else min(rows_free, snapshots.every - scan % snapshots.every)

    def rows(self, scans: list[int], times: list[int], flags: int, images: list[bytes]) -> None:
        """Record successive finished scans, at most `begin_rows`, as if `scan` were called for each.

        Args:
            images: the memory block in each scan.

        Raises:
            TraceFull: as in `scan`.
        """
        if self._batch.add_rows(scans, times, flags, images):
            self._write_batch(scans[-1], times[-1])
        if self._snapshots is not None and not (scans[-1] + 1) % self._snapshots.every:
            self._snapshots.scan(scans[-1])

    def _write_batch(self, scan: int, now_ns: int) -> None:
        """Pass the collected scans to the writer, then write a due draft and the events of their tags."""
        self._hand_over(scan)
        if self._draft_due:
            self._draft(scan)
        if self._tags is not None and self._tags.pending:
            self._write_pending(scan, now_ns)

    def draft_soon(self) -> None:
        """Write the open chunk uncompressed with the next scan, in case the process is killed.

        This does not change the bytes of the finished trace.
        """
        if self._refusal is None:
            self._draft_due = self._drafts = True
            self._batch.room = 1

    def _draft(self, scan: int) -> None:
        self._draft_due = False
        self._writer.draft(self._file)
        self._after_writing(scan)

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, Value]) -> None:
        """Record an event; do not write an unchanged state again.

        Args:
            scan: number of the scan that reported the event.
            topic: one of `TOPICS`, or "/sequences" if the recorder was created with `sequences`.
            fields: the event's values by name.

        Raises:
            ValueError: the topic is not recorded.
            TraceFull: as in `scan`.
        """
        if topic not in self._channels:
            raise ValueError(f"topic {topic!r} is not recorded; choose from {', '.join(self._channels)}")
        if topic in _STATES:
            if self._states.get(topic) == fields:
                return
            self._states[topic] = dict(fields)
        self._hand_over(scan)  # the scans that precede it
        self._write(scan, now_ns, topic, fields)

    def _topics(self) -> tuple[Topic, ...]:
        has_texts = self._tags is not None and self._tags.plan.has_texts
        optional = ((TEXTS, has_texts), (ORDERS, self._orders), (SEQUENCES, self._sequences))
        return (*TOPICS, *(topic for topic, is_used in optional if is_used))

    def _write_pending(self, scan: int, now_ns: int) -> None:
        """Write the events of a scan's tags: new texts, and values that do not fit."""
        assert self._tags is not None
        for topic, fields in self._tags.pending:
            self._write(scan, now_ns, topic, fields)
        self._tags.pending.clear()

    def _write(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, Value]) -> None:
        self._writer.add_event(self._channels[topic], scan, now_ns, fields)
        self._after_writing(scan)

    def _hand_over(self, scan: int) -> None:
        """Pass the collected scans to the writer; raise `TraceFull` if the disk is full."""
        if self._refusal is not None:
            raise TraceFull(self._refusal, complete=True)
        if len(self._batch):
            times, block = self._batch.take()
            self._writer.add_block(self._channel, times, block)
            self._after_writing(scan)

    def _after_writing(self, scan: int) -> None:
        """Check the disk, and set the batch's room to the remaining scans of the chunk."""
        if self._file.full:
            self._refuse(f"at scan {scan}")
        if self._draft_due:
            self._batch.room = 1
            return
        self._batch.room = max(1, -(-(self._chunk_bytes - self._writer.open_bytes) // self._batch.stride))

    def attach(self, scan: int, files: Sequence[Attachment]) -> None:
        """Attach more files to the trace.

        Args:
            scan: number of the first scan that needs them.

        Raises:
            TraceFull: the disk has no space for the files; none of them is in the trace.
        """
        if self._refusal is not None:
            raise TraceFull(self._refusal, complete=True)
        if not self._file.reserve(sum(len(file.data) for file in files)):
            self._refuse(f"before scan {scan}")
        for file in files:
            self._writer.add_attachment(file.name, file.media_type, file.data)
        if self._drafts:
            self._writer.draft(self._file)  # in place of the removed draft

    def close(self) -> None:
        """Write the open chunk and the summary, and close the file.

        Raises:
            TraceFull: even the reserved space was not enough.
        """
        if self._closed:
            return
        self._closed = True
        try:
            if self._file.failure is None:
                if self._refusal is None and len(self._batch):
                    self._writer.add_block(self._channel, *self._batch.take())
                self._attach_snapshots()
                self._writer.finish()
        finally:
            self._file.close()

    def _attach_snapshots(self) -> None:
        """Write the snapshots if the disk has space, since they save time but contain no new data."""
        data = None if self._snapshots is None or self._refusal is not None else self._snapshots.packed()
        if data is not None and self._file.reserve(len(data)):
            self._writer.add_attachment(SNAPSHOTS, "application/zstd", data)

    def _refuse(self, end_text: str) -> Never:
        """Refuse further scans, and raise `TraceFull`."""
        self._refusal = f"{self._file.name}: the disk is full; the trace is complete and ends {end_text}"
        self._batch.room = 1  # so that every further scan is refused at once
        raise TraceFull(self._refusal, complete=True)

    def _facts(self, scan_period_ns: int, seed: int) -> dict[str, str]:
        """Return the metadata about the format, the run, the slots and the versions of the software."""
        facts = {
            "format": str(FORMAT if self._tags is None else FORMAT_WITH_TAGS),
            "layout": self._schema.layout,
            "scan_period_ns": str(scan_period_ns),
            "seed": str(seed),
            "slots": " ".join(str(slot.number) for slot in self._slots),
        }
        for slot in self._slots:
            facts[f"slot.{slot.number}.module"] = slot.module
            facts[f"slot.{slot.number}.firmware"] = slot.firmware
            facts |= facts_of(slot.number, slot.words)
        return facts | {name: distribution_version(name) for name in ("scanrack", "mcap")}


_STATES = frozenset(topic.name for topic in TOPICS if topic.state)


def _hashes(**files: Attachment | None) -> dict[str, str]:
    """Return metadata `NAME_sha256` with the SHA-256 of each file that is not None."""
    return {
        f"{name}_sha256": hashlib.sha256(file.data).hexdigest()
        for name, file in files.items()
        if file is not None
    }
