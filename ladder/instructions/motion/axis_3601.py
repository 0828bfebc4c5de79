"""The axis of a 3601 in a scan: its tag, the block that owns the module's words, and its units."""

from __future__ import annotations

import math
from dataclasses import replace

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.thousands import PARAMETER_MAX

from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.arithmetic import wrap
from ...model.operands import Group, constant
from .axes import AxisSettings
from .motion_control import AXIS_FAULT, OUT_OF_RANGE, SERVO_OFF, SHUT_DOWN, MotionControl, MotionError

ABSOLUTE, RELATIVE, VELOCITY, HOME, HALT, RESET, SET_POSITION, CONFIGURE = 1, 2, 3, 4, 5, 7, 8, 14
"""Kinds of requests, see `axis3601.rung`."""

COMMANDS = {ABSOLUTE: 1, RELATIVE: 2, HOME: 32, RESET: 2048, SET_POSITION: 512, HALT: 0}
"""Command word of each request; searches in CCW direction have 64, manual moves have 128 or 256."""

STANDSTILL, ERROR_STOP = 1, 6
"""States of the axis."""


@dataclass(frozen=True, slots=True)
class BoundAxis:
    """An axis of a program and its 3601."""

    settings: AxisSettings  # the axis's table in the rack file
    tag: Group  # the axis
    state: Group  # the block's AXIS_3601


class Axis:
    """A bound axis in a scan."""

    def __init__(self, machine: Interpreter, bound: BoundAxis) -> None:
        self.machine, self.settings = machine, bound.settings
        self._state = bound.state
        self.tag, self.state = Members(machine, bound.tag), Members(machine, bound.state)

    def word(self, number: int) -> int:
        """Return an input word of the module."""
        place = self._state.member("In")
        return int(self.machine.get(replace(place, indices=(constant(number),))))

    @property
    def words(self) -> list[int]:
        """The output words of the last request."""
        place = self._state.member("Words")
        return [int(self.machine.get(replace(place, indices=(constant(number),)))) for number in range(8)]

    @property
    def status(self) -> int:
        """The PLCopen state of the axis: 0 disabled, 1 standstill, 6 error stop."""
        return int(self.state["State"])

    def request(self, motion: MotionControl, kind: int, *words: int) -> None:
        """Send a request of a kind with output words; it replaces the previous one of `motion`."""
        ticket = wrap(int(self.state["Ticket"]) + 1, 32)
        self.state.set(Ticket=ticket, Kind=kind)
        place = self._state.member("Words")
        for number in range(8):
            value = words[number] if number < len(words) else 0
            self.machine.put(replace(place, indices=(constant(number),)), wrap(value, 16))
        motion.ticket = ticket

    @property
    def under_way(self) -> int:
        """Kind of the request that is running or waiting; 0 if there is none."""
        if self.state["Ticket"] != self.state["Taken"]:
            return int(self.state["Kind"])
        return int(self.state["RunKind"]) if int(self.state["Step"]) in (1, 2) else 0

    def check_ready(self) -> None:
        """Raise a MotionError if the axis accepts no motion at present."""
        if self.tag["ShutdownStatus"]:
            raise MotionError(SHUT_DOWN)
        if not self.tag["ServoActionStatus"]:
            raise MotionError(SERVO_OFF)
        if self.status in (0, ERROR_STOP):
            raise MotionError(AXIS_FAULT)

    # --- numbers, which raise a MotionError if they do not fit in the module's words

    def steps(self, units: float) -> int:
        """Return a position or distance in steps."""
        value = units * self.settings.counts_per_unit
        if not abs(value) <= PARAMETER_MAX:
            raise MotionError(OUT_OF_RANGE)
        return round(value)

    def speed(self, value: float, unit: str) -> int:
        """Return a speed in steps/s."""
        if unit == "%OFMAXIMUM":
            value *= (self.settings.max_speed or float(self.tag["MaximumSpeed"])) / 100
        return _within(value * self.settings.counts_per_unit, self.settings.limits.speed)

    def rate(self, value: float, unit: str) -> int:
        """Return an acceleration in steps/ms/s."""
        if unit == "%OFMAXIMUM":
            value *= self.maximum() / 100
        return _within(value * self.settings.counts_per_unit / 1000, self.settings.limits.rate)

    def maximum(self) -> float:
        """Return 100 % of maximum, units/s²."""
        return self.settings.max_acceleration or float(self.tag["MaximumAcceleration"])


def _within(value: float, most: int) -> int:
    if not (math.isfinite(value) and 1 <= round(value) <= most):
        raise MotionError(OUT_OF_RANGE)
    return round(value)


def show(axis: Axis) -> None:
    """Update the tag from the module's inputs, after each scan."""
    state, tag, machine = axis.state, axis.tag, axis.machine
    position = int(state["Position"]) / axis.settings.counts_per_unit
    seconds = (machine.now_ns - int(tag["~shown_ns"])) / 1e9
    velocity = (position - float(tag["~position"])) / seconds if seconds > 0 else 0.0
    tag.set(
        ActualPosition=position,
        CommandPosition=position,
        ActualVelocity=velocity,
        CommandVelocity=velocity,
        AverageVelocity=velocity,
        **{"~position": position, "~shown_ns": machine.now_ns},
    )
    moving = int(state["RunKind"]) if int(state["Step"]) in (1, 2) else None
    present, word = axis.status != 0, axis.word(0)
    lost = not present and axis.tag["ServoActionStatus"]
    if lost:
        axis.tag.set(ServoActionStatus=False, DriveEnableStatus=False)
    axis.tag.set(
        MoveStatus=moving in (ABSOLUTE, RELATIVE),
        JogStatus=moving == VELOCITY,
        HomingStatus=moving == HOME,
        StoppingStatus=int(state["Step"]) == 3,
        AxisHomedStatus=present and not word >> 10 & 1,
        AccelStatus=present and bool(word >> 5 & 1),
        DecelStatus=present and bool(word >> 6 & 1),
        PhysicalAxisFault=axis.status == ERROR_STOP,
        ModuleFault=lost or (not present and axis.tag["ModuleFault"]),
    )
