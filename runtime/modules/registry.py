"""The registry of modules: the records of their folders."""

from __future__ import annotations

from ...io_images.module_words import PLAIN_WORDS, ModuleWords
from ...io_images.site import SettingError
from .adapters.record import RECORDS as ADAPTERS
from .amci3601.record import RECORD as AMCI3601
from .cards.record import RECORDS as CARDS
from .record import LivePort, ModuleRecord, Options, Trait

MODULES: dict[str, ModuleRecord] = {
    record.name: record
    for record in (
        AMCI3601,
        *ADAPTERS,
        *CARDS,
    )
}
"""The modules by catalog name; a rack in Python may add its own before it is built."""


def has(module: str, trait: Trait) -> bool:
    """Return whether a kind of module has a trait; an unknown one has none."""
    return module in MODULES and trait in MODULES[module].traits


def words_of(module: str, options: Options) -> ModuleWords:
    """Return the names of a module's words and bits; plain ones for an unknown module."""
    return MODULES[module].words(options) if module in MODULES else PLAIN_WORDS


def live_port(module: str, port: str, address: int | None) -> LivePort:
    """Return the live port of a module after a check of port and address.

    Args:
        port: a serial device, or tcp:HOST:PORT.
        address: of the controller; None = the factory's.

    Raises:
        ValueError: an illegal port or address, or a module without a live port.
    """
    from ..line.liveport import check_address  # imports pyserial, which few racks need

    check_address(port)
    live = MODULES[module].live
    if live is None:
        can = ", ".join(name for name, record in MODULES.items() if record.live is not None)
        raise SettingError("port", f"port {port}: {module} has no port; only {can} can use one")
    live.check_address(address)
    return live
