"""The file of a recorder: whole records, and room reserved for the end.

A trace without its summary opens in few tools, and a full disk has no room for
one. Therefore space is reserved from the start, by an anonymous file in
the same directory. It is as large as everything that must still be written when the disk is
full: the open chunk, its index and the summary.

    disk  | trace ............ | reserve |          recording
    disk  | trace .......................|X         no room: the reserve is released,
    disk  | trace ...........chunk|                 the chunk is finished,
    disk  | trace ...........chunk|summary|         the recorder is notified, the summary written

The messages of an unfinished chunk can be written as a draft, far enough after the trace that the
chunk fits before it. The chunk is written into that gap, its first bytes last; then the draft is cut off.
A killed process therefore leaves the draft or the chunk, complete.

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
from typing import Any, Protocol

from ..files.guard import TRACE, OwnedError, check_output
from ..files.keeping import RecordingKeeper, check_recordings
from ..files.locking import could_lock, held
from ..files.presence import Presence
from ..format.records import DRAFT, RECORD_HEAD

NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT})
"""Errors of a full disk and of an exhausted quota."""

SUMMARY_BYTES_PER_WRITE = 256
"""Upper bound of what a write adds to the summary: at most one chunk index, of 77 + 10 bytes per channel."""

SUMMARY_ROOM = 64 * 1024
"""The reserve's room for the summary; it grows by this size whenever it may be used up."""


class TraceFull(OSError):  # noqa: N818 - it says what is the matter
    """There is no room to extend the trace.

    Attributes:
        complete: whether everything recorded so far is in the file; otherwise the file was cut
            back to its last whole record, and data after its last whole chunk is lost.
    """

    def __init__(self, message: str, *, complete: bool) -> None:
        super().__init__(message)
        self.complete = complete


class RawFile(Protocol):
    """An unbuffered file, as returned by `open(path, "wb", buffering=0)`."""

    def write(self, data: memoryview, /) -> int | None:
        """Write as much of `data` as fits; return the number of bytes written."""

    def seek(self, place: int, /) -> int:
        """Move to a position in the file; used only for drafts."""

    def truncate(self, size: int, /) -> int:
        """Cut the file to `size` bytes."""

    def close(self) -> None:
        """Close the file."""


class ReservedSpace(Protocol):
    """Reserved space on the disk that can be released at once."""

    size: int
    """Reserved bytes."""

    def grow(self, size: int) -> None:
        """Reserve `size` more bytes; raise an OSError if that fails."""

    def release(self) -> None:
        """Release the reserved space."""


NOISE_BYTES = 1024 * 1024


@cache
def _noise() -> memoryview:
    return memoryview(os.urandom(NOISE_BYTES))


class DiskReserve:
    """Space reserved by an anonymous file in a directory, until the process ends at the latest.

    Raises:
        OSError: no file can be created there.
    """

    def __init__(self, directory: Path) -> None:
        self.size = 0
        self._file: Any = tempfile.TemporaryFile(dir=directory, buffering=0)  # noqa: SIM115

    def grow(self, size: int) -> None:
        """Reserve `size` more bytes, filled with random data, since some file systems do not store zeros.

        Raises:
            OSError: the disk has no room for them.
        """
        while size:
            start = int.from_bytes(os.urandom(2))  # as equal blocks may be stored only once
            bytes_written = self._file.write(_noise()[start:][:size])
            self.size += bytes_written
            size -= bytes_written

    def release(self) -> None:
        """Release the space."""
        self.size = 0
        self._file.close()


class TraceFile:
    """Appends whole records, and cuts the file back to whole records on an error.

    `full` becomes true once the reserve has been used up: the data written so far
    is safe and the summary still fits, but nothing else should be written.

    Args:
        raw: the file, which is empty.
        room: the reserve, or None. Without one, a full disk costs the open chunk
            and the summary.
        keeping: keeps earlier recordings, or None.
        drafts: whether drafts are possible, which they are in a file, but not on a device.
        presence: watches over the file, or None for a device.
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
        self._whole = 0
        self._drafts = drafts
        self._gap = self._draft_end = 0
        self._summary_room = SUMMARY_ROOM

    def tell(self) -> int:
        """Return the number of bytes written."""
        return self._whole

    def flush(self) -> None:
        """Do nothing, because nothing is buffered."""

    def write(self, data: bytes, /) -> int:
        """Append whole records.

        Raises:
            TraceFull: they could not be written even with the reserve; the file has been cut back to
                its last whole record, and accepts no more.
        """
        if self.failure is not None:
            raise self.failure
        if data:
            if self._presence is not None:
                self._presence.look(self._draft_end or self._whole)
                self._presence.add(data)
            try:
                self._append(memoryview(data))
            except OSError as error:
                self._abandon(error)
            self._whole += len(data)
            self._keep_up()
        return len(data)

    def draft(self, data: bytes, gap: int) -> None:
        """Write records that the next `write` replaces; until then they survive a kill of the process.

        After a failure, such as a full disk, there are no further drafts.

        Args:
            data: whole records, which follow those of earlier calls.
            gap: room for the next `write`, bytes; longer data are written less safely.
        """
        if not self._drafts or self.full:
            return
        if self._presence is not None:
            self._presence.look(self._draft_end or self._whole)
        try:
            if not self._draft_end:
                self._gap, self._draft_end = gap, self._whole + gap
                self._put(self._whole, RECORD_HEAD.pack(DRAFT, gap - RECORD_HEAD.size))
            self._put(self._draft_end, data)
            self._draft_end += len(data)
        except OSError:
            self._drafts = False
            with suppress(OSError):
                self._cut_draft()

    def reserve(self, size: int) -> bool:
        """Enlarge the reserve by `size` bytes, for larger records than planned.

        Returns:
            Whether the file is not full: it becomes full if the disk lacks the room.
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
            OSError: the system reports a late loss of data, or another program has removed, replaced or cut
                the file.
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
        if not self._draft_end:
            self._push(data)
        elif len(data) > self._gap:
            self._cut_draft()
            self._push(data)
        else:
            head, body = data[: RECORD_HEAD.size], data[RECORD_HEAD.size :]
            self._raw.seek(self._whole + len(head))
            self._push(body)
            self._raw.seek(self._whole)
            self._push(head)
            self._cut_draft(len(data))

    def _cut_draft(self, more: int = 0) -> None:
        """Cut the file `more` bytes after its whole records, and continue there."""
        self._draft_end = 0
        self._raw.truncate(self._whole + more)
        self._raw.seek(self._whole + more)

    def _put(self, place: int, data: bytes) -> None:
        """Write at a place, without using the reserve."""
        self._raw.seek(place)
        unwritten = memoryview(data)
        while unwritten:
            unwritten = unwritten[self._raw.write(unwritten) or 0 :]

    def _push(self, rest: memoryview) -> None:
        while rest:
            try:
                bytes_written = self._raw.write(rest)
            except OSError as error:
                if error.errno not in NO_ROOM or not self._release():
                    raise
            else:
                if not bytes_written:
                    raise OSError(errno.EIO, "the file takes no more bytes")
                rest = rest[bytes_written:]

    def _release(self) -> bool:
        """Release the reserve; return whether there was one."""
        if self._room is None:
            return False
        self._room.release()
        self._room = None
        self.full = True
        return True

    def _keep_up(self) -> None:
        """Enlarge the reserve as the summary grows; if that fails, mark the file as full, in time."""
        self._summary_room -= SUMMARY_BYTES_PER_WRITE
        if self._room is not None and self._summary_room < 0:
            try:
                self._room.grow(SUMMARY_ROOM)
                self._summary_room += SUMMARY_ROOM
            except OSError:
                self.full = True

    def _abandon(self, error: OSError) -> None:
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

    A device or pipe has no reserve, and neither does a file in a directory that allows no new files. The
    file is locked until it is closed or the process ends (not on Windows).

    Raises:
        OwnedError: the existing file is not a recording, or would have to be moved while it is being
            recorded.
        OSError: the path can't be written, another process records there, or the reserve found no
            room. The message has the cause, and nothing has changed.
    """
    if path.is_dir():
        raise _refusal(path, "it is a directory")
    if not path.parent.is_dir():
        raise _refusal(path, f"no directory {str(path.parent)!r}")
    if path.exists() and not path.is_file():
        keeping = None
    target = check_output(path, TRACE)
    reserve = _reserve(path, reserve_bytes)
    try:
        with nullcontext() if keeping is None else held(target):
            raw = _emptied(path) if keeping is None else _beginning(path, keeping)
    except (OSError, OwnedError) as error:
        if reserve is not None:
            reserve.release()
        if isinstance(error, OwnedError):
            raise
        raise _refusal(path, str(error.strerror)) from error
    presence = Presence(path, raw.fileno()) if path.is_file() else None
    return TraceFile(raw, str(path), reserve, keeping, drafts=presence is not None, presence=presence)


def _beginning(path: Path, keeping: RecordingKeeper) -> FileIO:
    check_recordings([path], keeping)
    keeping.begin()
    try:
        return _emptied(path)
    except OSError:
        keeping.undo()
        raise


def _emptied(path: Path) -> FileIO:
    """Open a file for writing, lock it, and then empty it; raise an OSError if it is locked already."""
    raw = open(path, "wb", buffering=0, opener=_not_truncating)  # noqa: SIM115
    try:
        if path.is_file():
            if not could_lock(raw.fileno()):
                raise OSError(errno.EBUSY, "another recording goes there; give this one its own file")
            raw.truncate(0)
    except OSError:
        raw.close()
        raise
    return raw


def _not_truncating(path: str, flags: int) -> int:
    return os.open(path, flags & ~os.O_TRUNC, 0o666)


def _refusal(path: Path | str, why: str) -> OSError:
    return OSError(f"{path}: {why}")


def _reserve(path: Path, size: int) -> DiskReserve | None:
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
        raise _refusal(path, f"{error.strerror}; {size:,} bytes are needed for its end") from error
    return reserve
