"""Attaches the files of a job to a recording, and extracts them again.

rack file and program      named by the metadata `rack_file` and `program_file`, path[:function]
retained tags              named by the metadata `retained_file`: initial tags of a ladder program
stubs in Python            named by the rack file's `[stubs]`
imports of the program     Python files beside it, by their relative paths
operator panel             beside the rack file, under its name: pages show it
words.json, tags.json      the maps of words and of recorded tags, which a run does not need
snapshots.txt.zst          values of a ladder program, from which questions begin
edit-1/...                 rack file and program after an edit during the run, see `editions`

`trust` decides which of them may be used.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Iterable, Iterator
from dataclasses import replace
from importlib.machinery import all_suffixes
from pathlib import Path, PurePosixPath, PureWindowsPath
from types import ModuleType
from typing import TYPE_CHECKING

from scanrack.io_images.input_files import open_input
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.traces.files.portable import relative
from scanrack.traces.format.snapshots import SNAPSHOTS
from scanrack.traces.write.recorder import Attachment

from ..load.loading import LoadedRack, load_job, load_spec, rack_form
from ..load.panels import panel_name
from ..load.program import Form
from ..load.retaining import retaining
from ..load.rungs import is_rungs
from .extracting import attached_files, extract
from .trust import RunFiles, address_name, admitted

if TYPE_CHECKING:  # a run does not read recordings
    from scanrack.traces.read.reader import Trace

PYTHON = ".py"
RETAINED = "retained/tags.json"
"""Name of the file of retained tags in a trace."""

_NOT_OF_THE_RUN = ("words.json", "tags.json", SNAPSHOTS)


def attachment(name: str, data: bytes) -> Attachment:
    """Return a file as an attachment."""
    return Attachment(name, data, "text/x-python" if name.endswith(PYTHON) else "text/plain")


def program_name(job: LoadedRack) -> str:
    """Return the program's file name in a trace; it differs from the rack file's name."""
    name = job.program.name
    same = name == job.rack_file.name and job.program != job.rack_file
    return f"program/{name}" if same else name


def made_by(job: LoadedRack) -> dict[str, str]:
    """Return the metadata that name the rack file, program and retained tags."""
    name = program_name(job)
    if job.program.suffix == PYTHON:
        name = f"{name}:{job.logic_name.rpartition(':')[2]}"
    own = {} if job.retained is None else {"retained_file": RETAINED}
    return {"rack_file": job.rack_name, "program_file": name, **own}


def files_of(job: LoadedRack) -> dict[str, Path]:
    """Return the files from which a job is loaded, by name in a trace, except the retained tags."""
    rack = {} if job.rack_file == job.program else {job.rack_file.name: job.rack_file}
    return {program_name(job): job.program, **rack, **files_beside(job)}


def files_beside(job: LoadedRack) -> dict[str, Path]:
    """Return a job's other files: modules, stubs, unit programs, panel, and other racks in the folder."""
    panel = Path(panel_name(str(job.rack_file)))
    shown = {panel.name: panel} if _is_input(panel) else {}
    return {**_imported(job), **_stub_functions(job), **_unit_programs(job), **_racks_beside(job), **shown}


def _is_input(path: Path) -> bool:
    """Return whether a file may be attached; a link to another kind of file, such as a key, may not."""
    try:
        open_input(path).close()
    except OSError:
        return False
    return True


def _racks_beside(job: LoadedRack) -> dict[str, Path]:
    """Return the files of other racks in this rack's folder, by path relative to it."""
    files: dict[str, Path] = {}
    for rack in job.world.others if job.world is not None else ():
        other: LoadedRack = rack.job
        program = relative(other.program, other.folder)
        named = {other.rack_file.name: other.rack_file, program: other.program}
        named |= {**_imported(other), **_stub_functions(other), **_unit_programs(other)}
        folder = relative(other.folder, job.folder)
        files_inside = {name: path for name, path in named.items() if not _leads_out(name)}
        files |= {PurePosixPath(folder, name).as_posix(): path for name, path in files_inside.items()}
    return {name: path for name, path in files.items() if not _leads_out(name)}


def _leads_out(name: str) -> bool:
    """Return whether a path leads out of its folder on any system, including to another Windows drive."""
    path = PureWindowsPath(name)
    return bool(path.anchor) or ".." in path.parts


def _imported(job: LoadedRack) -> dict[str, Path]:
    """Return the imported Python files beside rack file and program, sorted by path.

    Later imports by a running program are not included.
    """
    stubs = [(job.folder / path, Path(path).as_posix()) for path in job.stub_files]
    roots = [(job.rack_file, job.rack_file.name), (job.program, program_name(job)), *stubs]
    main_files = [path.resolve() for path, _ in roots]
    names = [PurePosixPath(name) for _, name in roots]
    files: dict[str, Path] = {}
    for own, name in zip(main_files, names, strict=True):
        if own.suffix == PYTHON:
            files.update((f"{name.parent / place}", path) for _, place, path in _modules_of(own.parent))
    return {name: files[name] for name in sorted(files) if files[name] not in main_files}


def _unit_programs(job: LoadedRack) -> dict[str, Path]:
    """Return the stored programs of the rack's units, each once, in the order of the units."""
    paths = dict.fromkeys(Path(unit.program) for unit in job.spec.unit if unit.program is not None)
    return {path.as_posix(): job.folder / path for path in paths}


def _stub_functions(job: LoadedRack) -> dict[str, Path]:
    """Return the Python files of stubs, each once, except the program."""
    excluded = (job.rack_file.resolve(), job.program.resolve())
    paths = [Path(stub_path) for stub_path in job.stub_files]
    return {
        path.as_posix(): job.folder / path for path in paths if (job.folder / path).resolve() not in excluded
    }


def retained_tags(job: LoadedRack) -> list[Attachment]:
    """Return the file of the ladder program's initial tags, if there is one."""
    return [] if job.retained is None else [Attachment(RETAINED, job.retained, "application/json")]


def forget_imported(folder: Path) -> None:
    """Drop the modules of a folder from `sys.modules`.

    Args:
        folder: an absolute path without symbolic links.
    """
    package = __name__.partition(".")[0]
    for name, _place, _path in _modules_of(folder):
        if name.partition(".")[0] != package:
            del sys.modules[name]


def _modules_of(folder: Path) -> Iterator[tuple[str, Path, Path]]:
    """Yield the imported modules of a folder: name, relative path, full path."""
    prefix = f"{folder}{os.sep}"
    modules = list(sys.modules.items())
    packages = {name for name, module in modules if "." not in name and _may_be_below(prefix, name, module)}
    for name, module in modules if packages else ():  # must be fast: a search calls this before each run
        top = name.partition(".")[0]
        if top not in packages:
            continue
        file = getattr(module, "__file__", None) or ""
        if file.startswith(prefix) and file.endswith(PYTHON):
            path = Path(file)
            place = path.relative_to(folder)
            if place.with_suffix("").parts[0] == top:
                yield name, place, path


def _may_be_below(prefix: str, name: str, module: ModuleType) -> bool:
    """Return whether a top-level module may be in a folder, whose files begin with `prefix`."""
    file: str | None = getattr(module, "__file__", None)
    if not file:  # a package without a file of its own is located by its path
        return any(str(path).startswith(prefix) for path in getattr(module, "__path__", ()))
    return file.startswith(prefix) and file.startswith(name, len(prefix))


def job_of(trace: Trace, folder: Path, *, trust: bool, program: str | None = None) -> LoadedRack:
    """Load the rack and the program that made a trace.

    Args:
        trust: run any Python of the trace; otherwise only files that equal those in the current folder.
        program: the user's program instead of the trace's, `path[:function]`. A ladder program begins with
            the trace's retained tags, as far as it has them.

    Raises:
        UntrustedError: untrusted Python of the trace would be run.
        ValueError: the trace does not name its files, or one of them can't be used.
    """
    rack = _recorded(trace, "rack_file")
    own = None if program is not None else own_program(rack, _recorded(trace, "program_file"))
    retained = trace.head.metadata.get("retained_file")
    _take_out(trace, folder, rack, own, trust=trust, retained=retained)
    job = load_job(f"{folder / rack}", program if own is None else f"{folder / own}")
    if retained is not None and (program is None or is_rungs(job.logic)):
        job, _ = retaining(job, (folder / retained).read_bytes(), retained)
    return replace(job, spec=_of_trace(job.spec))


def spec_of(trace: Trace, folder: Path, *, trust: bool) -> RackSpec:
    """Load the rack on which a trace was recorded, without its program; see `job_of`."""
    rack = _recorded(trace, "rack_file")
    _take_out(trace, folder, rack, None, trust=trust)
    return _of_trace(load_spec(f"{folder / rack}")[0])


def _recorded(trace: Trace, key: str) -> str:
    """Return a metadata entry that names a file, `path[:function]`."""
    address = trace.head.metadata.get(key)
    if address is None:
        subject = key.replace("_", " ")
        raise ValueError(f"the trace does not say what its {subject} is: it can't be run without one")
    return address


def own_program(rack: str, program: str) -> str | None:
    """Return the address of a trace's program; None if it is the same as the Python rack file."""
    name = address_name(rack)
    same = name == address_name(program) and rack_form(PurePosixPath(name)) is Form.PYTHON
    return None if same else program


def load_files(folder: Path, rack: str, program: str) -> LoadedRack:
    """Load a rack and its program from a trace's files in a folder.

    Args:
        rack: the rack file in the folder, `path[:function]`.
        program: the program in the folder, `path[:function]`.

    Raises:
        ValueError: one of the files can't be used.
    """
    own = own_program(rack, program)
    return load_job(f"{folder / rack}", None if own is None else f"{folder / own}")


def folder_of_edit(number: int) -> str:
    """Return the folder of an edit's files in a trace.

    >>> folder_of_edit(1)
    'edit-1/'
    """
    return f"edit-{number}/"


def edit_number(name: str) -> int:
    """Return the number of the edit to which a file belongs; 0 = none.

    >>> edit_number("edit-1/feeder.rung"), edit_number("feeder.rung")
    (1, 0)
    """
    match = _OF_AN_EDIT.match(name)
    return 0 if match is None else int(match[1])


_OF_AN_EDIT = re.compile(r"edit-(\d{1,9})/")


def _take_out(
    trace: Trace, folder: Path, rack: str, program: str | None, *, trust: bool, retained: str | None = None
) -> None:
    """Check that the files of a run may be used, and write them into a folder."""
    trace.check_data()
    files = {
        name: data
        for name, data in attached_files(trace).items()
        if name not in _NOT_OF_THE_RUN and not edit_number(name)
    }
    run_files = RunFiles(address_name(rack), None if program is None else address_name(program), retained)
    trusted = admitted(files, run_files, trust=trust)
    _check_alone(folder, trusted)
    extract(trusted, folder)


def _check_alone(folder: Path, files: Iterable[str]) -> None:
    """Remove compiled Python from a folder, and check that Python would find no other modules there.

    Raises:
        ValueError: another module exists.
    """
    expected = {folder / name for name in files}
    for path in sorted(folder.rglob("*")):
        if path.name == "__pycache__" and path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
    for path in sorted(folder.rglob("*")):
        if path not in expected and (path.suffix in all_suffixes() or path.is_symlink()):
            raise ValueError(
                f"{path} is there already, and the trace does not bring it: choose another folder"
            )


def _of_trace(spec: RackSpec) -> RackSpec:
    """Return a rack of a trace without the path of its own recording."""
    return spec.model_copy(update={"trace": None})
