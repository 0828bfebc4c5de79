"""The file behind a recorder: whole records, and room kept for the end.

A trace without its summary opens in few tools, and a disk that is full has no
room for one. So room is held from the start by a ballast, an anonymous file in
the same directory, as large as what may still have to be written when nothing
else fits: the open chunk, its index and the summary.

    disk  | trace ............ | ballast |          recording
    disk  | trace .......................|X         no room: the ballast goes,
    disk  | trace ...........chunk|                 the chunk is finished,
    disk  | trace ...........chunk|summary|         the recorder is notified, the summary written

What belongs to a chunk that is not finished can be written as a draft, far enough behind the trace that the
chunk fits before it. The chunk is written into that gap, its first bytes last; then the draft is cut off.
So a killed process leaves the draft or the chunk, whole.

    trace | DRAFT, gap ......... | message | message |
    trace | DRAFT, ..chunk|index | message | message |
    trace | chunk, ..chunk|index |
"""

from __future__ import annotations

import errno
import os
import tempfile
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import BinaryIO, Protocol

from ..files.guard import TRACE, OwnedError, check_output
from ..files.keeping import RecordingKeeper, check_recordings
from ..files.locking import could_lock, held
from ..format.records import DRAFT, RECORD_HEAD

NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT})
"""What a full disk and a used-up quota answer."""

SUMMARY_BYTES_PER_WRITE = 256
"""More than what one write adds to the summary: at most one chunk index of 77 + 10 bytes per channel."""

SUMMARY_ROOM = 64 * 1024
"""How much of the ballast is for the summary; the ballast grows by as much whenever it may be used up."""


class TraceFull(OSError):  # noqa: N818 - it says what is the matter
    """The trace can take no more.

    Attributes:
        complete: all that was recorded up to now is in the file; otherwise the file was cut
            back to its last whole record, and what came after its last whole chunk is lost.
    """

    def __init__(self, message: str, *, complete: bool) -> None:
        super().__init__(message)
        self.complete = complete


class RawFile(Protocol):
    """An unbuffered file, as `open(path, "wb", buffering=0)` gives it."""

    def write(self, data: memoryview, /) -> int | None:
        """Write as much of `data` as goes; return how much that was."""

    def seek(self, place: int, /) -> int:
        """Go on writing at a place; only used for drafts."""

    def truncate(self, size: int, /) -> int:
        """Cut the file to `size` bytes."""

    def close(self) -> None:
        """Close the file."""


class Room(Protocol):
    """Room on the disk that can be given back at once."""

    size: int
    """Bytes held."""

    def grow(self, size: int) -> None:
        """Hold `size` bytes more; OSError where they can't be had."""

    def release(self) -> None:
        """Give all of it back to the disk."""


class Ballast:
    """Room held by an anonymous file in a directory.

    Args:
        directory: where; the file has no name there, and goes with the process.

    Raises:
        OSError: no file can be made there.
    """

    def __init__(self, directory: Path) -> None:
        self.size = 0
        self._file: BinaryIO = tempfile.TemporaryFile(dir=directory, buffering=0)  # noqa: SIM115

    def grow(self, size: int) -> None:
        """Hold `size` bytes more, truly allocated: noise, since some file systems store zeros as nothing.

        Raises:
            OSError: the disk has no room for them.
        """
        noise = memoryview(os.urandom(size))
        while noise:
            written = self._file.write(noise)
            self.size += written
            noise = noise[written:]

    def release(self) -> None:
        """Give the room back."""
        self.size = 0
        self._file.close()


class TraceFile:
    """Takes whole records, and cuts the file back to whole records on an error.

    `full` becomes true once the ballast has been used up: what was written by
    then is safe, the summary still fits, and nothing else should follow.

    Args:
        raw: where the bytes go, empty.
        name: what messages call it.
        room: the ballast, None to do without. Without one, a full disk costs the open chunk
            and the summary.
        keeping: keeps the recordings before it; None to keep none.
        drafts: whether drafts can be written: to a file, but to no device.
    """

    def __init__(
        self,
        raw: RawFile,
        name: str,
        room: Room | None = None,
        keeping: RecordingKeeper | None = None,
        *,
        drafts: bool = False,
    ) -> None:
        self.name = name
        self.full = False
        self.failure: TraceFull | None = None
        self._raw = raw
        self._room = room
        self._keeping = keeping
        self._whole = 0
        self._drafts = drafts
        self._gap = self._draft_end = 0
        self._summary_room = SUMMARY_ROOM

    def tell(self) -> int:
        """Return how many bytes have been written."""
        return self._whole

    def flush(self) -> None:
        """Do nothing: nothing is buffered."""

    def write(self, data: bytes, /) -> int:
        """Append whole records.

        Raises:
            TraceFull: they could not be written, ballast or not; the file has been cut back to
                its last whole record and takes no more.
        """
        if self.failure is not None:
            raise self.failure
        if data:
            try:
                self._append(memoryview(data))
            except OSError as error:
                self._abandon(error)
            self._whole += len(data)
            self._keep_up()
        return len(data)

    def draft(self, data: bytes, gap: int) -> None:
        """Write records that the next `write` replaces; until then a killed process leaves them.

        Where that fails, such as on a full disk, there are no drafts any more.

        Args:
            data: whole records, which follow those of earlier calls.
            gap: room for what the next `write` is given; what is longer is written less safely.
        """
        if not self._drafts or self.full:
            return
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
        """Let the ballast grow by `size` bytes, for records larger than it was made for.

        Returns:
            Whether the disk has that room; the file is full if it has not.
        """
        if self._room is not None and not self.full:
            try:
                self._room.grow(size)
            except OSError:
                self.full = True
        return not self.full

    def close(self) -> None:
        """Close the file and give the ballast back.

        Raises:
            OSError: the system reports at this late point that data was lost.
        """
        if self._room is not None:
            self._room.release()
            self._room = None
        self._raw.close()
        if self._keeping is not None:
            self._keeping.end()
            self._keeping = None

    def _append(self, data: memoryview) -> None:
        """Write records behind the others, in place of a draft."""
        if not self._draft_end:
            self._push(data)
        elif len(data) > self._gap:
            self._cut_draft()
            self._push(data)
        else:
            head, rest = data[: RECORD_HEAD.size], data[RECORD_HEAD.size :]
            self._raw.seek(self._whole + len(head))
            self._push(rest)
            self._raw.seek(self._whole)
            self._push(head)
            self._cut_draft(len(data))

    def _cut_draft(self, more: int = 0) -> None:
        """Cut the file behind its whole records and so many bytes; go on there."""
        self._draft_end = 0
        self._raw.truncate(self._whole + more)
        self._raw.seek(self._whole + more)

    def _put(self, place: int, data: bytes) -> None:
        """Write at a place, without the help of the ballast."""
        self._raw.seek(place)
        rest = memoryview(data)
        while rest:
            rest = rest[self._raw.write(rest) or 0 :]

    def _push(self, rest: memoryview) -> None:
        while rest:
            try:
                written = self._raw.write(rest)
            except OSError as error:
                if error.errno not in NO_ROOM or not self._release():
                    raise
            else:
                if not written:
                    raise OSError(errno.EIO, "the file takes no more bytes")
                rest = rest[written:]

    def _release(self) -> bool:
        """Give up the ballast; return whether there was one."""
        if self._room is None:
            return False
        self._room.release()
        self._room = None
        self.full = True
        return True

    def _keep_up(self) -> None:
        """Let the ballast grow with the summary; where it can't, the file is full in good time."""
        self._summary_room -= SUMMARY_BYTES_PER_WRITE
        if self._room is not None and self._summary_room < 0:
            try:
                self._room.grow(SUMMARY_ROOM)
                self._summary_room += SUMMARY_ROOM
            except OSError:
                self.full = True

    def _abandon(self, error: OSError) -> None:
        """Cut the file back to its last whole record and raise `TraceFull`."""
        self.full = True
        try:
            self._raw.truncate(self._whole)
            state = f"it was cut back to its last whole record, at byte {self._whole:,}"
        except OSError as worse:
            state = f"it could not even be cut back to byte {self._whole:,} ({worse.strerror})"
        message = f"{self.name}: {error.strerror}; {state}, and has no summary"
        self.failure = TraceFull(message, complete=False)
        raise self.failure from error


def open_trace_file(path: Path, ballast_bytes: int, keeping: RecordingKeeper | None = None) -> TraceFile:
    """Open `path` for a new trace, replacing what is there, or keeping it under another name.

    A device or pipe has no ballast, nor has a file in a directory that takes no new files. The
    file is locked until it is closed or the process ends, however it ends (not on Windows).

    Raises:
        OwnedError: what is there is not a recording, or would have to be moved while it is being recorded.
        OSError: the path can't be written, another recording goes there, or the ballast found no
            room; the message says why, and nothing has changed.
    """
    if path.is_dir():
        raise _refusal(path, "it is a directory")
    if not path.parent.is_dir():
        raise _refusal(path, f"there is no directory {str(path.parent)!r}")
    if path.exists() and not path.is_file():
        keeping = None
    target = check_output(path, TRACE)
    room = _ballast(path, ballast_bytes)
    try:
        with nullcontext() if keeping is None else held(target):
            raw = _emptied(path) if keeping is None else _beginning(path, keeping)
    except (OSError, OwnedError) as error:
        if room is not None:
            room.release()
        if isinstance(error, OwnedError):
            raise
        raise _refusal(path, str(error.strerror)) from error
    return TraceFile(raw, str(path), room, keeping, drafts=path.is_file())


def _beginning(path: Path, keeping: RecordingKeeper) -> RawFile:
    """Move the recordings before it aside, and open a new one."""
    check_recordings([path], keeping)
    keeping.begin()
    try:
        return _emptied(path)
    except OSError:
        keeping.undo()
        raise


def _emptied(path: Path) -> RawFile:
    """Open a file for writing and lock it, and only then empty it; OSError if it is locked."""
    raw = open(path, "wb", buffering=0, opener=_not_truncating)  # noqa: SIM115
    try:
        if path.is_file():
            if not could_lock(raw.fileno()):
                raise OSError(errno.EBUSY, "another recording goes there; give this one a file of its own")
            raw.truncate(0)
    except OSError:
        raw.close()
        raise
    return raw


def _not_truncating(path: str, flags: int) -> int:
    return os.open(path, flags & ~os.O_TRUNC, 0o666)


def _refusal(path: Path, why: str) -> OSError:
    return OSError(f"{path}: {why}")


def _ballast(path: Path, size: int) -> Ballast | None:
    if path.exists() and not path.is_file():
        return None
    try:
        room = Ballast(path.parent)
    except PermissionError:
        return None
    try:
        room.grow(size)
    except OSError as error:
        room.release()
        raise _refusal(path, f"{error.strerror}; {size:,} bytes are needed for its end") from error
    return room
