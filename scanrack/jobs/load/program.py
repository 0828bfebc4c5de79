"""Loads programs from files: the function of an address `path[:function]`, its source and its fingerprint.

A Python file defines `logic`, a function of the scan or an instance of a subclass of `Logic`; or one such
class; or `program`, a ladder program. A `.rung` file is a ladder program as text, a `.st` file is structured
text, a `.steps` file is a list of steps, and an `.L5X` or `.SLC` file is an exported controller.
"""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import field, replace
from enum import StrEnum
from importlib.machinery import ModuleSpec
from pathlib import Path, PurePath
from types import CodeType, FunctionType, ModuleType
from typing import TYPE_CHECKING, Any

from scanrack.io_images.annotations import signature_of
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.input_files import read_input
from scanrack.io_images.site import Site, SiteError
from scanrack.io_images.text_limits import LIMITS, TextKind, shortened
from scanrack.ladder.files.suffixes import STEPS_SUFFIX, STRUCTURED_SUFFIX, SUFFIX
from scanrack.ladder.model.stubs import NO_STUBS, InPython, Stub, Stubs, check_stubbed, parse_stub
from scanrack.ladder.python.sequences.logic import Logic
from scanrack.runtime.modules import record as module_records

from ..imports.export_start import DOWNLOADED, ExportStart
from .modules_beside import BESIDE, Compiler, find_beside, shadowed
from .rungs import is_rungs

if TYPE_CHECKING:  # a Python program needs no rungs
    from scanrack.ladder.instructions.motion.axes import AxisSettings
    from scanrack.ladder.lowering.bound_axes import Axes
    from scanrack.ladder.lowering.runnable import LadderLogic
    from scanrack.ladder.python.line_marks import LineWatch
    from scanrack.rockwell.l5x.report import Report
    from scanrack.rockwell.l5x.xml.records import ModuleRecord
    from scanrack.rockwell.slc.records import SlotRecord

DEFAULT_FUNCTION = "logic"
"""The function that is called once per scan, unless the address names another."""

SLC_SUFFIXES = (".SLC", ".slc")
"""Suffixes of an SLC 500 or MicroLogix program as text."""

L5X_SUFFIXES = (".L5X", ".l5x")

EXPORT_SUFFIXES = (*L5X_SUFFIXES, *SLC_SUFFIXES)
"""Suffixes of exported programs. Parts of an export can be refused."""

LADDER_NAME = "program"
"""Name of the ladder program to run if the file does not define the function."""


class Form(StrEnum):
    """How a file is used."""

    PYTHON = "python"
    """It is executed."""

    DATA = "data"
    """It is parsed."""


FORMS = {
    ".py": Form.PYTHON,
    SUFFIX: Form.DATA,
    STRUCTURED_SUFFIX: Form.DATA,
    STEPS_SUFFIX: Form.DATA,
    **dict.fromkeys(EXPORT_SUFFIXES, Form.DATA),
}
"""How a program file is used, by suffix. `load_program` refuses other files and never executes them."""


@dataclass(frozen=True, slots=True)
class LoadedProgram:
    """A program that was loaded from a file."""

    path: Path
    name: str
    function: Callable[..., Any]
    data: bytes
    notices: tuple[str, ...] = ()  # sentences about differences from an export
    modules: tuple[ModuleRecord | SlotRecord, ...] = ()  # records of an export's modules
    forces: Mapping[str, bool | int | float] = field(default_factory=dict)  # forces of an export, by address

    @property
    def source(self) -> str:
        """Text of the file."""
        return importlib.util.decode_source(self.data)

    @property
    def sha256(self) -> str:
        """SHA-256 of the file's bytes, in hexadecimal."""
        return hashlib.sha256(self.data).hexdigest()


class ProgramError(SiteError):
    """The program can't be loaded; the message names the file, the line and the allowed values."""


class MissingNameError(ProgramError):
    """The file does not define the requested name."""


def split_address(address: str, default: str = DEFAULT_FUNCTION) -> tuple[str, str]:
    """Split `path[:function]` into path and function name.

    >>> split_address("line.py"), split_address("line.py:cycle"), split_address("C:/line.py")
    (('line.py', 'logic'), ('line.py', 'cycle'), ('C:/line.py', 'logic'))
    """
    path, colon, name = address.rpartition(":")
    return (path, name) if colon and path and name.isidentifier() else (address, default)


def program_form(path: PurePath) -> Form:
    """Return how `load_program` reads a file; raise ProgramError if it is not a program."""
    if path.suffix not in FORMS:
        raise ProgramError(f"{path}: a program must be a .py, .rung, .st, .steps, .L5X or .SLC file")
    return FORMS[path.suffix]


def load_program(
    address: str,
    folder: Path | str = Path(),
    stubs: Stubs = NO_STUBS,
    slots: Collection[int] | None = None,
    export: ExportStart = DOWNLOADED,
) -> LoadedProgram:
    """Load the function that a scan loop calls once per scan.

    The file is run once, as its own module; it can import files beside it, see `modules_beside`.

    Args:
        address: `path[:function]`, with the path relative to `folder`.
        folder: base of a relative path.
        stubs: replacements of instructions of a ladder program, see `load_stubs`.
        slots: slot numbers of the rack, for the images of an SLC program; None without a rack.
        export: initial state of an export.

    Raises:
        ProgramError: the file or function does not exist, the file has a syntax error or raises an error, or
            the function can't be called with one argument.
    """
    folder = Path(folder)
    path = folder / split_address(address)[0]
    if program_form(path) is Form.DATA:
        if path.suffix in L5X_SUFFIXES:
            return _load_l5x(path, stubs, slots, export)
        if path.suffix in SLC_SUFFIXES:
            return _load_slc(path, stubs, slots)
        return _load_steps(path) if path.suffix == STEPS_SUFFIX else _load_rungs(path, stubs)
    return load_function(address, folder, default=DEFAULT_FUNCTION, arguments=("scan",), stubs=stubs)


def executed_again(program: LoadedProgram) -> Callable[..., Any]:
    """Run the file of a Python program again as a new module; return the new function.

    Raises:
        ProgramError: the file raises an error.
    """
    function: Callable[..., Any] = getattr(_execute(program.path, program.data), program.name)
    return function


def load_stubs(texts: Mapping[str, str], folder: Path | str) -> Stubs:
    """Read the stubs of a rack file.

    Args:
        texts: stub text by instruction or message tag, see `stubs`; or `path:function` of a Python function.
        folder: base of a relative path.

    Raises:
        ProgramError: a function can't be loaded.
        LadderError: a stub is invalid.
    """
    stubs: dict[str, Stub] = {}
    for name, text in texts.items():
        check_stubbed(name.upper())
        if is_python(text):
            function = load_function(text, folder, default="", arguments=("tags", "rung"), loosely=True)
            stubs[name.upper()] = InPython(text, function.function)
        else:
            stubs[name.upper()] = parse_stub(text)
    return Stubs(stubs)


def load_modules(addresses: Mapping[str, str], path: Path) -> dict[str, module_records.ModuleRecord]:
    """Execute the modules of a rack file; return their records, by name.

    Args:
        addresses: file and record, `path[:RECORD]`, by module name.
        path: path of the rack file.

    Raises:
        ProgramError: a file can't be executed, or lacks the record.
    """
    records = {}
    for name, address in addresses.items():
        file, attribute = split_address(address, default="RECORD")
        source = path.parent / file
        record = getattr(_execute(source, _read(source)), attribute, None)
        if not isinstance(record, module_records.ModuleRecord):
            raise ProgramError(f"{source}: no ModuleRecord named {attribute}")
        records[name] = replace(record, name=name)
    return records


def axes_of(settings: Mapping[str, AxisSettings]) -> Axes:
    r"""Return axes for `LadderLogic.take_axes`.

    Args:
        settings: by tag; a tag of a program in a controller is `\\PROGRAM.tag`.
    """
    from scanrack.ladder.files.rungreader import load_library
    from scanrack.ladder.lowering.bound_axes import Axes
    from scanrack.ladder.model.types import Structure

    library = load_library("axis3601")
    state = library.types["AXIS_3601"]
    assert isinstance(state, Structure)
    bound = {name: setting for name, setting in settings.items() if setting.slot}
    ideal = {name: setting for name, setting in settings.items() if not setting.slot}
    return Axes(bound, ideal, state, library.add_ons["AMCI3601"])


def is_python(stub: str) -> bool:
    """Return whether the text of a stub refers to a Python function.

    >>> is_python("plant.py:xrp"), is_python("done after 20 ms")
    (True, False)
    """
    path, name = split_address(stub, "")
    return bool(name) and PurePath(path).suffix == ".py"


def load_function(
    address: str,
    folder: Path | str,
    *,
    default: str,
    arguments: tuple[str, ...],
    stubs: Stubs = NO_STUBS,
    loosely: bool = False,
) -> LoadedProgram:
    """Load a function from a file, see `load_program`.

    Args:
        address: `path[:function]`.
        folder: base of a relative path.
        default: name of the function, if the address has none.
        arguments: names of the function's arguments.
        stubs: stubs of a ladder program, see `load_program`.
        loosely: whether the function may have more arguments for the operands.

    Raises:
        ProgramError: see `load_program`.
    """
    file, name = split_address(address, default)
    path = Path(folder) / file
    data = _read(path)
    _check_text(path, data)
    module = _execute(path, data)
    if name == DEFAULT_FUNCTION == default and not hasattr(module, name):
        name = _other_name(path, module)
    function = _instance_of(path, _callable_in(path, module, name))
    if is_rungs(function):
        build(path, function, stubs)
    _check_signature(path, name, function, arguments, loosely=loosely)
    return LoadedProgram(path, name, function, data)


def as_logic(program: Callable[..., Any]) -> Callable[..., Any]:
    """Return an instance of a subclass of `Logic`; return anything else unchanged.

    Raises:
        TypeError: the class needs arguments.
    """
    return program() if isinstance(program, type) and issubclass(program, Logic) else program


def _instance_of(path: Path, program: Callable[..., Any]) -> Callable[..., Any]:
    try:
        return as_logic(program)
    except Exception as error:
        raise _while_loading(path, error) from error


def _other_name(path: Path, module: ModuleType) -> str:
    """Return the name of the program in a file without the default function.

    Raises:
        ProgramError: there are several subclasses of `Logic`.
    """
    if is_rungs(getattr(module, LADDER_NAME, None)):
        return LADDER_NAME
    classes = [name for name, value in vars(module).items() if _is_logic_of(module, value)]
    if len(classes) > 1:
        raise ProgramError(
            f"{path}: more than one class of Logic: choose one, such as {path.name}:{classes[0]}"
        )
    return classes[0] if classes else DEFAULT_FUNCTION


def _is_logic_of(module: ModuleType, value: object) -> bool:
    return isinstance(value, type) and issubclass(value, Logic) and value.__module__ == module.__name__


@contextmanager
def _as_program_errors(prefix: str = "") -> Iterator[None]:
    """Raise a ProgramError in place of a parser error or build error."""
    try:
        yield
    except SiteError as error:
        raise ProgramError(f"{prefix}{error}") from error


def _load_rungs(path: Path, stubs: Stubs) -> LoadedProgram:
    """Load and build a program of rung text or structured text; raise ProgramError for a mistake in it."""
    from scanrack.ladder.files.rungfile import parse_program, parse_structured

    data = _read(path, TextKind.STRUCTURED if path.suffix == STRUCTURED_SUFFIX else TextKind.RUNGS)
    _check_text(path, data)
    text = data.decode("utf-8")
    program: LadderLogic
    with _as_program_errors():
        if path.suffix == STRUCTURED_SUFFIX:
            program = parse_structured(text, path.stem, file=str(path), stubs=stubs)
        else:
            program = parse_program(text, file=str(path), stubs=stubs)
    build(path, program)
    return LoadedProgram(path, program.name, program, data)


def _load_l5x(path: Path, stubs: Stubs, slots: Collection[int] | None, export: ExportStart) -> LoadedProgram:
    """Load an exported controller; raise ProgramError if it has a refused part."""
    from scanrack.rockwell.l5x import import_l5x  # lxml takes time to import, and most programs are not L5X

    data = _read(path, TextKind.EXPORT)
    with _as_program_errors():
        imported = import_l5x(path, stubs, slots, memory_mib=export.memory_mib)
    controller = imported.controller
    loaded = _imported_program(path, data, controller, imported.report, imported.document.modules, stubs)
    if export.keep_values:
        loaded.function.keep_values()  # type: ignore[attr-defined]
        return loaded
    return replace(loaded, notices=(*_prescanned(path, controller), *loaded.notices))


def _prescanned(path: Path, program: LadderLogic | None) -> Iterator[str]:
    """Yield a sentence with the values that prescan resets, if there are any."""
    from scanrack.ladder.lowering.runnable import shortened as listed

    reset = program.reset_by_prescan() if program is not None else []
    if reset:
        count = f"{len(reset):,} values" if len(reset) > 1 else "a value"
        yield (
            f"{path}: prescan resets {count} of the export, as after a download: {listed(reset)}; "
            "--keep-values begins with them"
        )


def _load_slc(path: Path, stubs: Stubs, slots: Collection[int] | None) -> LoadedProgram:
    """Load an RSLogix 500 export; raise ProgramError if it has a refused rung."""
    from scanrack.rockwell.slc import import_slc  # most programs are not SLC

    data = _read(path, TextKind.EXPORT)
    with _as_program_errors():
        imported = import_slc(path, stubs, slots)
    modules = tuple(imported.document.slots.values())
    return _imported_program(path, data, imported.program, imported.report, modules, stubs)


def _imported_program(
    path: Path,
    data: bytes,
    program: LadderLogic | None,
    report: Report,
    modules: tuple[ModuleRecord | SlotRecord, ...],
    stubs: Stubs,
) -> LoadedProgram:
    """Return an imported program.

    Raises:
        ProgramError: the export has no program, or a part was refused without a stub that replaces it.
    """
    from scanrack.ladder.lowering.runnable import REFUSALS_SHOWN

    refused = [*report.refused, *report.objects]
    if program is None or (refused and not stubs.refused):
        shown = [str(refusal) for refusal in refused[:REFUSALS_SHOWN]] or [f"{path} contains no program"]
        hidden = len(refused) - REFUSALS_SHOWN
        if hidden > 0:
            shown.append(f"and {hidden} more: scanrack l5x {path} lists all")
        raise ProgramError(
            "\n".join(shown), *(Site(file=refusal.file, line=refusal.line) for refusal in refused)
        )
    program.left_out = dict(report.stubs)
    if stubs.missing_tags and report.declared:
        declared = [f"{name} : {text}" for name, text in report.declared.items()]
        program.left_out["missing_tags"] = f"declare: {', '.join(declared)}"
    program.refused = [refusal.place for refusal in sorted(refused, key=lambda refusal: refusal.line)]
    return LoadedProgram(
        path, program.name, program, data, notices=report.warnings, modules=modules, forces=report.forces
    )


def _load_steps(path: Path) -> LoadedProgram:
    """Load a list of steps; raise ProgramError for a mistake in it."""
    data = _read(path, TextKind.STEPS)
    _check_text(path, data)
    from scanrack.ladder.files.steps import parse_steps

    with _as_program_errors():
        return LoadedProgram(path, path.stem, parse_steps(data.decode("utf-8"), str(path)), data)


def build(path: Path, program: LadderLogic, stubs: Stubs = NO_STUBS) -> None:
    """Build a program with the stubs and modules of its rack; raise ProgramError if it can't be built."""
    with _as_program_errors(f"{path}: "):
        program.take_stubs(stubs)
        program.build()


def _read(path: Path, kind: TextKind = TextKind.PYTHON) -> bytes:
    """Return the bytes of a program file; raise ProgramError if it is missing or can't be read."""
    try:
        return read_input(path, LIMITS[kind].size)
    except FileNotFoundError:
        raise ProgramError(f"{path}: no such program file") from None
    except OSError as error:
        raise ProgramError(f"{path}: the program can't be read: {error.strerror}") from None


def _check_text(path: Path, data: bytes) -> None:
    try:
        importlib.util.decode_source(data)
    except (SyntaxError, UnicodeDecodeError) as error:
        raise ProgramError(f"{path}: the program is not UTF-8 text: {error}") from None


def _compiled(data: bytes, file: str) -> CodeType:
    return compile(data, file, "exec")


COMPILER: ContextVar[Compiler] = ContextVar("COMPILER", default=_compiled)
"""Compiles the Python programs that are loaded; a search makes them record their branches."""


@contextmanager
def lines_marked(watch: LineWatch | None = None) -> Iterator[None]:
    """Make Python programs and modules beside them report their lines if they are loaded in the context.

    Args:
        watch: observer of the lines; None = the current one.
    """
    from scanrack.ladder.python.line_marks import WATCH, marked_code  # most commands observe no lines

    compiler, beside = COMPILER.set(marked_code), BESIDE.set(marked_code)
    current_watch = WATCH.set(watch or WATCH.get())
    try:
        yield
    finally:
        COMPILER.reset(compiler)
        BESIDE.reset(beside)
        WATCH.reset(current_watch)


def _execute(path: Path, data: bytes) -> ModuleType:
    """Run a program file as a new module and return the module.

    Raise ProgramError, with the line, if the program can't be compiled or raises an exception.
    """
    try:
        code = COMPILER.get()(data, str(path))
    except (SyntaxError, ValueError) as error:  # null bytes raise one or the other, by Python version
        line, text = getattr(error, "lineno", None) or 1, getattr(error, "msg", error)
        site = Site(file=str(path), line=line)
        raise ProgramError.at(site, f"the program has a syntax error: {text}") from None
    except (MemoryError, RecursionError):
        text = "the program has an expression that is nested too deeply for Python"
        raise ProgramError.at(Site(file=str(path), line=1), text) from None
    module = ModuleType(f"scanrack_program_{path.stem}")
    module.__file__ = str(path)
    module.__spec__ = find_beside(path, ModuleSpec(module.__name__, None, origin=str(path)))
    sys.modules[module.__name__] = module
    try:
        exec(code, module.__dict__)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise _while_loading(path, error) from error
    return module


def _while_loading(path: Path, error: BaseException) -> ProgramError:
    """Return an error that names the innermost line of the program's own file."""
    steps = traceback.extract_tb(error.__traceback__)
    lines = [step.lineno for step in steps if step.filename == str(path)]
    problem = f"{type(error).__name__}: {shortened(str(error))}{shadowed(path, error)}"
    site = Site(file=str(path), line=lines[-1] if lines else 1)
    return ProgramError.at(site, f"the program can't be loaded: {problem}")


def _callable_in(path: Path, module: ModuleType, name: str) -> Callable[..., Any]:
    """Return the callable with the given name; raise ProgramError if the file does not define it."""
    value = getattr(module, name, None)
    if callable(value):
        return value  # type: ignore[no-any-return]
    if value is not None:
        raise ProgramError(f"{path}: {name} is {type(value).__name__}, not a function")
    function_names = [
        key
        for key, value in vars(module).items()
        if isinstance(value, FunctionType) and value.__module__ == module.__name__ and not key.startswith("_")
    ]
    import difflib  # most names are correct

    matches = difflib.get_close_matches(name, function_names, n=1)
    hint = f"; did you mean {matches[0]}?" if matches else ""
    known = f" among {', '.join(function_names)}" if function_names else ""
    raise MissingNameError(f"{path}: no function {name}{known}{hint}")


def _check_signature(
    path: Path, name: str, function: Callable[..., Any], arguments: tuple[str, ...], *, loosely: bool = False
) -> None:
    """Raise ProgramError if a function is async or a generator, or can't be called with these arguments."""
    form = f"{name}({', '.join(arguments)}{', *operands' if loosely else ''})"
    line = f"{path}:{_line_of(function)}"
    if inspect.iscoroutinefunction(function) or inspect.isgeneratorfunction(function):
        raise ProgramError(f"{line}: {name} must be a plain function {form}, without async and yield")
    try:
        signature = signature_of(function)
    except ValueError:  # a callable in C has no signature
        return
    try:
        (signature.bind_partial if loosely else signature.bind)(*arguments)
    except TypeError:
        raise ProgramError(f"{line}: {name}{signature} can't be called as {form}") from None


def _line_of(function: Callable[..., Any]) -> int:
    code = getattr(inspect.unwrap(function), "__code__", None)
    return 1 if code is None else code.co_firstlineno
