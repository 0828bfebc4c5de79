"""The registry of modules, with the records of scanrack and of installed packages."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache, cached_property
from typing import TYPE_CHECKING

from scanrack.io_images.module_words import PLAIN_WORDS, ModuleWords
from scanrack.io_images.site import SettingError

from .amci3601.record import RECORD as AMCI3601
from .record import LivePort, ModuleRecord, Options

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "scanrack.modules"
"""The entry point group for packages with modules: catalog name = module:RECORD."""


class OwnModules(Mapping[str, ModuleRecord]):
    """Scanrack's own modules by catalog name; all except the 3601 are imported on first use."""

    @cached_property
    def _all(self) -> Mapping[str, ModuleRecord]:
        from .adapters.record import RECORDS as ADAPTERS
        from .cards.record import RECORDS as CARDS
        from .drives.record import RECORDS as DRIVES

        return {record.name: record for record in (AMCI3601, *ADAPTERS, *DRIVES, *CARDS)}

    def __getitem__(self, name: str) -> ModuleRecord:
        return AMCI3601 if name == AMCI3601.name else self._all[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)


OWN = OwnModules()
"""Scanrack's own modules by catalog name."""


@cache
def _installed() -> Mapping[str, EntryPoint]:
    """Return the entry points of installed packages by catalog name, except scanrack's own names."""
    from importlib.metadata import entry_points  # importing it loads all of `email`

    return {point.name: point for point in entry_points(group=GROUP) if point.name not in OWN}


@cache
def _record_of(name: str) -> ModuleRecord:
    """Import an installed package, and return its record.

    Raises:
        ValueError: the import fails, or the package has no record with this name.
    """
    point = _installed()[name]
    try:
        record = point.load()
    except Exception as error:  # an import of foreign code can raise anything
        raise ValueError(f"module {name}: {point.value} can't be imported: {error}") from error
    if not isinstance(record, ModuleRecord) or record.name != name:
        raise ValueError(f"module {name}: {point.value} is not the ModuleRecord of this name")
    return record


class Registry(Mapping[str, ModuleRecord]):
    """The modules by catalog name; an installed package is imported on first use."""

    def __init__(self) -> None:
        self._added: dict[str, ModuleRecord] = {}

    def add(self, record: ModuleRecord) -> None:
        """Add the module of a rack built in Python; raise ValueError if another module has its name."""
        if record.name not in self:
            self._added[record.name] = record
        elif self[record.name] is not record:
            raise ValueError(f"module {record.name}: another module has this name")

    def __getitem__(self, name: str) -> ModuleRecord:
        if name in self._added:
            return self._added[name]
        if name in OWN:
            return OWN[name]
        if name in _installed():
            return _record_of(name)
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return iter([*OWN, *self._added, *_installed()])

    def __len__(self) -> int:
        return len(OWN) + len(self._added) + len(_installed())

    def __contains__(self, name: object) -> bool:
        return name in self._added or name in OWN or name in _installed()


MODULES = Registry()
"""The modules by catalog name."""


def words_of(module: str, options: Options) -> ModuleWords:
    """Return the names of a module's words and bits, or plain names for an unknown module."""
    return MODULES[module].words(options) if module in MODULES else PLAIN_WORDS


def live_port(module: str, live: LivePort | None, port: str, address: int | None) -> LivePort:
    """Check the port and address, and return the live port of a module.

    Args:
        port: a serial device, or tcp:HOST:PORT.
        address: address of the device, or None for the factory setting.

    Raises:
        ValueError: an invalid port or address, or a module without a port.
    """
    from ..line.liveport import check_address  # imports pyserial, which few racks need

    check_address(port)
    if live is None:
        modules = ", ".join(name for name, record in OWN.items() if record.live is not None)
        raise SettingError("port", f"port {port}: {module} has no port; only {modules} can use one")
    live.check_address(address)
    return live
