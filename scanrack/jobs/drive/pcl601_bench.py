"""The simulated PCL601 on the bench of `scanrack drive pcl601`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from decimal import Decimal
from fractions import Fraction
from functools import partial
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator, model_validator
from scanrack.io_images.pcl601 import NO_ERROR, Register
from scanrack.io_images.pcl601.program import parse_program
from scanrack.io_images.pcl601.terminals import INPUTS, OUTPUT_COUNT
from scanrack.runtime.controllers.pcl601.controller import Pcl601Controller
from scanrack.runtime.controllers.pcl601.line import Pcl601
from scanrack.runtime.controllers.pcl601.motor import EncoderKind, EncoderModel
from scanrack.runtime.controllers.pcl601.pins import FULL_SCALE_VOLTS
from scanrack.runtime.controllers.pcl601.program import load
from scanrack.runtime.controllers.pcl601.wiring import Wiring
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.machine.contacts import GROUND, OPEN, Contact

from .requests import Strict
from .wire_bench import WireBench, WireTarget, pin_state

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


class Pcl601Env(Strict):
    """New states of pins and voltages; None = unchanged."""

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
        """Remove the first of two keys that set input 1."""
        if not isinstance(data, dict) or not {"in1", "in1_volts"} <= data.keys():
            return data
        first_key = next(key for key in data if key in ("in1", "in1_volts"))
        return {key: value for key, value in data.items() if key != first_key}

    @field_validator(*INPUTS, mode="before")
    @classmethod
    def _pin(cls, value: Any, field: ValidationInfo) -> Contact:
        if (field.field_name, value) == ("in1", "open"):  # an open input 1 reads as grounded
            return GROUND
        return pin_state(value, LEVELS, FOLLOWERS, PIN_FORMS)


def _target(options: Pcl601BenchOptions) -> WireTarget[Pcl601Env]:
    """Return a controller on the bench; raise ValueError if its program does not assemble."""
    encoder = EncoderModel(**options.encoder.model_dump()) if options.encoder is not None else None
    digits = int(options.thumbwheel) if options.thumbwheel is not None else None
    device = Pcl601(options.address, encoder, Wiring(options.sw2 == "TWS", digits))
    if options.program is not None:
        load(device.controller, parse_program(options.program))
    return WireTarget(
        device,
        _signals(device),
        partial(_set_env, device.controller),
        silence_ns=200_000_000,
        quiet_ns=lambda: device.quiet_ns,
        has_reset=True,
    )


def _set_env(controller: Pcl601Controller, now_ns: int, env: Pcl601Env) -> None:
    """Set the pins, the voltage on input 1, and the encoder register."""
    for name in INPUTS:
        if getattr(env, name) is not None:
            controller.pins.connect(name, getattr(env, name))
    if env.in1_volts is not None:
        controller.pins.apply_volts(Fraction(env.in1_volts))
    if env.encoder_counts is not None:
        controller.values[Register.ENCODER_POSITION] = env.encoder_counts
    controller.settle(now_ns)


def _signals(device: Pcl601) -> dict[str, Callable[[], JsonValue]]:
    """Return functions that read the observable signals of a controller, by name."""
    controller = device.controller

    def output(bit: int) -> str:
        return _on_off(controller.output_pins >> bit & 1)

    outputs = {f"output{bit + 1}": partial(output, bit) for bit in range(OUTPUT_COUNT)}
    return {
        "position": lambda: device.motor_position,
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
    return WireBench(_target, Pcl601BenchOptions, Pcl601Env)
