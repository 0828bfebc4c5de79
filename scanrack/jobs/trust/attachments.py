"""Attaches the files of a job to a recording, and extracts them again.

rack file and program      named by the metadata `rack_file` and `program_file`, path[:function]
retained tags              named by the metadata `retained_file`: initial tags of a ladder program
stubs in Python            named by the rack file's `[stubs]`
imports of the program     Python files beside it, by their relative paths
operator panel             beside the rack file, under its name: pages show it
words.json, tags.json      the maps of words and of recorded tags, which a run does not need
snapshots.txt.zst          values of a ladder program, from which explanations begin
edit-1/...                 rack file and program after an edit during the run, see `program_versions`

`trust` decides which of these files may be used.
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
from typing import TYPE_CHECKING, NamedTuple

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
    """Return the program's file name in a trace. It differs from the rack file's name if the files differ."""
    name = job.program.name
    clashes = name == job.rack_file.name and job.program != job.rack_file
    return f"program/{name}" if clashes else name


def made_by(job: LoadedRack) -> dict[str, str]:
    """Return the metadata that name the rack file, program and retained tags."""
    name = program_name(job)
    if job.program.suffix == PYTHON:
        name = f"{name}:{job.logic_name.rpartition(':')[2]}"
    retained = {} if job.retained is None else {"retained_file": RETAINED}
    return {"rack_file": job.rack_name, "program_file": name, **retained}


def files_of(job: LoadedRack) -> dict[str, Path]:
    """Return the files from which a job is loaded, by name in a trace, except the retained tags."""
    rack = {} if job.rack_file == job.program else {job.rack_file.name: job.rack_file}
    return {program_name(job): job.program, **rack, **files_beside(job)}


def files_beside(job: LoadedRack) -> dict[str, Path]:
    """Return a rack's other files: modules, stubs, unit programs, panel, and linked racks in the folder."""
    panel = Path(panel_name(str(job.rack_file)))
    panels = {panel.name: panel} if _is_input(panel) else {}
    return {**_helper_files(job), **_racks_beside(job), **panels}


def _helper_files(job: LoadedRack) -> dict[str, Path]:
    """Return the files that a rack's program needs: modules, stubs, unit programs."""
    return {**_imported(job), **_stub_functions(job), **_unit_programs(job)}


def _is_input(path: Path) -> bool:
    """Return whether a file exists and may be attached, see `open_input`."""
    try:
        open_input(path).close()
    except OSError:
        return False
    return True


def _racks_beside(job: LoadedRack) -> dict[str, Path]:
    """Return the files of linked racks, by path relative to this rack's folder; only files inside it."""
    files: dict[str, Path] = {}
    for rack in job.world.others if job.world is not None else ():
        other: LoadedRack = rack.job
        program = relative(other.program, other.folder)
        other_files = {other.rack_file.name: other.rack_file, program: other.program, **_helper_files(other)}
        folder = relative(other.folder, job.folder)
        for name, path in other_files.items():
            name_here = PurePosixPath(folder, name).as_posix()
            if not (_leads_out(name) or _leads_out(name_here)):
                files[name_here] = path
    return files


def _leads_out(name: str) -> bool:
    """Return whether a path leads out of its folder on any system, including to another Windows drive."""
    path = PureWindowsPath(name)
    return bool(path.anchor) or ".." in path.parts


def _imported(job: LoadedRack) -> dict[str, Path]:
    """Return the imported Python files beside the rack file, program and stubs, sorted by path.

    Later imports by a running program are not included.
    """
    stubs = [(job.folder / path, Path(path).as_posix()) for path in job.stub_files]
    roots = [(job.rack_file, job.rack_file.name), (job.program, program_name(job)), *stubs]
    main_files = [(path.resolve(), PurePosixPath(name).parent) for path, name in roots]
    main_paths = [path for path, _ in main_files]
    files: dict[str, Path] = {}
    for main_path, folder_name in main_files:
        if main_path.suffix == PYTHON:
            for module in _modules_of(main_path.parent):
                files[f"{folder_name / module.relative_path}"] = module.path
    return {name: path for name, path in sorted(files.items()) if path not in main_paths}


def _unit_programs(job: LoadedRack) -> dict[str, Path]:
    """Return the stored programs of the rack's devices, without duplicates, in the order of the devices."""
    paths = dict.fromkeys(Path(unit.program) for unit in job.spec.unit if unit.program is not None)
    return {path.as_posix(): job.folder / path for path in paths}


def _stub_functions(job: LoadedRack) -> dict[str, Path]:
    """Return the Python files of stubs, without duplicates, except the program."""
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
    for module in _modules_of(folder):
        if module.name.partition(".")[0] != package:
            del sys.modules[module.name]


class _Module(NamedTuple):
    """An imported module."""

    name: str
    relative_path: Path  # from the folder
    path: Path


def _modules_of(folder: Path) -> Iterator[_Module]:
    """Yield the imported modules of a folder."""
    prefix = f"{folder}{os.sep}"
    modules = list(sys.modules.items())
    packages = {name for name, module in modules if "." not in name and _may_be_below(prefix, name, module)}
    for name, module in modules if packages else ():  # must be fast: a search calls this before each run
        top = name.partition(".")[0]
        if top not in packages:
            continue
        file = getattr(module, "__file__", None) or ""
        if file.startswith(prefix) and file.endswith(PYTHON):
            relative_path = Path(file).relative_to(folder)
            if relative_path.with_suffix("").parts[0] == top:
                yield _Module(name, relative_path, Path(file))


def _may_be_below(prefix: str, name: str, module: ModuleType) -> bool:
    """Return whether a top-level module could be in the folder with path `prefix`, including a separator."""
    file: str | None = getattr(module, "__file__", None)
    if not file:  # a package without `__init__.py` has only paths
        return any(str(path).startswith(prefix) for path in getattr(module, "__path__", ()))
    return file.startswith(prefix) and file.startswith(name, len(prefix))


def job_of(trace: Trace, folder: Path, *, trust: bool, program: str | None = None) -> LoadedRack:
    """Load the rack and the program that made a trace.

    Args:
        trust: whether to run any Python in the trace; otherwise only files that the current folder also has
            are run.
        program: the user's program instead of the trace's, `path[:function]`. A ladder program begins with
            the trace's retained tags that it declares.

    Raises:
        UntrustedError: untrusted Python in the trace would be run.
        ValueError: the trace does not name its files, or one of them can't be used.
    """
    rack = _recorded(trace, "rack_file")
    trace_program = None if program is not None else own_program(rack, _recorded(trace, "program_file"))
    retained = trace.head.metadata.get("retained_file")
    _extract_checked(trace, folder, rack, trace_program, trust=trust, retained=retained)
    job = load_job(f"{folder / rack}", program if trace_program is None else f"{folder / trace_program}")
    if retained is not None and (program is None or is_rungs(job.logic)):
        job, _ = retaining(job, (folder / retained).read_bytes(), retained)
    return replace(job, spec=_without_recording(job.spec))


def spec_of(trace: Trace, folder: Path, *, trust: bool) -> RackSpec:
    """Load the rack on which a trace was recorded, without its program; see `job_of`."""
    rack = _recorded(trace, "rack_file")
    _extract_checked(trace, folder, rack, None, trust=trust)
    spec, _ = load_spec(f"{folder / rack}")
    return _without_recording(spec)


def _recorded(trace: Trace, key: str) -> str:
    """Return a metadata entry that names a file, `path[:function]`."""
    address = trace.head.metadata.get(key)
    if address is None:
        raise ValueError(f"the trace names no {key.replace('_', ' ')}: it can't be run without one")
    return address


def own_program(rack: str, program: str) -> str | None:
    """Return the address of a trace's program; None if the Python rack file is also the program."""
    name = address_name(rack)
    is_rack_file = name == address_name(program) and rack_form(PurePosixPath(name)) is Form.PYTHON
    return None if is_rack_file else program


def load_files(folder: Path, rack: str, program: str) -> LoadedRack:
    """Load a rack and its program from a trace's files in a folder.

    Args:
        rack: the rack file in the folder, `path[:function]`.
        program: the program in the folder, `path[:function]`.

    Raises:
        ValueError: one of the files can't be used.
    """
    separate_program = own_program(rack, program)
    return load_job(f"{folder / rack}", None if separate_program is None else f"{folder / separate_program}")


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


def _extract_checked(
    trace: Trace, folder: Path, rack: str, program: str | None, *, trust: bool, retained: str | None = None
) -> None:
    """Check that the files of a run may be used, and write them into a folder; for errors, see `job_of`."""
    trace.check_data()
    files = {
        name: data
        for name, data in attached_files(trace).items()
        if name not in _NOT_OF_THE_RUN and not edit_number(name)
    }
    run_files = RunFiles(address_name(rack), None if program is None else address_name(program), retained)
    trusted = admitted(files, run_files, trust=trust)
    _check_no_other_modules(folder, trusted)
    extract(trusted, folder)


def _check_no_other_modules(folder: Path, files: Iterable[str]) -> None:
    """Remove compiled Python from a folder, and check that it has no modules besides these files.

    Raises:
        ValueError: the folder has another module, or a symbolic link.
    """
    expected = {folder / name for name in files}
    for path in sorted(folder.rglob("*")):
        if path.name == "__pycache__" and path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
    for path in sorted(folder.rglob("*")):
        if path not in expected and (path.suffix in all_suffixes() or path.is_symlink()):
            raise ValueError(f"{path} already exists and is not part of the trace: choose another folder")


def _without_recording(spec: RackSpec) -> RackSpec:
    """Return a rack without the path of its recording, so that a rerun does not replace it."""
    return spec.model_copy(update={"trace": None})
