"""The simulated PCL601 on the bench of `scanrack drive pcl601`."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from decimal import Decimal
from fractions import Fraction
from functools import partial
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator, model_validator

from ...io_images.pcl601 import NO_ERROR, Register
from ...io_images.pcl601.program import parse_program
from ...io_images.pcl601.terminals import INPUTS, OUTPUT_COUNT
from ...runtime.controllers.pcl601.line import Pcl601
from ...runtime.controllers.pcl601.motor import EncoderKind, EncoderModel
from ...runtime.controllers.pcl601.pins import FULL_SCALE_VOLTS, GROUND, OPEN, Contact
from ...runtime.controllers.pcl601.program import load
from ...runtime.controllers.pcl601.wiring import Wiring
from ...runtime.loop.events import JsonValue
from .requests import Strict
from .wire_bench import WireBench

Whole = Annotated[int, Field(strict=True)]


class EncoderOptions(Strict):
    """An encoder on the motor's shaft."""

    ratio: Annotated[int, Field(strict=True, ge=1)] = 1
    model: EncoderKind = "ideal"
    steps: Annotated[int, Field(strict=True, ge=0)] = 0


class Pcl601BenchOptions(Strict):
    """Options of a fresh bench."""

    address: Annotated[int, Field(strict=True, ge=0, le=99)] = 1
    program: str | None = None
    sw2: Literal["IN56", "TWS"] = "IN56"
    thumbwheel: Annotated[str, Field(pattern="^[0-9]{7}$")] | None = None
    encoder: EncoderOptions | None = None


LEVELS: Mapping[str, Contact] = {"ground": GROUND, "open": OPEN, "high": OPEN}
FOLLOWERS: Mapping[str, Callable[[int], Contact]] = {
    "ground_when_pos_ge": lambda position: Contact(low=position),
    "ground_when_pos_le": lambda position: Contact(high=position),
}
PIN_FORMS = (
    '"ground", "open", "high", {"ground_when_pos_ge": N} and {"ground_when_pos_le": N}, N a number of steps'
)


def _contact(value: Any) -> Contact:
    """Return the contact of a pin's value.

    Raises:
        ValueError: it is not an address.
    """
    if isinstance(value, str) and value in LEVELS:
        return LEVELS[value]
    if isinstance(value, dict) and len(value) == 1:
        [(key, position)] = value.items()
        if key in FOLLOWERS and isinstance(position, int) and not isinstance(position, bool):
            return FOLLOWERS[key](position)
    raise ValueError(f"allowed are {PIN_FORMS}")


class Pcl601Env(Strict):
    """Pins and voltages from now on."""

    in1: Any = None
    in2: Any = None
    in3: Any = None
    in4: Any = None
    in5: Any = None
    in6: Any = None
    home: Any = None
    jog_plus: Any = None
    jog_minus: Any = None
    fast_jog: Any = None
    hard_plus: Any = None
    hard_minus: Any = None
    soft_plus: Any = None
    soft_minus: Any = None
    in1_volts: Annotated[Decimal, Field(ge=0, le=FULL_SCALE_VOLTS)] | None = None
    encoder_counts: Whole | None = None

    @model_validator(mode="before")
    @classmethod
    def _last_of_input_1(cls, data: Any) -> Any:
        """Keep the last of two keys that set input 1."""
        both = [key for key in data if key in ("in1", "in1_volts")] if isinstance(data, dict) else []
        return {key: data[key] for key in data if key not in both[:-1]} if both else data

    @field_validator(*INPUTS, mode="before")
    @classmethod
    def _pin(cls, value: Any, field: ValidationInfo) -> Contact:
        return GROUND if (field.field_name, value) == ("in1", "open") else _contact(value)


class Pcl601Target:
    """A controller with accessible pins.

    Raises:
        ValueError: a program that does not assemble.
    """

    silence_ns = 200_000_000
    has_reset = True

    def __init__(self, options: Pcl601BenchOptions) -> None:
        encoder = EncoderModel(**options.encoder.model_dump()) if options.encoder is not None else None
        digits = int(options.thumbwheel) if options.thumbwheel is not None else None
        self.device = Pcl601(options.address, encoder, Wiring(options.sw2 == "TWS", digits))
        if options.program is not None:
            load(self.device.controller, parse_program(options.program))
        self._signals = self._signal_table()
        self.signals: Collection[str] = tuple(self._signals)

    @property
    def quiet_ns(self) -> int:
        """Silence that the controller needs at present before a frame."""
        return self.device.quiet_ns

    @property
    def position(self) -> int:
        """Physical position, steps."""
        return self.device.controller.motor.position

    def power_cycle(self, now_ns: int) -> None:
        """Remove and restore power."""
        self.device.power_cycle(now_ns)

    def reset(self, now_ns: int) -> None:
        """Press the reset button."""
        self.device.power_cycle(now_ns)

    def set_env(self, now_ns: int, env: Pcl601Env) -> None:
        """Set pins, the voltage on input 1, the encoder register."""
        controller = self.device.controller
        for name in INPUTS:
            if getattr(env, name) is not None:
                controller.pins.connect(name, getattr(env, name))
        if env.in1_volts is not None:
            controller.pins.apply_volts(Fraction(env.in1_volts))
        if env.encoder_counts is not None:
            controller.values[Register.ENCODER_POSITION] = env.encoder_counts
        controller.settle(now_ns)

    def observe(self, name: str) -> JsonValue:
        """Return a signal."""
        return self._signals[name]()

    def _signal_table(self) -> dict[str, Callable[[], JsonValue]]:
        controller = self.device.controller
        outputs = {
            f"output{bit + 1}": partial(lambda bit: _on_off(controller.output_pins >> bit & 1), bit)
            for bit in range(OUTPUT_COUNT)
        }
        return {
            "position": lambda: self.position,
            **outputs,
            "output1_pulse_positions": lambda: list(controller.axis.fly.positions),
            "driver_on_off": lambda: _on_off(controller.values[Register.MOTOR_CURRENT]),
            "led": lambda: "green" if controller.errors == NO_ERROR else "red",
            "encoder_counts": lambda: controller.values[Register.ENCODER_POSITION],
        }


def _on_off(bit: int) -> str:
    return "on" if bit else "off"


def pcl601_bench() -> WireBench[Pcl601BenchOptions, Pcl601Env]:
    """Return the bench of `drive pcl601`."""
    return WireBench(Pcl601Target, Pcl601BenchOptions, Pcl601Env, {("new", "encoder"): EncoderOptions})
