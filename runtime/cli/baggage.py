"""The files that travel with a trace: what a run was made of, on the way in and out again.

rack file and program      by the metadata's `rack_file` and `program_file`, path[:function]
what the program imports   Python files beside it, by their path from there
words.json                 the map of words and bits, which a run does not need
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath

from ...ladder.program import split_address
from ...traces.reader import Trace
from ...traces.recorder import Attachment
from ..rackspec import RackSpec
from .loading import Job, load_job, load_spec

PYTHON = ".py"
_NOT_OF_THE_RUN = "words.json"


class UntrustedError(ValueError):
    """A trace brings Python that nobody has said is to be run."""


def attachment(path: Path, name: str) -> Attachment:
    """Return a file as an attachment."""
    return Attachment(name, path.read_bytes(), "text/x-python" if path.suffix == PYTHON else "text/plain")


def program_name(job: Job) -> str:
    """Return what the program's file is called in a trace: not as the rack file is."""
    name = job.program.name
    same = name == job.rack_file.name and job.program != job.rack_file
    return f"program/{name}" if same else name


def made_by(job: Job) -> dict[str, str]:
    """Return the metadata that tell which of the files are rack file and program."""
    name = program_name(job)
    if job.program.suffix == PYTHON:
        name = f"{name}:{job.logic_name.rpartition(':')[2]}"
    return {"rack_file": job.rack_name, "program_file": name}


def imported(job: Job) -> list[Attachment]:
    """Return the Python files beside rack file and program that have been imported, in order of their paths.

    What a program imports later, while it runs, is not known yet.
    """
    given = [path.resolve() for path in (job.rack_file, job.program)]
    found: dict[str, Path] = {}
    for own in given:
        if own.suffix == PYTHON:
            found.update(_imported_from(own.parent))
    return [attachment(found[name], name) for name in sorted(found) if found[name] not in given]


def unit_programs(job: Job) -> list[Attachment]:
    """Return the stored programs of the units beside the rack, each once, in the order of the units."""
    names = dict.fromkeys(unit.program for unit in job.spec.unit if unit.program is not None)
    return [attachment(job.folder / name, name) for name in names]


def forget_imported(folder: Path) -> None:
    """Have modules that were imported from a folder imported anew: whoever needs them finds none.

    Args:
        folder: an absolute path without symbolic links.
    """
    ours = __name__.partition(".")[0]
    for name, _place, _path in _modules_of(folder):
        if name.partition(".")[0] != ours:
            del sys.modules[name]


def _imported_from(folder: Path) -> Iterator[tuple[str, Path]]:
    """Yield imported files of modules that lie in a folder, by their path from there."""
    for _name, place, path in _modules_of(folder):
        yield place.as_posix(), path


def _modules_of(folder: Path) -> Iterator[tuple[str, Path, Path]]:
    """Yield the modules that have been imported from a folder: name, path from there, whole path."""
    inside = f"{folder}{os.sep}"
    for name, module in list(sys.modules.items()):
        file = getattr(module, "__file__", None) or ""
        if file.startswith(inside) and file.endswith(PYTHON):
            path = Path(file)
            place = path.relative_to(folder)
            if place.with_suffix("").parts[0] == name.partition(".")[0]:
                yield name, place, path


def attached_files(trace: Trace) -> dict[str, bytes]:
    """Return the files that came with a trace, by name."""
    return {each.name: each.data for each in trace.attachments()}


def extract(files: Mapping[str, bytes], folder: Path) -> list[Path]:
    """Write files into a folder, which is made if need be; return where they are.

    Raises:
        ValueError: a name leads out of the folder, or another file is there already.
        OSError: one can't be written.
    """
    targets = {folder / _checked(name): data for name, data in files.items()}
    for target, data in targets.items():
        if target.exists() and (not target.is_file() or target.read_bytes() != data):
            raise ValueError(f"{target} is there already, with something else in it: choose another folder")
    for target, data in targets.items():
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data)
    return list(targets)


def job_of(trace: Trace, folder: Path, *, trust: bool, program: str | None = None) -> Job:
    """Load what a trace was made by.

    Args:
        trace: the trace.
        folder: where its files are written.
        trust: run Python that came with it; without, only what is the same as in the current folder.
        program: a program of the user's in place of the trace's, `path[:function]`.

    Raises:
        UntrustedError: Python of the trace would be run.
        ValueError: the trace does not say what it was made by, or one of the files can't be used.
    """
    rack = _recorded(trace, "rack_file")
    own = _recorded(trace, "program_file") if program is None else rack
    _take_out(trace, folder, [rack, own], trust=trust)
    if program is None and split_address(own)[0] != split_address(rack)[0]:
        program = f"{folder / own}"
    return load_job(f"{folder / rack}", program)


def spec_of(trace: Trace, folder: Path, *, trust: bool) -> RackSpec:
    """Load the rack that a trace was made on, without its program; see `job_of`."""
    rack = _recorded(trace, "rack_file")
    _take_out(trace, folder, [rack], trust=trust)
    return load_spec(f"{folder / rack}")[0]


def _recorded(trace: Trace, key: str) -> str:
    """Return what the metadata tell of a file."""
    address = trace.head.metadata.get(key)
    if address is None:
        what = key.replace("_", " ")
        raise ValueError(f"the trace does not say what its {what} is: it can't be run without one")
    return _checked(address)


def _take_out(trace: Trace, folder: Path, run: Sequence[str], *, trust: bool) -> None:
    """Write the files of a trace into a folder, once it is known that these may be run."""
    files = {name: data for name, data in attached_files(trace).items() if name != _NOT_OF_THE_RUN}
    if not trust and any(split_address(address)[0].endswith(PYTHON) for address in run):
        _check_trust(files)
    extract(files, folder)


def _check_trust(files: Mapping[str, bytes]) -> None:
    """Refuse Python files that are not the same as those in the current folder."""
    foreign = [name for name, data in files.items() if name.endswith(PYTHON) and not _is_here(name, data)]
    if foreign:
        raise UntrustedError(
            f"this would run Python that came with the trace ({', '.join(foreign)}), which may do anything: "
            "read it (scanrack show TRACE --extract FOLDER), then say --trust"
        )


def _is_here(name: str, data: bytes) -> bool:
    path = Path(_checked(name))
    return path.is_file() and path.read_bytes() == data


def _checked(name: str) -> str:
    """Return a name that stays in its folder, and refuse any other."""
    path = PurePosixPath(name)
    if path.is_absolute() or not path.parts or ".." in path.parts or "\\" in name:
        raise ValueError(f"the trace brings a file named {name!r}, which leads out of its folder")
    return name
