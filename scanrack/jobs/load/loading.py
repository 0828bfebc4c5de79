"""Loads a rack and its program from the path of the rack."""

from __future__ import annotations

import atexit
import inspect
import tempfile
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import DEFAULT_RUN, parse_duration
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.stubs import Stub, Stubs
from scanrack.runtime.config.rackfile import RackFile, RackFileError, explained, load_rack_file
from scanrack.runtime.config.rackspec import MISSING_TAGS, REFUSED, STUB_SETTINGS, RackSpec, profile_in
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.traces.files.portable import no_device

from ..imports.export_start import DOWNLOADED, ExportStart
from .exports import rack_of_export
from .linked_racks import RackGroup, stub_of_table
from .program import (
    EXPORT_SUFFIXES,
    L5X_SUFFIXES,
    Form,
    LoadedProgram,
    MissingNameError,
    ProgramError,
    as_logic,
    axes_of,
    build,
    is_python,
    load_function,
    load_modules,
    load_program,
    load_stubs,
    split_address,
)
from .rungs import is_rungs

if TYPE_CHECKING:  # a Python program needs no rungs
    from scanrack.ladder import Controller, Program
    from scanrack.runtime.live.actions import Force

RACK_FUNCTION = "rack"
"""The function of a Python rack file that returns the `RackSpec`."""


@dataclass(frozen=True, slots=True)
class LoadedRack:
    """A rack and its program, ready to run."""

    spec: RackSpec
    logic: ScanLogic  # the function that is called once per scan
    logic_name: str  # `file:function` of the logic
    program: Path  # the file of the logic
    rack_file: Path  # the file of a Python rack may also contain the program
    rack_name: str  # name of the rack file, with the function of a Python rack
    retained: bytes | None = None  # file with the initial tags of the ladder program; None without one
    notices: tuple[str, ...] = ()  # sentences about differences of program and rack from an export
    world: RackGroup | None = None  # the racks that run side by side with it
    forces: Mapping[str, bool | int | float] = field(default_factory=dict)  # forces of an export, by address
    tested: LoadedRack | None = None  # the job without the test routine; None without a test routine

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about an export and about a ladder program, such as two coils for one bit."""
        warnings = map(str, self.logic.warnings) if is_rungs(self.logic) else ()
        return (*self.notices, *warnings)

    @property
    def stubs(self) -> tuple[str, ...]:
        """The stubs in use, in the form `MSG = done after 20 ms (3 times)`."""
        return self.logic.stubs_in_use if is_rungs(self.logic) else ()

    @property
    def stub_files(self) -> tuple[str, ...]:
        """Paths of the stubs' Python files, relative to the rack file's folder, without duplicates."""
        return stub_files(self.spec)

    @property
    def folder(self) -> Path:
        """The folder to which paths in the rack file are relative."""
        return self.rack_file.parent


def load_job(
    rack: str,
    program: str | None = None,
    world: RackGroup | None = None,
    export: ExportStart | None = None,
) -> LoadedRack:
    """Load a rack and its program.

    Args:
        rack: path of a TOML file, a Python file (`path[:function]`), or an export, which gets a rack file in
            a temporary folder.
        program: program to run instead of the rack's, `path[:function]`, relative to the current folder.
        world: the racks that run side by side with this one; None = a new group that it leads.
        export: initial state if `rack` is an export; None = as after a download. A rack file has its own
            setting.

    Raises:
        ValueError: a file is unusable; the message has file, line, key and allowed values.
    """
    if is_export(rack):
        rack = str(rack_of_export(Path(rack), export=export or DOWNLOADED))
    elif export is not None:
        raise ValueError(f"{rack}: --keep-values and --memory are for exports: use [export] in the rack file")
    path = _rack_path(rack)
    file = load_rack_file(path, load_modules) if rack_form(path) is Form.DATA else None
    spec = load_spec(rack)[0] if file is None else file.spec
    source = _RackSource(rack, path, spec, file, world or RackGroup(_load_beside))
    source.world.enter(path)
    if program is not None:
        return _load_with(source, lambda stubs: _program(program, Path(), stubs, spec), is_replaced=True)
    if isinstance(spec.program, str):
        address = spec.program
        return _load_with(source, lambda stubs: _program(address, path.parent, stubs, spec))
    return _load_object(source, spec.program, path)


def _program(address: str, folder: Path, stubs: Stubs, spec: RackSpec) -> LoadedProgram:
    export = ExportStart(spec.export.keep_values, spec.export.memory_mib)
    return load_program(address, folder, stubs, [slot.number for slot in spec.slot], export)


def _load_beside(path: Path, world: RackGroup) -> LoadedRack:
    return load_job(str(path), world=world)


def load_rack(rack: str | Path, program: Callable[..., Any] | str | Path | None = None) -> LoadedRack:
    """Load a rack for `run`, `open_bench` and similar functions.

    Args:
        rack: path of a TOML file, or of a Python file (`path[:function]`).
        program: runs instead of the rack's program: a `Controller`, a `Program`, a subclass of `Logic`, a
            function of the scan, or the path of a file. For an object, a recording contains the rung text of
            ladder logic or the Python file of the function.

    Raises:
        ValueError: one of the files can't be used, or the program's file can't be found.
    """
    if program is None or isinstance(program, (str, Path)):
        return load_job(str(rack), None if program is None else str(program))
    spec, path = load_spec(str(rack), program=getattr(program, "__name__", type(program).__name__))
    source = _RackSource(str(rack), path, spec, None, RackGroup(_load_beside))
    source.world.enter(path)
    return _load_object(source, program, None)


def _load_object(source: _RackSource, program: Callable[..., Any], file: Path | None) -> LoadedRack:
    """Return the job for a program that is an object in this process.

    Args:
        file: the file that created the program; None = find or write one.
    """
    logic = as_logic(program)
    name = str(getattr(program, "name", None) or getattr(program, "__name__", type(program).__name__))
    if file is None:
        file = _rung_file(logic) if is_rungs(logic) else _source_file(program)  # type: ignore[arg-type]
    loaded = LoadedProgram(file, name, logic, file.read_bytes())

    def load(stubs: Stubs) -> LoadedProgram:
        if is_rungs(logic):
            build(loaded.path, logic, stubs)
        return loaded

    return _load_with(source, load)


def _rung_file(logic: Program | Controller) -> Path:
    """Write a program of this process as rung text to a file that lasts as long as the process."""
    from scanrack.ladder import write_program

    folder = tempfile.TemporaryDirectory()
    atexit.register(folder.cleanup)
    file = Path(folder.name) / no_device(f"{logic.name}.rung")
    write_program(logic, file)
    return file


def _source_file(program: Callable[..., Any]) -> Path:
    """Return the Python file of a function, of a class, or of the class of another program."""
    definition = program if inspect.isroutine(program) or isinstance(program, type) else type(program)
    try:
        return Path(inspect.getfile(definition))
    except (OSError, TypeError) as error:
        raise ProgramError(
            f"{program!r}: its file can't be found: its recordings could not be run again"
        ) from error


def with_tags(job: LoadedRack, patterns: Sequence[str]) -> LoadedRack:
    """Return a job that also records tags that match the patterns."""
    return replace(job, spec=job.spec.model_copy(update={"tags": (*job.spec.tags, *patterns)}))


def load_spec(rack: str, *, program: str | None = None) -> tuple[RackSpec, Path]:
    """Load a rack without its program; return the rack and its path. See `load_job`.

    Args:
        program: name of the program to run instead of the rack's; the rack may then lack one.
    """
    path = _rack_path(rack)
    if rack_form(path) is Form.DATA:
        return load_rack_file(path, load_modules, program=program).spec, path
    try:
        file = load_function(rack, Path(), default=RACK_FUNCTION, arguments=())
    except MissingNameError as error:
        hint = f'a program needs a rack file with program = "{path.name}"'
        raise RackFileError(f"{error}; {hint}") from error
    return _call(file), file.path


RACK_FORMS = {".toml": Form.DATA, ".py": Form.PYTHON}
"""How a rack file is used, by suffix; `load_spec` refuses any other suffix."""


def is_export(rack: str) -> bool:
    """Return whether the path of a rack names an export.

    >>> is_export("line.L5X"), is_export("line.toml")
    (True, False)
    """
    return PurePath(rack).suffix in EXPORT_SUFFIXES


def runs(address: str) -> bool:
    """Return whether an address names a rack file or an export, and not a recording."""
    return Path(split_address(address)[0]).suffix in RACK_FORMS or is_export(address)


SCENARIO, SCENARIO_TRACE = "scenario.json", "trace.mcap"
"""Files of a refuted property or of a search failure: the scenario and its recording."""


def recording_of(address: str) -> str:
    """Return the recording to which an address refers; for a scenario, the recording in the same folder.

    Raises:
        ValueError: the scenario has no recording, since it did not happen on the rack.
    """
    path, sharp, fragment = address.partition("#")
    if PurePath(path).name != SCENARIO:
        return address
    trace = Path(path).with_name(SCENARIO_TRACE)
    if not trace.is_file():
        raise ValueError(f"{path}: no {SCENARIO_TRACE} in its folder: the scenario has not run on the rack")
    return f"{trace}{sharp}{fragment}"


def rack_form(path: PurePath) -> Form:
    """Return how `load_spec` reads a rack file; raise RackFileError if it is not a rack file."""
    if path.suffix not in RACK_FORMS:
        raise RackFileError(f"{path}: a rack must be a .toml or .py file, or an .L5X or .SLC export")
    return RACK_FORMS[path.suffix]


def _rack_path(rack: str) -> Path:
    """Return the path of a rack's file; raise RackFileError if it is not a rack file."""
    path = Path(split_address(rack)[0])
    rack_form(path)
    return path


def forces_to_hold(job: LoadedRack, hold: bool) -> tuple[Force, ...]:
    """Return the forces of an export as operator actions; none unless `hold`.

    Raises:
        ValueError: `hold` is true, but the program's file has no forces.
    """
    if hold and not job.forces:
        raise ValueError(f"--forces: {job.program} has no forces")
    if not hold:
        return ()
    from scanrack.runtime.live.actions import Force

    return tuple(Force(tag, value) for tag, value in job.forces.items())


def scans_to_run(spec: RackSpec, duration: str | None, scans: int | None, *, endless: bool) -> int | None:
    """Return the number of scans to run; None = until Ctrl-C.

    Args:
        spec: the rack; its `run_for_s` is used if neither `duration` nor `scans` is given.
        duration: machine time with a unit, such as "10 s".
        endless: whether a run without any limit is endless; otherwise it lasts `DEFAULT_RUN`.

    Raises:
        ValueError: both are given, or one of them is invalid.
    """
    if scans is not None and duration is not None:
        raise ValueError("--scans and --for: give only one of them")
    if scans is not None:
        if scans < 1:
            raise ValueError(f"--scans {scans}: must be 1 or more")
        return scans
    if duration is None and spec.run_for_s is not None:
        duration = f"{spec.run_for_s:f} s"
    if duration is None:
        if endless:
            return None
        duration = DEFAULT_RUN
    return -(-parse_duration(duration) // spec.scan_ns)


@dataclass(frozen=True, slots=True)
class _RackSource:
    """The files of a rack during loading, with its specification and its group of racks."""

    rack: str
    path: Path
    spec: RackSpec
    file: RackFile | None  # None for a Python rack
    world: RackGroup

    def refusal(self, key: str, error: Exception | str, below: str | None = None) -> RackFileError:
        """Return the error for a key, with its line in a TOML file."""
        if self.file is not None:
            return self.file.refusal(key, str(error), below)
        return RackFileError(f"{self.path}: {key if below is None else f'{key}.{below}'}: {error}")


def _load_with(
    source: _RackSource, load: Callable[[Stubs], LoadedProgram], *, is_replaced: bool = False
) -> LoadedRack:
    """Return the job for a program, loaded with the stubs, modules and axes of its rack.

    Args:
        load: loads the program with the stubs.
        is_replaced: whether the program replaces the rack's, so that the rack's keys need not apply to it.
    """
    spec = source.spec
    stubs = _read_stubs(source)
    try:
        program = load(stubs)
    except ProgramError as error:
        if source.file is None or is_replaced:
            raise
        raise source.refusal("program", error) from error
    if not is_replaced and stubs.by_name and not is_rungs(program.function):
        raise source.refusal("stubs", "the program is a function, which has no instructions")
    try:
        if not is_replaced or is_rungs(program.function):
            _bind_axes(spec, program)
    except LadderError as error:
        raise source.refusal("axes", error) from error
    source.world.enter(source.path).take(spec, program.function)
    return _job(source, program)


def _bind_axes(spec: RackSpec, program: LoadedProgram) -> None:
    """Bind axes of a ladder program to 3601s of the rack.

    Raises:
        LadderError: an axis is unknown, or needs a function that a 3601 lacks.
    """
    if not spec.axes:
        return
    if not is_rungs(program.function):
        raise LadderError("the program is a function, which has no axes")
    from scanrack.ladder.instructions.motion.axes import AxisSettings

    trip_ms = _round_trip_ms(spec)
    settings = {
        name: AxisSettings(
            **axis.values(), round_trip_ms=trip_ms, limits=profile_in(spec.slot, axis.slot).limits
        )
        for name, axis in spec.axes.items()
    }
    program.function.take_axes(axes_of(settings))
    program.function.build()


def _round_trip_ms(spec: RackSpec) -> int:
    """Return the round-trip time of words across the backplane: two packets and a scan, at least 10 ms."""
    packets_ns = 2 * spec.rpi_ns if spec.controller == "compactlogix" else 0
    return max(10, -(-(packets_ns + spec.scan_ns) // 1_000_000))


def _read_stubs(source: _RackSource) -> Stubs:
    """Read the stubs of a rack; raise RackFileError if a stub is invalid or its function can't be loaded."""
    spec, folder = source.spec, source.path.parent
    stubs: dict[str, Stub] = {}
    for name, stub in spec.stubs.items():
        if name in STUB_SETTINGS:  # these keys are settings for the whole table
            continue
        try:
            if isinstance(stub, str):  # "done after 20 ms", or a function as in "plant.py:xrp"
                stubs.update(load_stubs({name: stub}, folder).by_name)
            else:
                stubs[name.upper()] = stub_of_table(stub, folder, source.world)
        except (ValueError, LadderError) as error:
            raise source.refusal("stubs", error, name) from error
    if REFUSED in spec.stubs and PurePath(str(spec.program)).suffix not in EXPORT_SUFFIXES:
        raise source.refusal("stubs", "only an export (.L5X or .SLC) has refused rungs", REFUSED)
    return Stubs(
        stubs, missing_tags=MISSING_TAGS in spec.stubs, refused=REFUSED in spec.stubs, modules=spec.words
    )


def racks_beside(spec: RackSpec) -> tuple[str, ...]:
    """Return the paths of the rack files in a rack's stubs, relative to its folder, without duplicates."""
    tables = (stub for stub in spec.stubs.values() if not isinstance(stub, str))
    return tuple(dict.fromkeys(table.rack for table in tables if table.rack))


def module_files(spec: RackSpec) -> tuple[str, ...]:
    """Return the paths of the Python files in a rack's `[modules]`, relative to the rack file's folder."""
    return tuple(split_address(module, "")[0] for module in spec.modules.values())


def stub_files(spec: RackSpec) -> tuple[str, ...]:
    """Return the paths of a rack's Python stubs and modules, relative to its folder, without duplicates."""
    texts = (stub for stub in spec.stubs.values() if isinstance(stub, str))
    files = (split_address(text, "")[0] for text in texts if is_python(text))
    return tuple(dict.fromkeys([*files, *module_files(spec)]))


def _rack_name(rack: str) -> str:
    """Return the address of a rack without its folder."""
    path, name = split_address(rack, RACK_FUNCTION)
    return Path(path).name if rack_form(Path(path)) is Form.DATA else f"{Path(path).name}:{name}"


def _job(source: _RackSource, program: LoadedProgram) -> LoadedRack:
    """Return the job for a program that was loaded with its rack."""
    name, spec = f"{program.path.name}:{program.name}", source.spec
    return LoadedRack(
        spec=spec,
        logic=program.function,
        logic_name=name,
        program=program.path,
        rack_file=source.path,
        rack_name=_rack_name(source.rack),
        notices=(*program.notices, *_other_modules(spec, program)),
        world=source.world,
        forces=program.forces,
    )


def _other_modules(spec: RackSpec, program: LoadedProgram) -> Iterator[str]:
    """Yield a sentence for each slot whose module differs from the export's."""
    if not program.modules:
        return
    from ..imports.export_slots import differences  # imports lxml, and most programs are not exports
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
        raise explained(error, file.path) from error
    except (Exception, SystemExit) as error:
        steps = traceback.extract_tb(error.__traceback__)
        line = next((step.lineno for step in reversed(steps) if step.filename == str(file.path)), 1)
        problem = f"{type(error).__name__}: {error}"
        raise RackFileError(f"{file.path}:{line}: {file.name}() raised {problem}") from error
    if not isinstance(spec, RackSpec):
        raise RackFileError(f"{file.path}: {file.name}() returned {type(spec).__name__}, not a RackSpec")
    return spec
