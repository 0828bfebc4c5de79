"""The simulated PMC006x3s on the bench of `scanrack drive pmc006`."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Annotated, Any

from pydantic import Field, field_validator

from ...io_images.pmc006.frame import FACTORY_ADDRESS
from ...io_images.pmc006.program import assemble
from ...runtime.controllers.pmc006.controller import Pmc006Controller
from ...runtime.controllers.pmc006.line import Pmc006
from ...runtime.controllers.pmc006.pins import Pin, SwitchPin
from ...runtime.loop.events import JsonValue
from .requests import Strict
from .wire_bench import WireBench


class Pmc006BenchOptions(Strict):
    """Options of a fresh bench."""

    address: Annotated[int, Field(strict=True)] = FACTORY_ADDRESS
    program: str | None = None


LEVELS = {"low": False, "high": True}
FOLLOWERS: dict[str, Callable[[int], SwitchPin]] = {
    "high_when_pos_le": lambda position: SwitchPin(position, True),
    "high_when_pos_ge": lambda position: SwitchPin(position - 1, False),
}
FORMS = '"low", "high", {"high_when_pos_le": N, "else": "low"} and the same with ge, N a number of steps'


def _level(value: Any) -> bool | SwitchPin:
    """Return the level or switch of a pin's value.

    Raises:
        ValueError: an illegal value.
    """
    if isinstance(value, str) and value in LEVELS:
        return LEVELS[value]
    if isinstance(value, dict):
        rest = {key: position for key, position in value.items() if (key, position) != ("else", "low")}
        [(key, position)] = rest.items() if len(rest) == 1 else [("", None)]
        if key in FOLLOWERS and isinstance(position, int) and not isinstance(position, bool):
            return FOLLOWERS[key](position)
    raise ValueError(f"allowed are {FORMS}")


class Pmc006Env(Strict):
    """Levels of the pins from now on; None leaves a pin unchanged."""

    ext1: Any = None
    ext2: Any = None
    fset: Any = None
    gpio8: Any = None
    """Without effect: it is an output."""

    @field_validator("*")
    @classmethod
    def _understood(cls, value: Any) -> bool | SwitchPin:
        return _level(value)


PINS = {"ext1": Pin.EXT1, "ext2": Pin.EXT2, "fset": Pin.FSET}


class Pmc006Target:
    """A controller with accessible pins.

    Raises:
        ValueError: a program that does not assemble, or an illegal address.
    """

    silence_ns = 300_000_000
    signals: Collection[str] = ("physical_position", "gpio8", "coil_duty")
    has_reset = False
    quiet_ns = 0

    def __init__(self, options: Pmc006BenchOptions) -> None:
        try:
            program = assemble(options.program or "")
        except ValueError as error:
            raise ValueError(f"program: {error}") from None
        self._controller = Pmc006Controller(address=options.address, program=program)
        self.device = Pmc006(self._controller)

    @property
    def position(self) -> int:
        """Physical position, steps."""
        return self._controller.axis.physical

    def power_cycle(self, now_ns: int) -> None:
        """Remove and restore power."""
        self.device.power_cycle()

    def reset(self, now_ns: int) -> None:
        """Do nothing: there is no reset button."""

    def set_env(self, now_ns: int, env: Pmc006Env) -> None:
        """Set the levels of pins."""
        for name, pin in PINS.items():
            level: bool | SwitchPin | None = getattr(env, name)
            if level is not None:
                self._controller.set_pin(pin, level)

    def observe(self, name: str) -> JsonValue:
        """Return a signal."""
        if name == "physical_position":
            return self.position
        if name == "gpio8":
            return "high" if self._controller.gpio8 else "low"
        return self._controller.coil_percent


def pmc006_bench() -> WireBench[Pmc006BenchOptions, Pmc006Env]:
    """Return the bench of `drive pmc006`."""
    return WireBench(Pmc006Target, Pmc006BenchOptions, Pmc006Env)
