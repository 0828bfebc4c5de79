"""Files as Windows has them: no open file is removed or renamed, and text has line ends of two characters.

In force for the whole process, libraries included. Case, drives and separators stay those of this system.
"""

from __future__ import annotations

import builtins
import io
import os
import shutil
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

CODE_PAGE = "cp1252"
"""Of text files and pipes whose encoding is not given."""

NO_CHARACTER = frozenset('<>:"|?*\\') | {chr(number) for number in range(32)}

RESERVED = {"con", "prn", "aux", "nul"} | {
    f"{port}{digit}" for port in ("com", "lpt") for digit in "123456789"
}

Path_ = str | bytes | os.PathLike[str] | os.PathLike[bytes]


def is_name(name: str) -> bool:
    """Return whether a file can have a name.

    >>> [is_name(each) for each in ("a.mcap", "nul.mcap", "COM3", "COM10", "a:b", "end.")]
    [True, False, False, True, False, False]
    """
    device = name.partition(".")[0].rstrip().lower()
    return not NO_CHARACTER & set(name) and name[-1] not in ". " and device not in RESERVED


def check_name(path: Path_) -> None:
    """Refuse a path with a part that no file can be named; those of devices of this system are left alone."""
    parts = Path(os.fsdecode(path)).parts
    if parts[:2] in (("/", "dev"), ("/", "proc"), ("/", "sys")):
        return
    if not all(is_name(each) for each in parts if each not in ("/", "..")):
        raise OSError(22, "Invalid argument", os.fsdecode(path))


def users(path: Path_) -> list[int]:
    """Return the processes that have a file open, or a folder as their current one."""
    try:
        wanted = os.path.realpath(os.fsdecode(path), strict=True)
    except OSError:
        return []
    return [int(each) for each in os.listdir("/proc") if each.isdigit() and wanted in _open_in(each)]


def _open_in(process: str) -> set[str]:
    """Return the files that a process has open; none of a process that has ended, or is another user's."""
    found = set()
    with suppress(OSError):  # it has ended, or is another user's
        for link in (f"/proc/{process}/cwd", *(each.path for each in os.scandir(f"/proc/{process}/fd"))):
            with suppress(OSError):  # closed meanwhile, as the listing itself
                found.add(os.readlink(link))
    return found


def check_unused(path: Path_, *, is_source: bool = True) -> None:
    """Refuse what an open file does not allow."""
    if (is_source or not os.path.islink(path)) and (by := users(path)):
        text = f"The process cannot access the file because it is being used by another process {by}"
        raise PermissionError(13, text, os.fsdecode(path))


def _moving(real: Callable[..., None], *, over: bool) -> Callable[..., None]:
    def move(source: Path_, target: Path_, **options: Any) -> None:
        check_name(target)
        check_unused(source)
        if over:
            check_unused(target, is_source=False)
        elif os.path.lexists(target):
            raise FileExistsError(17, "Cannot create a file when that file already exists", target)
        real(source, target, **options)

    return move


def _removing(real: Callable[..., None]) -> Callable[..., None]:
    def remove(path: Path_, **options: Any) -> None:
        check_unused(path)
        real(path, **options)

    return remove


def _opening(real: Callable[..., int]) -> Callable[..., int]:
    def open_file(path: Path_, flags: int, *more: Any, **options: Any) -> int:
        if "dir_fd" not in options and not flags & os.O_TMPFILE and os.path.isdir(path):
            raise PermissionError(13, "Permission denied", os.fsdecode(path))
        if flags & os.O_CREAT:
            check_name(path)
        return real(path, flags, *more, **options)

    return open_file


def _opening_text(real: Callable[..., Any]) -> Callable[..., Any]:
    def open_file(
        file: Path_ | int,
        mode: str = "r",
        buffering: int = -1,
        encoding: str | None = None,
        errors: str | None = None,
        newline: str | None = None,
        *more: Any,
        **options: Any,
    ) -> Any:
        writes = bool(set(mode) & set("wax+"))
        if writes and not isinstance(file, int):
            check_name(file)
        if "b" not in mode:
            if encoding in (None, "locale"):
                encoding = CODE_PAGE
                if _caller().startswith("scanrack"):
                    raise EncodingWarning(f"{file!r}: a text file whose encoding is not given")
            newline = "\r\n" if writes and newline is None else newline
        return real(file, mode, buffering, encoding, errors, newline, *more, **options)

    return open_file


def _caller() -> str:
    """Return the module that opens a file, which Python's own functions may do for it."""
    frame = sys._getframe(2)
    while frame.f_back is not None and frame.f_globals["__name__"].partition(".")[0] in ("pathlib", "os"):
        frame = frame.f_back
    return str(frame.f_globals["__name__"])


def take_files_of_linux() -> None:
    """Let the files of this process be those of Windows, from now on."""
    assert sys.platform == "linux", "what is open is read from /proc"
    shutil._use_fd_functions = False  # type: ignore[attr-defined]  # Windows has no files relative to others
    os.replace, os.rename = _moving(os.replace, over=True), _moving(os.rename, over=False)
    os.unlink = os.remove = _removing(os.unlink)
    os.rmdir = _removing(os.rmdir)
    os.open = _opening(os.open)
    io.open = builtins.open = _opening_text(io.open)


def _generated(code: CodeType) -> CodeType:
    """Return code that no search for a program's code finds in this file."""
    inner = [_generated(each) if isinstance(each, CodeType) else each for each in code.co_consts]
    return code.replace(co_filename="<windows_files>", co_consts=tuple(inner))


for _each in [*globals().values()]:
    if isinstance(_each, FunctionType) and _each.__module__ == __name__:
        _each.__code__ = _generated(_each.__code__)
