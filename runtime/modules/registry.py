"""The catalog: what can be put into a slot, by the name a rack file calls it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ...io_images.amci3601.firmware import Firmware
from ..loop.events import JsonValue
from ..loop.module import Module
from ..machine import Machine, MachineSpec

Factory = Callable[..., Module]
"""Makes a module of (firmware, machine, seed, options, wiring); ValueError names what it can't take."""


def make_amci3601(
    firmware: str,
    machine: MachineSpec,
    seed: int,
    options: Mapping[str, JsonValue],
    wiring: str | None,
) -> Module:
    """Make a simulated 3601 bolted to a machine.

    Args:
        firmware: its version.
        machine: what the machine consists of.
        seed: of what is left to chance in the machine.
        options: model switches by name.
        wiring: "diagnostic" for step outputs wired to the encoder inputs.

    Raises:
        ValueError: an unknown firmware or option.
    """
    from .amci3601 import Amci3601

    return Amci3601(firmware, Machine(machine, seed), options, diagnostic_wiring=wiring == "diagnostic")


def _without_firmware(module: str, firmware: str, wiring: str | None) -> None:
    """Refuse what an adapter has no choice of: it answers as firmware 4.1, and has no such wiring."""
    if firmware != "4.1":
        raise ValueError(f"firmware {firmware}: {module} answers as 4.1")
    if wiring is not None:
        raise ValueError(f"wiring {wiring}: {module} has none; leave it out")


def make_pcl601_adapter(
    firmware: str,
    machine: MachineSpec,
    seed: int,
    options: Mapping[str, JsonValue],
    wiring: str | None,
) -> Module:
    """Make a simulated PCL601 that answers as a 3601; arguments as for `make_amci3601`."""
    from .adapters.pcl601.module import Pcl601Adapter

    _without_firmware("pcl601-adapter", firmware, wiring)
    return Pcl601Adapter(Machine(machine, seed), options)


def make_pmc006_adapter(
    firmware: str,
    machine: MachineSpec,
    seed: int,
    options: Mapping[str, JsonValue],
    wiring: str | None,
) -> Module:
    """Make a simulated PMC006x3s that answers as a 3601; arguments as for `make_amci3601`."""
    from .adapters.pmc006.module import Pmc006Adapter

    _without_firmware("pmc006-adapter", firmware, wiring)
    return Pmc006Adapter(Machine(machine, seed), options)


CATALOG: dict[str, Factory] = {
    "amci3601": make_amci3601,
    "pcl601-adapter": make_pcl601_adapter,
    "pmc006-adapter": make_pmc006_adapter,
}
"""The modules by catalog name; a rack in Python may add its own before it is built."""


def check_controller(module: str, firmware: str, controller: str) -> None:
    """Refuse a module that does not run behind a controller, with a ValueError.

    A 3601 needs firmware 2.2 behind a MicroLogix 1500 [chapter 1, MicroLogix 1500 Configuration].
    """
    if module == "amci3601" and controller == "micrologix" and not Firmware.parse(firmware).micrologix:
        raise ValueError(f"firmware {firmware} does not run in a MicroLogix rack: 2.2 or later does")
