"""The registry record of the PMC006 adapter; slow imports wait until they are needed."""

from __future__ import annotations

from .....io_images.pmc006.frame import FACTORY_ADDRESS
from ....loop.module import Module
from ....machine import Machine
from ...record import LiveModule, LivePort, Options
from ..record import adapter_record


def _made(machine: Machine, options: Options) -> Module:
    from .module import Pmc006Adapter

    return Pmc006Adapter(machine, options)


def _opened(port: str, address: int, options: Options) -> LiveModule:
    from ..live import open_adapter
    from .driver import LINE_FORMAT
    from .module import kit
    from .options import Pmc006Options

    return open_adapter(port, LINE_FORMAT, kit(Pmc006Options.of(options), address))


def _refusals() -> str:
    from ..table import refusals

    return refusals("PMC006")


RECORD = adapter_record(
    "pmc006-adapter",
    _made,
    LivePort(opened=_opened, factory_address=FACTORY_ADDRESS, highest_address=120),
    _refusals,
)
