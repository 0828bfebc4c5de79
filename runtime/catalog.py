"""The catalog: what can be put into a slot, by the name a rack file calls it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..io_images.amci3601.firmware import Firmware
from .events import JsonValue
from .machine import Machine, MachineSpec
from .module import Module

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


CATALOG: dict[str, Factory] = {"amci3601": make_amci3601}
"""The modules by catalog name; a rack in Python may add its own before it is built."""


def check_controller(module: str, firmware: str, controller: str) -> None:
    """Refuse a module that does not run behind a controller, with a ValueError.

    A 3601 needs firmware 2.2 behind a MicroLogix 1500 [chapter 1, MicroLogix 1500 Configuration].
    """
    if module == "amci3601" and controller == "micrologix" and not Firmware.parse(firmware).micrologix:
        raise ValueError(f"firmware {firmware} does not run in a MicroLogix rack: 2.2 or later does")
