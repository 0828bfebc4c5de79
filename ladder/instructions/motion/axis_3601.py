"""A 3601's axis in a scan: its tag, the block that owns the module's words, and its units."""

from __future__ import annotations

import math
from dataclasses import replace

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.thousands import PARAMETER_MAX

from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.arithmetic import wrap
from ...model.operands import Group, Place, constant
from .axes import WORDS, AxisSettings
from .motion_control import AXIS_FAULT, OUT_OF_RANGE, SERVO_OFF, SHUT_DOWN, MotionControl, MotionError

ABSOLUTE, RELATIVE, VELOCITY, HOME, HALT, RESET, SET_POSITION, CONFIGURE = 1, 2, 3, 4, 5, 7, 8, 14
"""Kinds of requests; see `axis3601.rung`."""

COMMANDS = {ABSOLUTE: 1, RELATIVE: 2, HOME: 32, RESET: 2048, SET_POSITION: 512, HALT: 0}
"""Command word for each request; a CCW home search uses 64, and a manual move 128 or 256."""

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

    def _element(self, array: str, number: int) -> Place:
        return replace(self._state.member(array), indices=(constant(number),))

    def input_word(self, number: int) -> int:
        """Return an input word of the module, by its number from 0."""
        return int(self.machine.get(self._element("In", number)))

    @property
    def output_words(self) -> list[int]:
        """The output words of the last request."""
        return [int(self.machine.get(self._element("Words", number))) for number in range(WORDS)]

    @property
    def requested_speed(self) -> int:
        """The speed in the last request, steps/s."""
        _, _, _, _, thousands, ones, *_ = self.output_words
        return thousands * 1000 + ones

    @property
    def status(self) -> int:
        """The PLCopen state of the axis: 0 disabled, 1 standstill, 6 error stop."""
        return int(self.state["State"])

    def request(self, motion: MotionControl, kind: int, *words: int) -> None:
        """Send a request of a given kind with output words. It replaces the previous request of `motion`."""
        ticket = wrap(int(self.state["Ticket"]) + 1, 32)
        self.state.set(Ticket=ticket, Kind=kind)
        for number in range(WORDS):
            value = words[number] if number < len(words) else 0
            self.machine.put(self._element("Words", number), wrap(value, 16))
        motion.ticket = ticket

    @property
    def running_kind(self) -> int:
        """Kind of the request that the block is executing; 0 if none."""
        return int(self.state["RunKind"]) if int(self.state["Step"]) in (1, 2) else 0

    @property
    def kind_under_way(self) -> int:
        """Kind of the request that is running or waiting; 0 if none."""
        is_waiting = self.state["Ticket"] != self.state["Taken"]
        return int(self.state["Kind"]) if is_waiting else self.running_kind

    def check_ready(self) -> None:
        """Raise a MotionError if the axis can't accept motion now."""
        if self.tag["ShutdownStatus"]:
            raise MotionError(SHUT_DOWN)
        if not self.tag["ServoActionStatus"]:
            raise MotionError(SERVO_OFF)
        if self.status in (0, ERROR_STOP):
            raise MotionError(AXIS_FAULT)

    # --- conversions; a number that does not fit in the module's words raises a MotionError

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
        return _round_within(value * self.settings.counts_per_unit, self.settings.limits.speed)

    def rate(self, value: float, unit: str) -> int:
        """Return an acceleration in steps/ms/s."""
        if unit == "%OFMAXIMUM":
            value *= self.max_acceleration() / 100
        return _round_within(value * self.settings.counts_per_unit / 1000, self.settings.limits.rate)

    def max_acceleration(self) -> float:
        """Return the acceleration that corresponds to 100 % of maximum, units/s²."""
        return self.settings.max_acceleration or float(self.tag["MaximumAcceleration"])


def _round_within(value: float, limit: int) -> int:
    """Return a number rounded to an integer from 1 to `limit`; raise a MotionError if out of range."""
    if not (math.isfinite(value) and 1 <= round(value) <= limit):
        raise MotionError(OUT_OF_RANGE)
    return round(value)


def update_tag(axis: Axis) -> None:
    """Update the axis's tag from the module's inputs, after each scan.

    If the module disappears with the servo on, the servo turns off, and ModuleFault is set until the module
    is back.
    """
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
    running_kind = axis.running_kind
    is_present, status_word = axis.status != 0, axis.input_word(0)
    is_lost = not is_present and tag["ServoActionStatus"]
    if is_lost:
        tag.set(ServoActionStatus=False, DriveEnableStatus=False)
    tag.set(
        MoveStatus=running_kind in (ABSOLUTE, RELATIVE),
        JogStatus=running_kind == VELOCITY,
        HomingStatus=running_kind == HOME,
        StoppingStatus=int(state["Step"]) == 3,
        AxisHomedStatus=is_present and not status_word >> 10 & 1,
        AccelStatus=is_present and bool(status_word >> 5 & 1),
        DecelStatus=is_present and bool(status_word >> 6 & 1),
        PhysicalAxisFault=axis.status == ERROR_STOP,
        ModuleFault=is_lost or (not is_present and tag["ModuleFault"]),
    )
