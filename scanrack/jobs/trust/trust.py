"""Decides which files of a trace may be read, and which may be run.

A file is judged by its use, not by its name.

    read      rack file in TOML, rungs, steps, stored program of a unit, retained tags, panel: parsed as data
    run       rack file, program or stub in Python: it runs with all of the user's rights
    reached   any other file, if Python runs: it can import, load or open the file

Files that are only read need no trust. All others need --trust, unless the current folder has the same file.
Files that the run does not use are not extracted, so that Python never searches a folder with them.
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
    """Python in a trace would run, but the user has not allowed it."""


class FileUse(StrEnum):
    """How a run uses a file from a trace."""

    READ = "read"
    RUN = "run"
    REACHED = "reached"


class RunFiles(NamedTuple):
    """Names of the files from which a run starts."""

    rack: str
    program: str | None  # None if the rack file contains it, or it is not from the trace
    retained: str | None = None  # the file with initial values of tags; None = the program's initial values


def admitted(files: Mapping[str, bytes], run_files: RunFiles, *, trust: bool) -> dict[str, bytes]:
    """Check that a run's files may be used; return the files that it needs.

    Args:
        files: all files of the trace, by name.
        run_files: names of the files from which the run starts.
        trust: whether the user allows Python in the trace to run.

    Raises:
        UntrustedError: untrusted Python in the trace would run.
        ValueError: a name is refused, a file is missing, or the rack file names a file elsewhere.
    """
    uses = uses_of(files, run_files)
    check_names(uses)
    for name in uses:
        if name not in files:
            raise ValueError(f"the trace has no file {name}, which its run needs")
    used = {name: files[name] for name in uses}
    if not trust:
        _check_trust({name: data for name, data in used.items() if uses[name] is not FileUse.READ})
    return used


def uses_of(files: Mapping[str, bytes], run_files: RunFiles) -> dict[str, FileUse]:
    """Return the uses of a trace's files in a run; raise ValueError for an unusable rack file or program."""
    rack, program, retained = run_files
    forms = {rack: rack_form(PurePosixPath(checked_name(rack)))}
    if program is not None:
        forms[program] = program_form(PurePosixPath(checked_name(program)))
    data_names: list[str] = []
    if forms[rack] is Form.DATA:
        data_names, other_forms = _named_in_rack(files, rack, {rack})
        forms.update(other_forms)
    panel = panel_name(rack)
    if panel in files:
        data_names.append(panel)
    if retained is not None:
        data_names.append(checked_name(retained))
    if Form.PYTHON in forms.values():  # Python can open any file
        uses = dict.fromkeys([*files, *data_names], FileUse.REACHED)
    else:
        uses = dict.fromkeys(data_names, FileUse.READ)
    return uses | {name: FileUse.RUN if form is Form.PYTHON else FileUse.READ for name, form in forms.items()}


def _named_in_rack(
    files: Mapping[str, bytes], rack: str, visited_racks: set[str]
) -> tuple[list[str], dict[str, Form]]:
    """Return the files that a TOML rack file names.

    Args:
        visited_racks: names of rack files that have already been read.

    Returns:
        The stored programs of its devices; and the Python stubs, the linked racks and their programs, with
        their forms.
    """
    if rack not in files:
        return [], {}
    spec = _rack_in(files, rack)
    folder = PurePosixPath(rack).parent
    data_names = [f"{folder / name}" for name in stored_programs(spec)]
    stubs = (checked_name(str(PurePosixPath(name))) for name in stub_files(spec))
    forms = {f"{folder / name}": Form.PYTHON for name in stubs}
    for path in racks_beside(spec):
        linked_rack = checked_name(f"{folder / path}")
        if linked_rack in visited_racks:
            continue
        visited_racks.add(linked_rack)
        forms[linked_rack] = rack_form(PurePosixPath(linked_rack))
        if forms[linked_rack] is Form.DATA and linked_rack in files:
            program, _ = split_address(str(_rack_in(files, linked_rack).program))
            program_name = checked_name(f"{PurePosixPath(linked_rack).parent / program}")
            forms[program_name] = program_form(PurePosixPath(program_name))
            linked_data_names, linked_forms = _named_in_rack(files, linked_rack, visited_racks)
            data_names += linked_data_names
            forms |= linked_forms
    return data_names, forms


def _rack_in(files: Mapping[str, bytes], rack: str) -> RackSpec:
    """Return the contents of a TOML rack file in a trace; raise ValueError if they are unusable."""
    try:
        text = files[rack].decode("utf-8")
    except UnicodeDecodeError as error:
        raise RackFileError(f"{rack}: the rack file is not UTF-8 text: {error.reason}") from None
    return parse_rack_file(text, Path(rack)).spec


def stored_programs(spec: RackSpec) -> list[str]:
    """Return the paths of the devices' stored programs in an untrusted rack, without duplicates.

    Raises:
        ValueError: a path leads out of the rack file's folder.
    """
    paths = [PurePosixPath(unit.program) for unit in spec.unit if unit.program is not None]
    return list(dict.fromkeys(checked_name(str(path)) for path in paths))


def _check_trust(files: Mapping[str, bytes]) -> None:
    """Raise UntrustedError if the current folder lacks one of the files."""
    foreign = {name: data for name, data in files.items() if not _is_own(name, data)}
    if foreign:
        fingerprint_lines = "\n".join(f"  {line}" for line in fingerprints(foreign))
        raise UntrustedError(
            "this would run Python that came with the trace, with all your rights:\n"
            f"{fingerprint_lines}\n"
            "read these files (scanrack show TRACE --extract FOLDER), then add --trust"
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
    """Return the file name from an address, `path[:function]`, in a trace's metadata."""
    return checked_name(split_address(address)[0])
