"""From the path of a rack to the parts of a run: specification, logic, and their files."""

from __future__ import annotations

import atexit
import inspect
import tempfile
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePath
from typing import Any

from pydantic import ValidationError

from ... import ladder
from ...ladder import Controller, LadderLogic, write_program
from ...ladder.instructions.motion.axes import AxisSettings
from ...ladder.model.errors import LadderError
from ...ladder.model.stubs import Stub, Stubs
from ...runtime.config.quantities import parse_duration
from ...runtime.config.rackfile import RackFile, RackFileError, explain, load_rack_file
from ...runtime.config.rackspec import MISSING_TAGS, REFUSED, STUB_SETTINGS, RackSpec
from ...runtime.loop.scan import ScanLogic
from .program import (
    EXPORT_SUFFIXES,
    L5X_SUFFIXES,
    Form,
    LoadedProgram,
    MissingNameError,
    ProgramError,
    as_logic,
    axes_of,
    is_python,
    load_function,
    load_program,
    load_stubs,
    split_address,
)

RACK_FUNCTION = "rack"
"""The function of a Python rack file that returns the `RackSpec`."""


@dataclass(frozen=True, slots=True)
class Job:
    """A rack and its program, ready to run."""

    spec: RackSpec
    logic: ScanLogic  # the function that is called once per scan
    logic_name: str  # its origin, `file:function`
    program: Path
    rack_file: Path  # for a rack in Python it may be the program, too
    rack_name: str  # the rack file's name, with the function of one in Python
    retained: bytes | None = None  # the file of the ladder program's initial tags; None without one
    notices: tuple[str, ...] = ()  # differences of program and rack from an export, a sentence for each

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of an export, and those of a ladder program, such as two coils of one bit."""
        own = map(str, self.logic.warnings) if isinstance(self.logic, LadderLogic) else ()
        return (*self.notices, *own)

    @property
    def stubs(self) -> tuple[str, ...]:
        """The stubs in use, as `MSG = done after 20 ms (3 times)`."""
        return self.logic.stubs_in_use if isinstance(self.logic, LadderLogic) else ()

    @property
    def stub_files(self) -> tuple[str, ...]:
        """Paths of the Python files of stubs, from the rack file's folder, each once."""
        return stub_files(self.spec)

    @property
    def folder(self) -> Path:
        """The base of the paths in the rack file."""
        return self.rack_file.parent


def load_job(rack: str, program: str | None = None) -> Job:
    """Load a rack and its program.

    Args:
        rack: path of a TOML file, or of a Python file (`path[:function]`).
        program: another program in place of the rack's, `path[:function]` from the current folder.

    Raises:
        ValueError: an unusable file; with file, line, key and the allowed values.
    """
    if program is not None:
        spec, path = load_spec(rack)
        loaded = load_program(program, stubs=_stubs(spec, path.parent), slots=_slots(spec))
        if isinstance(loaded.function, LadderLogic):
            loaded = _bound(spec, loaded, path)
        return _job(spec, loaded, path, rack)
    path = _rack_path(rack)
    return _from_toml(path) if rack_form(path) is Form.DATA else _from_python(rack)


def load_rack(rack: str | Path, program: Callable[..., Any] | str | Path | None = None) -> Job:
    """Load a rack for `run`, `open_bench` and the like.

    Args:
        rack: path of a TOML file, or of a Python file (`path[:function]`).
        program: runs in place of the rack's program: a `Controller`, a `Program`, a class of `Logic`, a
            function of the scan, or the path of a file. A recording gets an object as the file that made it:
            ladder logic as rung text, else the Python file of the function.

    Raises:
        ValueError: one of the files can't be used, or the program's file can't be found.
    """
    if program is None or isinstance(program, (str, Path)):
        return load_job(str(rack), None if program is None else str(program))
    spec, path = load_spec(str(rack))
    logic = as_logic(program)
    name = str(getattr(program, "name", None) or getattr(program, "__name__", type(program).__name__))
    file = _rung_file(logic) if isinstance(logic, (ladder.Program, Controller)) else _source_file(program)
    return _job(
        spec, _bound(spec, LoadedProgram(file, name, logic, file.read_bytes()), path), path, str(rack)
    )


def _rung_file(logic: ladder.Program | Controller) -> Path:
    """Write a program of this process as rung text; it stays as long as the process."""
    folder = tempfile.TemporaryDirectory()
    atexit.register(folder.cleanup)
    file = Path(folder.name) / f"{logic.name}.rung"
    write_program(logic, file)
    return file


def _source_file(program: Callable[..., Any]) -> Path:
    made_by = program if inspect.isroutine(program) or isinstance(program, type) else type(program)
    try:
        return Path(inspect.getfile(made_by))
    except (OSError, TypeError) as error:
        raise ProgramError(
            f"{program!r}: its file can't be found: no recording could be run again"
        ) from error


def with_tags(job: Job, patterns: Sequence[str]) -> Job:
    """Return a job that records further tags."""
    return replace(job, spec=job.spec.model_copy(update={"tags": (*job.spec.tags, *patterns)}))


def load_spec(rack: str) -> tuple[RackSpec, Path]:
    """Load a rack without its program; return it and its path. See `load_job`."""
    path = _rack_path(rack)
    if rack_form(path) is Form.DATA:
        return load_rack_file(path).spec, path
    try:
        file = load_function(_address(rack), Path(), default=RACK_FUNCTION, arguments=())
    except MissingNameError as error:
        says = f'a program is run by a rack file that names it: program = "{path.name}"'
        raise RackFileError(f"{error}; {says}") from error
    return _call(file), file.path


RACK_FORMS = {".toml": Form.DATA, ".py": Form.PYTHON}
"""By the suffix of a rack file; `load_spec` refuses any other."""


def rack_form(path: PurePath) -> Form:
    """Return how `load_spec` reads a rack file; RackFileError if this is not a rack file."""
    if path.suffix not in RACK_FORMS:
        raise RackFileError(f"{path}: a rack is a .toml or a .py file")
    return RACK_FORMS[path.suffix]


def _rack_path(rack: str) -> Path:
    path = Path(split_address(rack)[0])
    rack_form(path)
    return path


def scans_to_run(spec: RackSpec, duration: str | None, scans: int | None, *, endless: bool) -> int | None:
    """Return the number of scans to run, None = until Ctrl-C.

    Args:
        spec: the rack; its `run_for_s` is used without `duration` and `scans`.
        duration: machine time with its unit, such as "10 s".
        endless: a run without any of them has no end; otherwise it takes `DEFAULT_RUN`.

    Raises:
        ValueError: both are given, or one of them is illegal.
    """
    if scans is not None and duration is not None:
        raise ValueError("--scans and --for say the same thing: give one of them")
    if scans is not None:
        if scans < 1:
            raise ValueError(f"--scans {scans} is not allowed: 1 or more")
        return scans
    if duration is None and spec.run_for_s is not None:
        duration = f"{spec.run_for_s:f} s"
    if duration is None:
        if endless:
            return None
        duration = DEFAULT_RUN
    return -(-parse_duration(duration) // spec.scan_ns)


DEFAULT_RUN = "10 s"
"""Default machine time of a run in virtual time."""


def _from_toml(path: Path) -> Job:
    file = load_rack_file(path)
    stubs = _stubs(file.spec, path.parent, file)
    try:
        program = load_program(str(file.spec.program), path.parent, stubs, _slots(file.spec))
    except ProgramError as error:
        raise file.refusal("program", str(error)) from error
    if stubs.by_name and not isinstance(program.function, LadderLogic):
        raise file.refusal("stubs", "the program has no instructions: it is a function")
    try:
        _bind_axes(file.spec, program)
    except LadderError as error:
        raise file.refusal("axes", str(error)) from error
    return _job(file.spec, program, path, str(path))


def _from_python(rack: str) -> Job:
    spec, path = load_spec(rack)
    if isinstance(spec.program, str):
        stubs = _stubs(spec, path.parent)
        loaded = _bound(spec, load_program(spec.program, path.parent, stubs, _slots(spec)), path)
        return _job(spec, loaded, path, rack)
    name = getattr(spec.program, "__name__", type(spec.program).__name__)
    return Job(spec, as_logic(spec.program), f"{path.name}:{name}", path, path, _rack_name(rack))


def _slots(spec: RackSpec) -> list[int]:
    return [slot.number for slot in spec.slot]


def _bind_axes(spec: RackSpec, program: LoadedProgram) -> None:
    """Bind axes of a ladder program to 3601s of the rack.

    Raises:
        LadderError: an unknown axis, or one that needs a function that a 3601 lacks.
    """
    if not spec.axes:
        return
    if not isinstance(program.function, LadderLogic):
        raise LadderError("the program has no axes: it is a function")
    settings = {
        name: AxisSettings(**axis.values(), round_trip_ms=_round_trip_ms(spec))
        for name, axis in spec.axes.items()
    }
    program.function.take_axes(axes_of(settings))
    program.function.build()


def _round_trip_ms(spec: RackSpec) -> int:
    """Return the time of words across the backplane both ways: two packets and a scan, 10 ms at least."""
    packets_ns = 2 * spec.rpi_ns if spec.controller == "compactlogix" else 0
    return max(10, -(-(packets_ns + spec.scan_ns) // 1_000_000))


def _stubs(spec: RackSpec, folder: Path, file: RackFile | None = None) -> Stubs:
    """Read the stubs of a rack; RackFileError for an illegal stub, or a function that can't be loaded.

    Args:
        file: the rack file, if it is TOML.
    """
    read: dict[str, Stub] = {}
    for name, text in spec.stubs.items():
        if name in STUB_SETTINGS:
            continue
        try:
            read.update(load_stubs({name: text}, folder).by_name)
        except (LadderError, ProgramError) as error:
            if file is not None:
                raise file.refusal("stubs", str(error), name) from error
            raise RackFileError(f"stubs.{name}: {error}") from error
    if REFUSED in spec.stubs and PurePath(str(spec.program)).suffix not in EXPORT_SUFFIXES:
        text = "only an export, an .L5X or an .SLC, has refused rungs"
        raise (
            RackFileError(f"stubs.{REFUSED}: {text}")
            if file is None
            else file.refusal("stubs", text, REFUSED)
        )
    cards = {slot.number: slot.module for slot in spec.slot}
    return Stubs(read, MISSING_TAGS in spec.stubs, REFUSED in spec.stubs, cards)


def stub_files(spec: RackSpec) -> tuple[str, ...]:
    """Return the paths of the Python files of a rack's stubs, from the rack file's folder, each once."""
    files = (split_address(text, "")[0] for text in spec.stubs.values() if is_python(text))
    return tuple(dict.fromkeys(files))


def _address(rack: str) -> str:
    path, name = split_address(rack, RACK_FUNCTION)
    return f"{path}:{name}"


def _rack_name(rack: str) -> str:
    """Return the address of a rack without the folder."""
    path, name = split_address(rack, RACK_FUNCTION)
    return Path(path).name if rack_form(Path(path)) is Form.DATA else f"{Path(path).name}:{name}"


def _bound(spec: RackSpec, program: LoadedProgram, file: Path) -> LoadedProgram:
    """Return a program whose axes are bound.

    Raises:
        RackFileError: see `_bind_axes`.
    """
    try:
        _bind_axes(spec, program)
    except LadderError as error:
        raise RackFileError(f"{file}: axes: {error}") from error
    return program


def _job(spec: RackSpec, program: LoadedProgram, rack_file: Path, rack: str) -> Job:
    name = f"{program.path.name}:{program.name}"
    notices = (*program.notices, *_other_modules(spec, program))
    return Job(spec, program.function, name, program.path, rack_file, _rack_name(rack), notices=notices)


def _other_modules(spec: RackSpec, program: LoadedProgram) -> Iterator[str]:
    """Yield the slots whose module differs from that of the export."""
    if not program.modules:
        return
    from ..imports.export_slots import differences  # with lxml: most programs are no exports
    from ..imports.l5x_rack import slots_of
    from ..imports.slc_rack import slots_of_slc

    is_l5x = program.path.suffix in L5X_SUFFIXES
    slots = slots_of(program.modules) if is_l5x else slots_of_slc(program.modules)  # type: ignore[arg-type]
    yield from differences(slots, [(slot.number, slot.module) for slot in spec.slot])


def _call(file: LoadedProgram) -> RackSpec:
    """Call the function of a Python rack file."""
    try:
        spec = file.function()
    except ValidationError as error:
        raise RackFileError(explain(error, file.path)) from error
    except (Exception, SystemExit) as error:
        steps = traceback.extract_tb(error.__traceback__)
        line = next((step.lineno for step in reversed(steps) if step.filename == str(file.path)), 1)
        what = f"{type(error).__name__}: {error}"
        raise RackFileError(f"{file.path}:{line}: {file.name}() raised {what}") from error
    if not isinstance(spec, RackSpec):
        raise RackFileError(f"{file.path}: {file.name}() returned {type(spec).__name__}, not a RackSpec")
    return spec
