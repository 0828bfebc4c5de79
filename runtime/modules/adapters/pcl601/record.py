"""The registry record of the PCL601 adapter; slow imports wait until they are needed."""

from __future__ import annotations

from ....loop.module import Module
from ....machine import Machine
from ...record import LiveModule, LivePort, Options
from ..record import adapter_record


def _made(machine: Machine, options: Options) -> Module:
    from .module import Pcl601Adapter

    return Pcl601Adapter(machine, options)


def _opened(port: str, address: int, options: Options) -> LiveModule:
    from ..live import open_adapter
    from .driver import LINE_FORMAT
    from .module import kit
    from .options import Pcl601Options

    return open_adapter(port, LINE_FORMAT, kit(Pcl601Options.of(options), address))


def _refusals() -> str:
    from ..table import refusals

    return refusals("PCL601")


RECORD = adapter_record(
    "pcl601-adapter",
    _made,
    LivePort(opened=_opened, factory_address=1, highest_address=99),
    _refusals,
)
