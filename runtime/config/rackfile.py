"""Reads TOML rack files into a `RackSpec`.

The message for a mistake shows the file, line, key and value, and the allowed values:

    line.toml:7: slot.machine.switches.input = "hom": did you mean home? Choose from capture, ...
"""

from __future__ import annotations

import json
import re
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields
from decimal import Decimal
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails
from scanrack.io_images.addresses import allowed
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.doors import toml_tables
from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.site import Site, SiteError, sites_of
from scanrack.io_images.text_limits import TextKind, TextLimitError

from ..machine import EncoderSpec, Jam, Slip, Switch
from ..modules.record import LivePort, ModuleRecord
from .axis_tables import AxisTable
from .fuzz_table import FuzzTable
from .machine_tables import MachineTable, StationTable, TimelineTable, TurnTable
from .prove_tables import PropertyTable, ProveTable
from .rackspec import ForceSpec, InjectedFaultSpec, MisplacedError, RackSpec, SlotSpec
from .serial_units import UnitSpec
from .stub_tables import StubStep, StubTable
from .tomllines import KeyLines, KeyPath


class RackFileError(SiteError):
    """A rack file with mistakes; the message has a line for each mistake, in the order of the file.

    Attributes:
        reasons: the problem at each location.
    """

    def __init__(self, text: str, *sites: Site, reasons: Sequence[str] = ()) -> None:
        super().__init__(text, *sites)
        self.reasons = tuple(reasons)


@dataclass(frozen=True, slots=True)
class RackFile:
    """A rack file that has been read."""

    path: Path
    text: str
    spec: RackSpec
    lines: KeyLines

    def refusal(self, key: str, problem: str, subkey: str | None = None) -> RackFileError:
        """Return the error for a value that turns out to be wrong after the file has been read.

        Args:
            key: a top-level key of the file.
            subkey: a key of the table `key`; None for the whole value of `key`.
        """
        path: KeyPath = (key,)
        value = getattr(self.spec, key)
        if subkey is not None:
            path, value = (key, subkey), value[subkey]
        mistake = _Mistake(path, _value_text(value), problem)
        return _refusal([mistake], self.path, self.lines)


Modules = Callable[[Mapping[str, str], Path], Mapping[str, ModuleRecord]]
"""A function of `[modules]` (files by name) and the rack file's path; returns the modules by name."""


def unread(module_files: Mapping[str, str], path: Path) -> Mapping[str, ModuleRecord]:
    """Return stand-ins for modules whose files are not executed; a stand-in accepts any slot."""
    return {name: ModuleRecord(name=name, make=_never_called, unread=True, **_ANY) for name in module_files}


def _never_called(*_: object, **__: object) -> Any:
    """Stand in for the functions of a module that is never executed."""


_ANY: Mapping[str, Any] = {
    "has_firmware": True,
    "live": LivePort(opened=_never_called, factory_address=1, highest_address=sys.maxsize),
}
"""Traits of a stand-in: it accepts a firmware, and a port with any address."""


def load_rack_file(path: Path | str, modules: Modules = unread, *, program: str | None = None) -> RackFile:
    """Read a rack file.

    Args:
        modules: function that returns the file's own modules; `unread` executes nothing.
        program: the program to use if the file has no key `program`; None = refuse the file.

    Raises:
        RackFileError: the file can't be read, is not TOML, or contains an illegal value.
    """
    path = Path(path)
    return parse_rack_file(_read(path), path, modules, program=program)


def parse_rack_file(
    text: str, path: Path, modules: Modules = unread, *, program: str | None = None
) -> RackFile:
    """Parse the text of a rack file; messages call it `path`. Other arguments are as in `load_rack_file`.

    Raises:
        RackFileError: the text is not TOML, or contains an illegal value.
    """
    document = parse_toml(text, path)
    if program is not None:
        document.setdefault("program", program)
    lines = KeyLines(text)
    module_table = document.get("modules")
    module_files: dict[str, str] = {}  # without wrong values, which the validation of the document refuses
    if isinstance(module_table, dict):
        module_files = {name: file for name, file in module_table.items() if isinstance(file, str)}
    records = modules(module_files, path) if module_files else None
    try:
        with plugins_not_searched():
            spec = RackSpec.model_validate(document, context=records)
    except ValidationError as error:
        raise explained(error, path, lines) from None
    return RackFile(path, text, spec, lines)


@contextmanager
def plugins_not_searched() -> Iterator[None]:
    """Keep pydantic from searching all installed packages for plugins, which is slow."""
    loader = "pydantic.plugin._loader"
    if loader in sys.modules:
        yield
        return
    sys.modules[loader] = SimpleNamespace(get_plugins=tuple)  # type: ignore[assignment]  # no plugins
    try:
        yield
    finally:
        del sys.modules[loader]


def parse_toml(text: str, path: Path) -> dict[str, Any]:
    """Return the tables of a rack file; numbers with a decimal point become decimals.

    Raises:
        RackFileError: the text is not TOML, or exceeds the size limits.
    """
    try:
        return toml_tables(text)
    except TextLimitError as error:
        site = Site(file=str(path), line=error.line)
        raise RackFileError(f"{site.spot}: {error}", site, reasons=[str(error)]) from None
    except tomllib.TOMLDecodeError as error:
        raise _syntax_error(path, str(error)) from None


MISTAKES = 200
"""Maximum number of mistakes in a message."""


def explained(error: ValidationError, path: Path, lines: KeyLines | None = None) -> RackFileError:
    """Return the error that lists the mistakes in a specification, at most `MISTAKES` of them.

    Args:
        lines: lines of the keys; None if the specification is not from a file.
    """
    listed, unlisted_count = error.errors(include_url=False)[:MISTAKES], error.error_count() - MISTAKES
    mistakes = [_mistake(details) for details in listed if not _follows_from_others(details, listed)]
    if lines is not None:
        mistakes.sort(key=lambda mistake: lines.line(mistake.path))
    last_line = f"{path}: and {unlisted_count:,} more mistakes" if unlisted_count > 0 else ""
    return _refusal(mistakes, path, lines, last_line)


def _refusal(
    mistakes: Sequence[_Mistake], path: Path, lines: KeyLines | None, last_line: str = ""
) -> RackFileError:
    """Return the error that lists mistakes, one per line, with their locations if their lines are known."""
    messages = [mistake.message(path, lines) for mistake in mistakes]
    text = "\n".join([*messages, last_line] if last_line else messages)
    if lines is None:
        return RackFileError(text)
    sites = (Site(file=str(path), line=lines.line(mistake.path), key=mistake.key) for mistake in mistakes)
    return RackFileError(text, *sites, reasons=[mistake.reason for mistake in mistakes])


def _read(path: Path) -> str:
    """Return the text of a rack file; raise a RackFileError that says why it can't be read."""
    try:
        return read_input_text(path, TextKind.TOML)
    except FileNotFoundError:
        raise RackFileError(f"{path}: no such rack file") from None
    except OSError as error:
        raise RackFileError(f"{path}: the rack file can't be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise RackFileError(f"{path}: the rack file is not text in UTF-8: {error.reason}") from None


def _syntax_error(path: Path, message: str) -> RackFileError:
    """Return the error for a text that is not TOML; tomllib puts the line at the end of its message."""
    match = re.search(r" \(at line (\d+), column (\d+)\)$", message)
    if match is None:
        return RackFileError(f"{path}: this is not TOML: {message}")
    site = Site(file=str(path), line=int(match[1]), column=int(match[2]))
    reason = f"this is not TOML: {message[: match.start()]} in column {match[2]}"
    return RackFileError(f"{site.spot}: {reason}", site, reasons=[reason])


@dataclass(frozen=True, slots=True)
class _Mistake:
    """A mistake in a rack file."""

    path: KeyPath
    value: str  # the wrong value as text; "" if the message does not show it
    problem: str

    @property
    def key(self) -> str:
        """The key, preceded by the keys of its tables."""
        return ".".join(key for key in self.path if isinstance(key, str))

    @property
    def reason(self) -> str:
        """The key, value and problem as text."""
        key_and_value = f"{self.key} = {self.value}" if self.value else self.key
        return ": ".join(filter(None, (key_and_value, self.problem)))

    def message(self, path: Path, lines: KeyLines | None) -> str:
        """Return the reason, preceded by the file and, if known, the line."""
        location = f"{path}" if lines is None else f"{path}:{lines.line(self.path)}"
        return f"{location}: {self.reason}"


def _follows_from_others(details: ErrorDetails, all_details: list[ErrorDetails]) -> bool:
    """Return whether an array is too short only because some of its elements were refused."""
    path = details["loc"]
    return details["type"] == "too_short" and any(
        len(other["loc"]) > len(path) and other["loc"][: len(path)] == path for other in all_details
    )


def _mistake(details: ErrorDetails) -> _Mistake:
    """Return the mistake that pydantic found; an error from this package can name an inner key."""
    path: KeyPath = details["loc"]
    kind, value = details["type"], details["input"]
    error = details.get("ctx", {}).get("error")
    if kind in ("extra_forbidden", "unexpected_keyword_argument"):
        return _Mistake(path, "", f"unknown key; {allowed(path[-1], _keys_at(path[:-1]))}")
    if kind == "missing":
        return _Mistake(path, "", "this key is missing")
    if isinstance(error, MisplacedError):
        return _Mistake(error.path, _value_text(error.value), str(error))
    if error is not None:
        subpath = _path_of(error, value)
        return _Mistake(
            (*path, *subpath), _value_text(_look_up(value, subpath)) if subpath else "", str(error)
        )
    return _Mistake(path, _value_text(value), _problem(kind, details["msg"], details.get("ctx", {})))


def _problem(kind: str, message: str, context: Mapping[str, Any]) -> str:
    """Return the description of a problem, chosen by pydantic's error type."""
    if kind in _ALLOWED:
        return f"must be {_ALLOWED[kind].format(message=message, **context)}"
    return message


_ALLOWED = {
    "allowed": "{message}",
    "int_type": "a whole number",
    "bool_type": "true or false",
    "string_type": "text in quotes",
    "tuple_type": "an array",
    "too_short": "an array of {min_length} or more",
    "model_type": "a table",
    "dataclass_type": "a table",
    "literal_error": "{expected}",
    "greater_than_equal": "{ge} or more",
}
"""Allowed values by error type; other types have them in their message."""

ANY_NAME = "*"
"""Stands for any user-chosen name in a path of `_TABLES`."""

_TABLES: Mapping[tuple[str, ...], type[BaseModel] | type[Switch | EncoderSpec | Slip | Jam]] = {
    (): RackSpec,
    ("slot",): SlotSpec,
    ("force",): ForceSpec,
    ("incident",): InjectedFaultSpec,
    ("unit",): UnitSpec,
    ("axes", ANY_NAME): AxisTable,
    ("fuzz",): FuzzTable,
    ("prove",): ProveTable,
    ("prove", "property"): PropertyTable,
    ("stubs", ANY_NAME): StubTable,
    ("stubs", ANY_NAME, "table"): StubStep,
    ("slot", "machine"): MachineTable,
    ("slot", "machine", "switches"): Switch,
    ("slot", "machine", "timeline"): TimelineTable,
    ("slot", "machine", "encoder"): EncoderSpec,
    ("slot", "machine", "slips"): Slip,
    ("slot", "machine", "jams"): Jam,
    ("slot", "machine", "stations"): StationTable,
    ("slot", "machine", "turns"): TurnTable,
}
"""The class of each table, by its path without array indexes."""


def _keys_at(path: KeyPath) -> Iterable[str]:
    """Return the allowed keys of a table."""
    names = tuple(key for key in path if isinstance(key, str))
    if names[:1] in (("axes",), ("stubs",)):
        names = (names[0], ANY_NAME, *names[2:])
    table = _TABLES[names]
    if issubclass(table, BaseModel):
        return table.model_fields
    return [field.name for field in fields(table)]


def _path_of(cause: ValueError, table: object) -> KeyPath:
    """Return the path in `table` of the first key that an error names; empty if it names none of them."""
    paths = {str(path[-1]): path for path in _paths_in(table)}
    return next((paths[site.key] for site in sites_of(cause) if site.key in paths), ())


def _paths_in(table: object) -> Iterable[KeyPath]:
    """Yield the paths of the keys in a table, and of its options."""
    if isinstance(table, Mapping):
        for key in table:
            yield (key,)
        for option in table.get("options", ()):
            yield ("options", option)


def _look_up(table: Any, path: KeyPath) -> object:
    for key in path:
        table = table[key]
    return table


def _value_text(value: object) -> str:
    """Return a value in rack file notation, in at most 60 characters; "" for a table or an array."""
    if isinstance(value, Mapping | BaseModel | list | tuple):
        return ""
    text = str(value) if isinstance(value, Decimal) else json.dumps(value, default=str, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:57]}..."
