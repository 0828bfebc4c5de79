"""A recorder's file, which contains only complete records, and reserved disk space for its end.

Few tools open a trace without its summary, and a full disk has no space for one. Therefore an anonymous file
in the same directory reserves enough space from the start for the open chunk, its index and the summary.

    disk  | trace ............ | reserve |          recording
    disk  | trace .......................|X         the disk is full: the reserve is released
    disk  | trace ...........chunk|                 the chunk is finished, and the recorder stops
    disk  | trace ...........chunk|summary|         the summary is written

The messages of an unfinished chunk can be written as a draft. A gap before the draft is large enough for the
chunk. The chunk is later written there; its first bytes are written last. The draft is then cut off. A killed
process therefore leaves the complete draft or the complete chunk.

    trace | DRAFT, gap ......... | message | message |
    trace | DRAFT, ..chunk|index | message | message |
    trace | chunk, ..chunk|index |
"""

from __future__ import annotations

import errno
import os
import tempfile
from contextlib import nullcontext, suppress
from functools import cache
from io import FileIO
from pathlib import Path
from typing import Any, Never, Protocol

from ..files.guard import TRACE, OwnedError, check_output
from ..files.keeping import RecordingKeeper, check_recordings
from ..files.locking import could_lock, held
from ..files.presence import Presence
from ..format.records import DRAFT, RECORD_HEAD

NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT})
"""Errors of a full disk and of an exhausted quota."""

SUMMARY_BYTES_PER_WRITE = 256
"""Maximum bytes that a write adds to the summary: one chunk index of 77 bytes plus 10 bytes per channel."""

SUMMARY_ROOM = 64 * 1024
"""Number of bytes reserved for the summary; before they are used up, the reserve grows by this number."""


class TraceFull(OSError):  # noqa: N818 - names the condition
    """The disk has no space to extend the trace.

    Attributes:
        complete: whether everything recorded so far is in the file; otherwise the file was cut back to its
            last complete record, and the data after its last complete chunk is lost.
    """

    def __init__(self, message: str, *, complete: bool) -> None:
        super().__init__(message)
        self.complete = complete


class RawFile(Protocol):
    """An unbuffered file, as returned by `open(path, "wb", buffering=0)`."""

    def write(self, data: memoryview, /) -> int | None:
        """Write as much of `data` as fits; return the number of bytes written."""

    def seek(self, offset: int, /) -> int:
        """Move to an offset in the file; used only for drafts."""

    def truncate(self, size: int, /) -> int:
        """Cut the file to `size` bytes."""

    def close(self) -> None:
        """Close the file."""


class ReservedSpace(Protocol):
    """Reserved space on the disk that can be released at once."""

    size: int
    """Reserved bytes."""

    def grow(self, size: int) -> None:
        """Reserve `size` additional bytes; raise an OSError if this fails."""

    def release(self) -> None:
        """Release the reserved space."""


NOISE_BYTES = 1024 * 1024


@cache
def _noise() -> memoryview:
    return memoryview(os.urandom(NOISE_BYTES))


class DiskReserve:
    """Disk space reserved by an anonymous file in a directory; it is released when the process ends.

    Raises:
        OSError: no file can be created there.
    """

    def __init__(self, directory: Path) -> None:
        self.size = 0
        self._file: Any = tempfile.TemporaryFile(dir=directory, buffering=0)  # noqa: SIM115

    def grow(self, size: int) -> None:
        """Reserve `size` more bytes filled with random data, since some file systems do not store zeros.

        Raises:
            OSError: the disk has no space for them.
        """
        while size:
            start = int.from_bytes(os.urandom(2))  # a file system may store equal blocks only once
            bytes_written = self._file.write(_noise()[start:][:size])
            self.size += bytes_written
            size -= bytes_written

    def release(self) -> None:
        """Release the space."""
        self.size = 0
        self._file.close()


class TraceFile:
    """Appends complete records, and cuts the file back to complete records after an error.

    Args:
        raw: the empty file.
        room: the reserve; None = no reserve, so a full disk loses the open chunk and the summary.
        keeping: keeps earlier recordings, or None.
        drafts: whether drafts are possible, which is true for a file but not for a device.
        presence: detects that another program changes the file; None for a device.

    Attributes:
        full: whether the reserve is used up. The data written so far is safe and the summary still fits, but
            nothing else should be written.
        failure: the error after which the file accepts no more data, or None.
    """

    def __init__(
        self,
        raw: RawFile,
        name: str,
        room: ReservedSpace | None = None,
        keeping: RecordingKeeper | None = None,
        *,
        drafts: bool = False,
        presence: Presence | None = None,
    ) -> None:
        self.name = name
        self.full = False
        self.failure: TraceFull | None = None
        self._raw = raw
        self._room = room
        self._keeping = keeping
        self._presence = presence
        self._whole = 0  # bytes of whole records, without a draft
        self._drafts = drafts
        self._gap = 0  # bytes of the gap before the draft
        self._draft_end = 0  # offset after the draft; 0 = no draft
        self._summary_room = SUMMARY_ROOM  # bytes of the reserve for the summary

    def tell(self) -> int:
        """Return the number of bytes written."""
        return self._whole

    def flush(self) -> None:
        """Do nothing, because nothing is buffered."""

    def write(self, data: bytes, /) -> int:
        """Append complete records.

        Raises:
            TraceFull: even the reserve was not enough; the file was cut back to its last complete record, and
                accepts no more data.
        """
        if self.failure is not None:
            raise self.failure
        if data:
            if self._presence is not None:
                self._presence.check_size(self._draft_end or self._whole)
                self._presence.add(data)
            try:
                self._append(memoryview(data))
            except OSError as error:
                self._abandon(error)
            self._whole += len(data)
            self._grow_summary_room()
        return len(data)

    def draft(self, data: bytes, gap: int) -> None:
        """Write records that the next `write` replaces; they survive if the process is killed first.

        After a failure, such as a full disk, there are no further drafts.

        Args:
            data: complete records, which follow the records of earlier calls.
            gap: bytes for the next `write`; if its data is longer and the process is killed, the draft can be
                lost.
        """
        if not self._drafts or self.full:
            return
        if self._presence is not None:
            self._presence.check_size(self._draft_end or self._whole)
        try:
            if not self._draft_end:
                self._gap, self._draft_end = gap, self._whole + gap
                self._write_at(self._whole, RECORD_HEAD.pack(DRAFT, gap - RECORD_HEAD.size))
            self._write_at(self._draft_end, data)
            self._draft_end += len(data)
        except OSError:
            self._drafts = False
            with suppress(OSError):
                self._cut_draft()

    def reserve(self, size: int) -> bool:
        """Enlarge the reserve by `size` bytes, for larger records than planned.

        Returns:
            False if the file is full or the disk lacks the space.
        """
        if self._room is not None and not self.full:
            try:
                self._room.grow(size)
            except OSError:
                self.full = True
        return not self.full

    def close(self) -> None:
        """Close the file and release the reserve.

        Raises:
            OSError: the system reports a late loss of data, or another program has removed, replaced or
                truncated the file.
        """
        if self._room is not None:
            self._room.release()
            self._room = None
        presence, self._presence = self._presence, None
        loss = None if presence is None or self.failure is not None else presence.loss(self._whole)
        self._raw.close()
        if self._keeping is not None:
            self._keeping.end()
            self._keeping = None
        if loss is not None:
            raise _refusal(self.name, loss)

    def _append(self, data: memoryview) -> None:
        """Write data after the complete records, in place of a draft."""
        if not self._draft_end:
            self._write_all(data)
        elif len(data) > self._gap:
            self._cut_draft()
            self._write_all(data)
        else:  # the first bytes last, so that a kill leaves the draft or the data
            head, body = data[: RECORD_HEAD.size], data[RECORD_HEAD.size :]
            self._raw.seek(self._whole + len(head))
            self._write_all(body)
            self._raw.seek(self._whole)
            self._write_all(head)
            self._cut_draft(len(data))

    def _cut_draft(self, new_bytes: int = 0) -> None:
        """Cut the file off `new_bytes` after its complete records, and continue there."""
        self._draft_end = 0
        self._raw.truncate(self._whole + new_bytes)
        self._raw.seek(self._whole + new_bytes)

    def _write_at(self, offset: int, data: bytes) -> None:
        """Write at an offset, without using the reserve."""
        self._raw.seek(offset)
        unwritten = memoryview(data)
        while unwritten:
            unwritten = unwritten[self._raw.write(unwritten) or 0 :]

    def _write_all(self, unwritten: memoryview) -> None:
        """Write data at the current offset; release the reserve if the disk is full."""
        while unwritten:
            try:
                bytes_written = self._raw.write(unwritten)
            except OSError as error:
                if error.errno not in NO_ROOM or not self._release_room():
                    raise
            else:
                if not bytes_written:
                    raise OSError(errno.EIO, "the file accepts no more bytes")
                unwritten = unwritten[bytes_written:]

    def _release_room(self) -> bool:
        """Release the reserve; return whether there was a reserve."""
        if self._room is None:
            return False
        self._room.release()
        self._room = None
        self.full = True
        return True

    def _grow_summary_room(self) -> None:
        """Enlarge the reserve as the summary grows; if that fails, mark the file as full."""
        self._summary_room -= SUMMARY_BYTES_PER_WRITE
        if self._room is not None and self._summary_room < 0:
            try:
                self._room.grow(SUMMARY_ROOM)
                self._summary_room += SUMMARY_ROOM
            except OSError:
                self.full = True

    def _abandon(self, error: OSError) -> Never:
        """Cut the file back to its complete records; store and raise a `TraceFull`."""
        self.full = True
        try:
            self._raw.truncate(self._whole)
            state = f"it was cut back to its last whole record, at byte {self._whole:,}"
        except OSError as worse:
            state = f"it could not even be cut back to byte {self._whole:,} ({worse.strerror})"
        message = f"{self.name}: {error.strerror}; {state}, and has no summary"
        self.failure = TraceFull(message, complete=False)
        raise self.failure from error


def open_trace_file(path: Path, reserve_bytes: int, keeping: RecordingKeeper | None = None) -> TraceFile:
    """Open `path` for a new trace; replace the existing file, or keep it under another name.

    A device, a pipe, and a file in a directory that allows no new files have no reserve. The file is locked
    until it is closed or the process ends (not on Windows).

    Raises:
        OwnedError: the existing file is not a recording, or must be moved but is being recorded.
        OSError: the path can't be written, another process is recording there, or the disk lacks space for
            the reserve. The message states the cause, and nothing has changed.
    """
    if path.is_dir():
        raise _refusal(path, "it is a directory")
    if not path.parent.is_dir():
        raise _refusal(path, f"no directory {str(path.parent)!r}")
    if path.exists() and not path.is_file():
        keeping = None  # a device or a pipe has no earlier recordings
    target = check_output(path, TRACE)
    reserve = _reserve(path, reserve_bytes)
    try:
        with nullcontext() if keeping is None else held(target):
            raw = _opened_empty(path) if keeping is None else _opened_keeping(path, keeping)
    except (OSError, OwnedError) as error:
        if reserve is not None:
            reserve.release()
        if isinstance(error, OwnedError):
            raise
        raise _refusal(path, str(error.strerror)) from error
    presence = Presence(path, raw.fileno()) if path.is_file() else None
    return TraceFile(raw, str(path), reserve, keeping, drafts=presence is not None, presence=presence)


def _opened_keeping(path: Path, keeping: RecordingKeeper) -> FileIO:
    """Move the earlier recordings and open an empty file; move the recordings back after an OSError."""
    check_recordings([path], keeping)
    keeping.begin()
    try:
        return _opened_empty(path)
    except OSError:
        keeping.undo()
        raise


def _opened_empty(path: Path) -> FileIO:
    """Open a file for writing, lock it, and then empty it; raise an OSError if it is already locked."""
    raw = open(path, "wb", buffering=0, opener=_not_truncating)  # noqa: SIM115
    try:
        if path.is_file():
            if not could_lock(raw.fileno()):
                raise OSError(errno.EBUSY, "another process is recording to it; choose another file")
            raw.truncate(0)
    except OSError:
        raw.close()
        raise
    return raw


def _not_truncating(path: str, flags: int) -> int:
    return os.open(path, flags & ~os.O_TRUNC, 0o666)


def _refusal(path: Path | str, reason: str) -> OSError:
    return OSError(f"{path}: {reason}")


def _reserve(path: Path, size: int) -> DiskReserve | None:
    """Reserve space in the folder of a file; None for a device, or without permission for new files."""
    if path.exists() and not path.is_file():
        return None
    try:
        reserve = DiskReserve(path.parent)
    except PermissionError:
        return None
    try:
        reserve.grow(size)
    except OSError as error:
        reserve.release()
        raise _refusal(path, f"{error.strerror}; its end needs {size:,} bytes") from error
    return reserve
