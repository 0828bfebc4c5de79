"""The simulated PMC006x3s on the bench of `scanrack drive pmc006`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from pydantic import Field, field_validator
from scanrack.io_images.pmc006.frame import FACTORY_ADDRESS
from scanrack.io_images.pmc006.program import assemble
from scanrack.runtime.controllers.pmc006.controller import Pmc006Controller
from scanrack.runtime.controllers.pmc006.line import Pmc006
from scanrack.runtime.controllers.pmc006.pins import Pin
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.machine.contacts import Contact

from .requests import Strict
from .wire_bench import WireBench, WireTarget, pin_state


class Pmc006BenchOptions(Strict):
    """Options of a fresh bench."""

    address: Annotated[int, Field(strict=True)] = FACTORY_ADDRESS
    program: str | None = None


LEVELS: dict[str, bool | Contact] = {"low": False, "high": True}
FOLLOWERS: dict[str, Callable[[int], bool | Contact]] = {
    "high_when_pos_le": lambda position: Contact(low=position + 1),
    "high_when_pos_ge": lambda position: Contact(high=position - 1),
}
FORMS = '"low", "high", {"high_when_pos_le": N, "else": "low"} and the same with ge, N a number of steps'


class Pmc006Env(Strict):
    """New levels of the pins; None leaves a pin unchanged."""

    ext1: Any = None
    ext2: Any = None
    fset: Any = None
    gpio8: Any = None
    """No effect, because the pin is an output."""

    @field_validator("*")
    @classmethod
    def _pin(cls, value: Any) -> bool | Contact:
        if isinstance(value, dict):
            value = {key: position for key, position in value.items() if (key, position) != ("else", "low")}
        return pin_state(value, LEVELS, FOLLOWERS, FORMS)


PINS = {"ext1": Pin.EXT1, "ext2": Pin.EXT2, "fset": Pin.FSET}


def _target(options: Pmc006BenchOptions) -> WireTarget[Pmc006Env]:
    """Return a controller on the bench; raise ValueError for a wrong program or address."""
    try:
        program = assemble(options.program or "")
    except ValueError as error:
        raise ValueError(f"program: {error}") from None
    controller = Pmc006Controller(address=options.address, program=program)
    device = Pmc006(controller)

    def set_env(_now_ns: int, env: Pmc006Env) -> None:
        for name, pin in PINS.items():
            level: bool | Contact | None = getattr(env, name)
            if level is not None:
                controller.set_pin(pin, level)

    signals: dict[str, Callable[[], JsonValue]] = {
        "physical_position": lambda: device.motor_position,
        "gpio8": lambda: "high" if controller.gpio8 else "low",
        "coil_duty": lambda: controller.coil_percent,
    }
    return WireTarget(device, signals, set_env, silence_ns=300_000_000)


def pmc006_bench() -> WireBench[Pmc006BenchOptions, Pmc006Env]:
    """Return the bench of `drive pmc006`."""
    return WireBench(_target, Pmc006BenchOptions, Pmc006Env)
