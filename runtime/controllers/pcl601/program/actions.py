"""Actions for the instructions: tables of registers and command codes, and a few short functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from scanrack.io_images.pcl601.program import Step
from scanrack.io_images.pcl601.registers import Register

from ..stored import Axis601

Action = Callable[[Axis601, Step], bool]
"""Function that carries out a step and returns whether the controller accepts it."""

REGISTERS: Mapping[str, Register] = {
    "ACCEL": Register.ACCEL,
    "BASE": Register.BASE_SPEED,
    "MAX": Register.MAX_SPEED,
    "JOG": Register.JOG_SPEED,
    "SETPOS": Register.POSITION,
    "DIR": Register.DIRECTION,
    "CURRENT": Register.MOTOR_CURRENT,
    "THUMB": Register.THUMBWHEEL_ENABLE,
    "ENC": Register.ENCODER_AUTOCORRECT,
    "ENCDELAY": Register.ENCODER_DELAY,
    "ENCRATIO": Register.ENCODER_RATIO,
    "ENCRETRIES": Register.ENCODER_RETRIES,
    "ENCWINDOW": Register.ENCODER_WINDOW,
    "ASPEEDLO": Register.ANALOG_SPEED_LOWER,
    "ASPEEDHI": Register.ANALOG_SPEED_UPPER,
    "APOSLO": Register.ANALOG_POS_LOWER,
    "APOSHI": Register.ANALOG_POS_UPPER,
    "OOTF": Register.OUTPUT_ON_FLY,
    "OOTFPOS": Register.FIRST_OUTPUT_POSITION,
    "OOTFSTEP": Register.STEPS_BETWEEN_OUTPUTS,
    "OOTFCOUNT": Register.NUMBER_OF_OUTPUTS,
    "IOTF": Register.INDEX_ON_FLY,
    "REGINDEX": Register.STEPS,
}
"""The register that each instruction writes."""

COMMANDS: Mapping[str, int] = {
    "HOME0": 2,
    "HOME1": 3,
    "SLEW": 4,
    "STOPHARD": 5,
    "STOPSOFT": 6,
    "SETASPEED": 7,
    "ENCRESET": 15,
}
"""The command code of each instruction [section 4]."""


def _parameter(register: Register) -> Action:
    return lambda axis, step: axis.write(register, int(step.values[0]))


def _command(code: int) -> Action:
    return lambda axis, _step: axis.command(code)


ACTIONS: Mapping[str, Action] = {
    **{name: _parameter(register) for name, register in REGISTERS.items()},
    **{name: _command(code) for name, code in COMMANDS.items()},
    "MOVE": lambda axis, step: axis.move(int(step.values[0])),
    "MOVETO": lambda axis, step: axis.move_to(int(step.values[0])),
    "REPEAT": lambda axis, _step: axis.repeat(),
    "MOVETHUMB": lambda axis, _step: axis.move_thumbwheel(),
    "GOTOAPOS": lambda axis, _step: axis.move_to_analog(),
    "ASPEED": lambda axis, step: axis.set_analog(speed=step.values[0] == 1),
    "APOS": lambda axis, step: axis.set_analog(position=step.values[0] == 1),
    "OUTPUTS": lambda axis, step: axis.set_outputs(int(step.values[0])),
    "TEXT": lambda axis, step: axis.send_text(str(step.values[0])),
}
"""Actions on the axis; `machine` carries out the flow control instructions."""
