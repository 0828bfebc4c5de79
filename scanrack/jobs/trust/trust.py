"""Decides which files of a trace may be read, and which may be run.

A file is judged by its use, not by its name.

    read      rack file in TOML, rungs, steps, stored program of a unit, retained tags, panel: parsed as data
    run       rack file, program or stub in Python: it runs with all rights of the user
    reached   everything else, once Python runs beside it: Python can import, load or open it

Files that are only read need no trust. All others need --trust, unless the current folder has an equal file.
Files without a use are not written out, so Python never searches a folder that contains them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from scanrack.runtime.config.rackfile import RackFileError, parse_rack_file
from scanrack.runtime.config.rackspec import RackSpec

from ..load.loading import rack_form, racks_beside, stub_files
from ..load.panels import panel_name
from ..load.program import Form, program_form, split_address
from .extracting import check_names, checked_name


class UntrustedError(ValueError):
    """Python of a trace would run, but the user has not allowed it."""


class Use(StrEnum):
    """The use of a trace's file in a run."""

    READ = "read"
    RUN = "run"
    REACHED = "reached"


class RunFiles(NamedTuple):
    """Names of the files from which a run starts."""

    rack: str
    program: str | None  # None if the rack file contains it, or it is not from the trace
    retained: str | None = None  # the initial tags of the program; None = the program's own


def admitted(files: Mapping[str, bytes], given: RunFiles, *, trust: bool) -> dict[str, bytes]:
    """Check that a run's files may be used; return the files that it needs.

    Args:
        files: all files of the trace, by name.
        given: names of the files from which the run starts.
        trust: whether the user lets Python of the trace run.

    Raises:
        UntrustedError: untrusted Python of the trace would run.
        ValueError: a name is refused, a file is missing, or the rack file names a file elsewhere.
    """
    uses = uses_of(files, given)
    check_names(uses)
    for name in uses:
        if name not in files:
            raise ValueError(f"the trace does not bring {name}, which its run needs")
    used = {name: files[name] for name in uses}
    if not trust:
        _check_trust({name: data for name, data in used.items() if uses[name] is not Use.READ})
    return used


def uses_of(files: Mapping[str, bytes], given: RunFiles) -> dict[str, Use]:
    """Return the uses of a trace's files in a run; raise ValueError for an unusable rack file or program."""
    forms = {given.rack: rack_form(PurePosixPath(checked_name(given.rack)))}
    if given.program is not None:
        forms[given.program] = program_form(PurePosixPath(checked_name(given.program)))
    named: list[str] = []
    if forms[given.rack] is Form.DATA:
        named, others = _named_in_rack(files, given.rack, {given.rack})
        forms.update(others)
    named += [name for name in [panel_name(given.rack)] if name in files]
    python = Form.PYTHON in forms.values()
    if given.retained is not None:
        named.append(checked_name(given.retained))
    uses = dict.fromkeys([*files, *named], Use.REACHED) if python else dict.fromkeys(named, Use.READ)
    return uses | {name: Use.RUN if form is Form.PYTHON else Use.READ for name, form in forms.items()}


def _named_in_rack(
    files: Mapping[str, bytes], rack: str, seen: set[str]
) -> tuple[list[str], dict[str, Form]]:
    """Return the stored programs that a TOML rack file names, and its Python stubs and other racks.

    Args:
        seen: names of rack files that have already been read.
    """
    if rack not in files:
        return [], {}
    spec = _rack_in(files, rack)
    folder = PurePosixPath(rack).parent
    named = [f"{folder / name}" for name in stored_programs(spec)]
    stubs = (checked_name(str(PurePosixPath(name))) for name in stub_files(spec))
    forms = {f"{folder / name}": Form.PYTHON for name in stubs}
    for path in racks_beside(spec):
        other = checked_name(f"{folder / path}")
        if other in seen:
            continue
        seen.add(other)
        forms[other] = rack_form(PurePosixPath(other))
        if forms[other] is Form.DATA and other in files:
            program = split_address(str(_rack_in(files, other).program))[0]
            place = checked_name(f"{PurePosixPath(other).parent / program}")
            forms[place] = program_form(PurePosixPath(place))
            nested, others = _named_in_rack(files, other, seen)
            named += nested
            forms |= others
    return named, forms


def _rack_in(files: Mapping[str, bytes], rack: str) -> RackSpec:
    try:
        text = files[rack].decode("utf-8")
    except UnicodeDecodeError as error:
        raise RackFileError(f"{rack}: the rack file is not text in UTF-8: {error.reason}") from None
    return parse_rack_file(text, Path(rack)).spec


def stored_programs(spec: RackSpec) -> list[str]:
    """Return the paths of the units' programs in a rack from elsewhere, each once.

    Raises:
        ValueError: a path leads out of the rack file's folder.
    """
    paths = [PurePosixPath(unit.program) for unit in spec.unit if unit.program is not None]
    return list(dict.fromkeys(checked_name(str(path)) for path in paths))


def _check_trust(files: Mapping[str, bytes]) -> None:
    """Raise UntrustedError if the current folder lacks one of the files."""
    foreign = {name: data for name, data in files.items() if not _is_own(name, data)}
    if foreign:
        fingerprints_text = "\n".join(f"  {line}" for line in fingerprints(foreign))
        raise UntrustedError(
            "this would run Python that came with the trace, which may do anything that you may:\n"
            f"{fingerprints_text}\n"
            "read these files (scanrack show TRACE --extract FOLDER), then say --trust"
        )


def fingerprints(files: Mapping[str, bytes]) -> list[str]:
    """Return a line for each file: name, size, SHA-256."""
    width = max(map(len, files), default=0)
    return [
        f"{name:<{width}}  {len(data):>9,} bytes  SHA-256 {hashlib.sha256(data).hexdigest()}"
        for name, data in files.items()
    ]


def _is_own(name: str, data: bytes) -> bool:
    """Return whether the current folder has the same file under the same name."""
    path = Path(name)
    return path.is_file() and path.read_bytes() == data


def address_name(address: str) -> str:
    """Return the file name in an address `path[:function]` of a trace's metadata."""
    return checked_name(split_address(address)[0])
