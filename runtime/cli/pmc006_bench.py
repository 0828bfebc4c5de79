"""The simulated PMC006x3s on the bench of `scanrack drive pmc006`."""

from __future__ import annotations

from collections.abc import Collection
from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...io_images.pmc006.frame import FACTORY_ADDRESS
from ...io_images.pmc006.program import assemble
from ..events import JsonValue
from ..pmc006.controller import Controller
from ..pmc006.line import Pmc006
from ..pmc006.pins import Pin, Switch
from .requests import Strict
from .wire_bench import WireBench

Steps = Annotated[int, Field(strict=True)]


class Options(Strict):
    """Options of a fresh bench."""

    address: Annotated[int, Field(strict=True)] = FACTORY_ADDRESS
    program: str | None = None


class Follows(Strict):
    """A switch that the motor passes: high up to a position, or from one on."""

    high_when_pos_le: Steps | None = None
    high_when_pos_ge: Steps | None = None
    otherwise: Annotated[Literal["low"], Field(alias="else")] = "low"

    @model_validator(mode="after")
    def _one_end(self) -> Follows:
        if (self.high_when_pos_le is None) == (self.high_when_pos_ge is None):
            raise ValueError("needed is one of high_when_pos_le and high_when_pos_ge")
        return self

    def switch(self) -> Switch:
        """Return the switch that is meant."""
        if self.high_when_pos_le is not None:
            return Switch(self.high_when_pos_le, True)
        assert self.high_when_pos_ge is not None
        return Switch(self.high_when_pos_ge - 1, False)


PinLevel = Literal["low", "high"] | Follows | None


class Env(Strict):
    """Levels of the pins from now on."""

    ext1: PinLevel = None
    ext2: PinLevel = None
    fset: PinLevel = None
    gpio8: PinLevel = None
    """Without effect: it is an output."""


PINS = {"ext1": Pin.EXT1, "ext2": Pin.EXT2, "fset": Pin.FSET}


class Pmc006Target:
    """A controller with its pins within reach.

    Args:
        options: of the bench.

    Raises:
        ValueError: a program that does not assemble, or no such address.
    """

    silence_ns = 300_000_000
    signals: Collection[str] = ("physical_position", "gpio8", "coil_duty")
    has_reset = False
    quiet_ns = 0

    def __init__(self, options: Options) -> None:
        try:
            program = assemble(options.program or "")
        except ValueError as error:
            raise ValueError(f"program: {error}") from None
        self._controller = Controller(address=options.address, program=program)
        self.device = Pmc006(self._controller)

    @property
    def position(self) -> int:
        """Physical position, steps."""
        return self._controller.axis.physical

    def power_cycle(self, now_ns: int) -> None:
        """Remove and restore power."""
        self.device.power_cycle()

    def reset(self, now_ns: int) -> None:
        """There is no reset button."""

    def set_env(self, now_ns: int, env: Env) -> None:
        """Set the levels of pins."""
        for name, pin in PINS.items():
            level: PinLevel = getattr(env, name)
            if level is not None:
                high = level.switch() if isinstance(level, Follows) else level == "high"
                self._controller.set_pin(pin, high)

    def observe(self, name: str) -> JsonValue:
        """Return a signal."""
        if name == "physical_position":
            return self.position
        if name == "gpio8":
            return "high" if self._controller.gpio8 else "low"
        return self._controller.coil_percent


def pmc006_bench() -> WireBench[Options, Env]:
    """Return the bench of `drive pmc006`."""
    return WireBench(Pmc006Target, Options, Env)
