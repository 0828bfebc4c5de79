"""Decides what of a trace may be read, and what may be run.

A file that came with a trace is judged by what will be done with it, not by what it is called.

    read      rack file in TOML, rungs, steps, stored program of a unit, retained tags: parsed as data
    run       rack file, program or stub in Python: it may do anything that its user may
    reached   everything else, once Python runs beside it: Python can import, load or open it

What is read needs no trust. The rest needs --trust, unless the current folder has an equal file.
Files without a use are not written out, so Python never searches a folder that holds them.
"""

from __future__ import annotations

import hashlib
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from enum import StrEnum
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from ...ladder.program import Form, program_form, split_address
from ..config.rackfile import RackFileError, parse_rack_file
from ..config.rackspec import RackSpec
from .loading import rack_form, stub_files


class UntrustedError(ValueError):
    """Python of a trace would run, and the user has not allowed it."""


class Use(StrEnum):
    """What a run does with a file of a trace."""

    READ = "read"
    RUN = "run"
    REACHED = "reached"


class Given(NamedTuple):
    """Which files a run starts from, by name.

    Attributes:
        rack: the rack file.
        program: the program; None if it is in the rack file, or not the trace's.
        retained: the tags that the program begins with; None if it begins with its own.
    """

    rack: str
    program: str | None
    retained: str | None = None


_BAD_PARTS = {
    "": "has an empty part",
    ".": "has a part '.'",
    "..": "leads out of its folder",
}
_BAD_NAMES = (
    (re.compile(r"/"), "leads out of its folder: it is absolute"),
    (re.compile(r".*\\"), "leads out of its folder where \\ separates folders"),
    (re.compile(r".*:"), "has a colon, which is a drive or a stream on Windows"),
    (re.compile(r".*[. ](/|$)"), "has a part that ends in a dot or a space, which Windows drops"),
    (
        re.compile(r"(.*/)?(con|prn|aux|nul|com\d|lpt\d)\s*(\.[^/]*)?(/|$)", re.IGNORECASE),
        "is a device on Windows",
    ),
)
"""What a name begins with, and why it is refused: on every system, so that a trace means the same on all."""


def checked_name(name: str) -> str:
    """Return the name of a file in a trace, if it names a file in the folder it is written to.

    Args:
        name: path from that folder, parts separated by `/`.

    Raises:
        ValueError: it may lead elsewhere, or names no file.
    """
    why = next(_objections(name), None)
    if why is not None:
        raise ValueError(f"{name!r} is refused as the name of a file: it {why}")
    return name


def _objections(name: str) -> Iterator[str]:
    """Yield why a name is refused."""
    if not name.isprintable():
        yield "has characters that can't be printed"
    yield from (why for pattern, why in _BAD_NAMES[:2] if pattern.match(name))
    yield from (_BAD_PARTS[part] for part in name.split("/") if part in _BAD_PARTS)
    yield from (why for pattern, why in _BAD_NAMES[2:] if pattern.match(name))


def check_names(names: Iterable[str]) -> None:
    """Refuse names of files that can't be written out side by side.

    Raises:
        ValueError: one leads elsewhere, or two are one file on a system that ignores case.
    """
    seen: dict[str, str] = {}
    for name in names:
        key = unicodedata.normalize("NFKC", checked_name(name)).casefold()
        if key in seen:
            raise ValueError(f"the trace brings {seen[key]!r} and {name!r}, which may be one file")
        seen[key] = name


def admitted(files: Mapping[str, bytes], given: Given, *, trust: bool) -> dict[str, bytes]:
    """Return the files that a run needs, if they may be used.

    Args:
        files: all files of the trace, by name.
        given: which of them the run starts from.
        trust: the reader lets Python of the trace run.

    Raises:
        UntrustedError: Python of the trace would run.
        ValueError: a name is refused, a file is missing, or the rack file names one elsewhere.
    """
    uses = uses_of(files, given)
    check_names(uses)
    for name in uses:
        if name not in files:
            raise ValueError(f"the trace does not bring {name}, which its run needs")
    wanted = {name: files[name] for name in uses}
    if not trust:
        _check_trust({name: data for name, data in wanted.items() if uses[name] is not Use.READ})
    return wanted


def uses_of(files: Mapping[str, bytes], given: Given) -> dict[str, Use]:
    """Return what a run does with which files of a trace.

    Raises:
        ValueError: rack file or program can't be one.
    """
    forms = {given.rack: rack_form(PurePosixPath(checked_name(given.rack)))}
    if given.program is not None:
        forms[given.program] = program_form(PurePosixPath(checked_name(given.program)))
    named: list[str] = []
    if forms[given.rack] is Form.DATA:
        named, stubs = _named_in_rack(files, given.rack)
        forms.update(dict.fromkeys(stubs, Form.PYTHON))
    python = Form.PYTHON in forms.values()
    if given.retained is not None:
        named.append(checked_name(given.retained))
    uses = dict.fromkeys([*files, *named], Use.REACHED) if python else dict.fromkeys(named, Use.READ)
    return uses | {name: Use.RUN if form is Form.PYTHON else Use.READ for name, form in forms.items()}


def _named_in_rack(files: Mapping[str, bytes], rack: str) -> tuple[list[str], list[str]]:
    """Return the stored programs that a rack file in TOML names, and the Python files of its stubs."""
    if rack not in files:
        return [], []
    try:
        text = files[rack].decode("utf-8")
    except UnicodeDecodeError as error:
        raise RackFileError(f"{rack}: the rack file is not text in UTF-8: {error.reason}") from None
    spec = parse_rack_file(text, Path(rack)).spec
    folder = PurePosixPath(rack).parent
    stubs = [checked_name(str(PurePosixPath(name))) for name in stub_files(spec)]
    return [f"{folder / name}" for name in stored_programs(spec)], [f"{folder / name}" for name in stubs]


def stored_programs(spec: RackSpec) -> list[str]:
    """Return the paths of the units' programs in a rack that is not the user's, each once.

    Raises:
        ValueError: one leads out of the folder of the rack file.
    """
    paths = [PurePosixPath(unit.program) for unit in spec.unit if unit.program is not None]
    return list(dict.fromkeys(checked_name(str(path)) for path in paths))


def _check_trust(files: Mapping[str, bytes]) -> None:
    """Refuse files that the current folder does not have."""
    foreign = {name: data for name, data in files.items() if not _is_own(name, data)}
    if foreign:
        listed = "\n".join(f"  {line}" for line in fingerprints(foreign))
        raise UntrustedError(
            "this would run Python that came with the trace, which may do anything that you may:\n"
            f"{listed}\n"
            "read these files (scanrack show TRACE --extract FOLDER), then say --trust"
        )


def fingerprints(files: Mapping[str, bytes]) -> list[str]:
    """Return a line for every file: name, size, SHA-256."""
    width = max(map(len, files), default=0)
    return [
        f"{name:<{width}}  {len(data):>9,} bytes  SHA-256 {hashlib.sha256(data).hexdigest()}"
        for name, data in files.items()
    ]


def _is_own(name: str, data: bytes) -> bool:
    """Whether the current folder has the same file under the same name."""
    path = Path(name)
    return path.is_file() and path.read_bytes() == data


def address_name(address: str) -> str:
    """Return the file in an address `path[:function]` of a trace's metadata."""
    return checked_name(split_address(address)[0])
