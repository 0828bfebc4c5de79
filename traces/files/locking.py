"""Advisory locks. Only one process at a time can record into a file or replace it.

    a recording     the file itself is locked until it is closed
    a replacement   .NAME.lock beside the file, while it is read, changed and replaced

A lock belongs to an open file, and ends when the file is closed or the process ends.
"""

from __future__ import annotations

import errno
import hashlib
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

if sys.platform == "win32":
    import msvcrt

    def _lock(number: int, _shared: bool) -> None:
        # A locked byte can't be read, so lock the last byte that `locking` allows, beyond any file's end.
        offset = os.lseek(number, 0, os.SEEK_CUR)
        os.lseek(number, (1 << 31) - 2, os.SEEK_SET)
        try:
            msvcrt.locking(number, msvcrt.LK_NBLCK, 1)
        finally:
            os.lseek(number, offset, os.SEEK_SET)

else:
    import fcntl

    def _lock(number: int, shared: bool) -> None:
        fcntl.flock(number, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)


NO_LINK = getattr(os, "O_NOFOLLOW", 0)
"""Flag of `open` that refuses symbolic links; 0 if the system lacks this flag."""

_NAME_BYTES = 200
"""Maximum bytes of a name before a prefix and suffix are added; file systems allow 255 bytes in total."""


def beside(path: Path, ending: str) -> Path:
    """Return a hidden path in the folder of a file; its name contains the file's name, or a hash of it.

    >>> beside(Path("out/tags.json"), "lock").name
    '.tags.json.lock'
    """
    name = os.fsencode(path.name)
    own_name = path.name if len(name) <= _NAME_BYTES else hashlib.sha256(name).hexdigest()
    return path.with_name(f".{own_name}.{ending}")


def could_lock(number: int, *, shared: bool = False) -> bool:
    """Lock an open file by its descriptor; return False if another process holds the lock.

    A file system without locks counts as success.
    """
    try:
        _lock(number, shared)
    except (BlockingIOError, PermissionError):  # from `flock`, and from `locking`
        return False
    except OSError:  # a file system without locks
        return True
    return True


def is_being_recorded(path: Path) -> bool:
    """Return whether a recorder has a file open; False if the system has no locks."""
    if not path.is_file():
        return False
    try:
        with path.open("rb") as file:
            return not could_lock(file.fileno(), shared=True)  # shared: others may test at the same time
    except OSError:  # reading it reports the error
        return False


@contextmanager
def held(path: Path) -> Iterator[None]:
    """Lock a file so that no other process replaces it; the file need not exist.

    Args:
        path: the file; processes that use another name for it, such as a link, do not see the lock.

    Raises:
        OSError: another process holds the lock, or the folder does not allow new files.
    """
    lock = beside(path, "lock")
    number = _locked(lock, path)
    try:
        yield
    finally:
        removed = _could_remove(lock)
        os.close(number)
        if not removed:  # Windows can't remove an open file
            _could_remove(lock)


def _could_remove(lock: Path) -> bool:
    """Remove a lock file; return False if the system refuses."""
    try:
        lock.unlink()
    except OSError:
        return False
    return True


def _locked(lock: Path, path: Path) -> int:
    """Open an empty lock file, and lock it; return its descriptor."""
    while True:
        number = os.open(lock, os.O_RDWR | os.O_CREAT | NO_LINK, 0o666)
        try:
            if os.fstat(number).st_size:
                raise OSError(errno.EEXIST, "it is not a lock file: move it away", str(lock))
            if not could_lock(number):
                raise OSError(errno.EBUSY, "another process is replacing it", str(path))
            if _is_still_there(lock, number):
                return number
        except OSError:
            os.close(number)
            raise
        os.close(number)  # the previous owner has just removed it


def _is_still_there(path: Path, number: int) -> bool:
    """Return whether a path still refers to an open file."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(number))
    except FileNotFoundError:
        return False
