"""Motion instructions on a 3601, as requests to the block that owns the module's words (`axis3601.rung`).

| instruction | 3601 |
|---|---|
| MSO | configures the module, if the rack says how; then the axis takes commands |
| MSF, MASD | brings the axis to rest; it takes no commands |
| MASR, MAFR | Reset Errors |
| MAM | absolute or relative move; MAJ: manual move; MAS: hold, or letting go |
| MAH | Find Home |
| MRP | Preset Position |
| MCD | another speed of a manual move |

A request is a ticket of the axis, see `axis3601.rung`. The instruction follows it: IP while it is under way,
PC or DN when it has ended, ER when the axis failed. A newer request ends IP without PC. What a 3601 can't do
is refused when the program is built.

A 3601 carries out one command: it superimposes nothing. MAM and MAJ replace their own kind; beside another
one they are refused without Merge (ERR 22), and with it the axis comes to rest in between.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from ....io_images.thousands import PARAMETER_MAX
from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.arithmetic import wrap
from ...model.operands import Constant, Group, Place, Resolved, constant
from ...model.predefined.motion_types import AXIS_MEMBERS
from ...model.predefined.motion_words import (
    CHANGED_MOTION,
    DISABLED_ENABLED,
    MERGE_SPEEDS,
    NO_YES,
    RATE_UNITS,
    REDEFINITIONS,
    SPEED_UNITS,
    STOP_TYPES,
)
from ...model.types import DINT
from .axes import AxisSettings
from .motion_control import (
    AXIS_FAULT,
    AXIS_NOT_CONFIGURED,
    ILLEGAL,
    ILLEGAL_CHANGE,
    IN_MOTION,
    OUT_OF_RANGE,
    SERVO_OFF,
    SHUT_DOWN,
    Given,
    MotionControl,
    number_of,
    word_of,
)

ABSOLUTE, RELATIVE, VELOCITY, HOME, HALT, RESET, SET_POSITION, CONFIGURE = 1, 2, 3, 4, 5, 7, 8, 14
"""Kinds of requests, see `axis3601.rung`."""

COMMANDS = {ABSOLUTE: 1, RELATIVE: 2, HOME: 32, RESET: 2048, SET_POSITION: 512, HALT: 0}
"""Command word per request; CCW searches have 64, manual moves 128 or 256."""

STANDSTILL, ERROR_STOP = 1, 6
"""States of the axis."""

BITS = {each.name: each.at for each in AXIS_MEMBERS if each.at}
"""Member and bit of each named bit of an axis."""


@dataclass(frozen=True, slots=True)
class BoundAxis:
    """An axis of a program and its 3601."""

    settings: AxisSettings  # its table in the rack file
    tag: Group  # the axis
    state: Group  # the block's AXIS_3601


class Axis:
    """A bound axis in a scan."""

    def __init__(self, machine: Interpreter, bound: BoundAxis) -> None:
        self.machine, self.settings = machine, bound.settings
        self._tag, self._state = bound.tag, bound.state
        self.tag, self.state = Members(machine, bound.tag), Members(machine, bound.state)

    def bit(self, name: str) -> bool:
        """Return a bit of the tag."""
        return bool(self.machine.get(self._bit(name)))

    def set_bits(self, **bits: bool) -> None:
        """Set bits of the tag."""
        for name, value in bits.items():
            self.machine.put(self._bit(name), value)

    def _bit(self, name: str) -> Place:
        word, _, bit = BITS[name].partition(".")
        return replace(self._tag.member(word), bit=Constant(int(bit), DINT))

    def word(self, number: int) -> int:
        """Return an input word of the module."""
        place = self._state.member("In")
        return int(self.machine.get(replace(place, indices=(constant(number),))))

    @property
    def status(self) -> int:
        """Its PLCopen state: 0 disabled, 1 standstill, 6 error stop."""
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
        """Kind of the request that is carried out or waits; 0 without one."""
        if self.state["Ticket"] != self.state["Taken"]:
            return int(self.state["Kind"])
        return int(self.state["RunKind"]) if int(self.state["Step"]) in (1, 2) else 0

    def refusal(self) -> int:
        """Return the error code if the axis accepts no motion now, else 0."""
        if self.bit("ShutdownStatus"):
            return SHUT_DOWN
        if not self.bit("ServoActionStatus"):
            return SERVO_OFF
        return AXIS_FAULT if self.status in (0, ERROR_STOP) else 0

    # --- numbers

    def steps(self, units: float) -> int | None:
        """Return a position or distance in steps, None if it does not fit into the module's words."""
        value = units * self.settings.counts_per_unit
        fits = math.isfinite(value) and abs(value) <= PARAMETER_MAX
        return round(value) if fits else None

    def speed(self, value: float, unit: str) -> int | None:
        """Return a speed in steps/s."""
        if unit == "%OFMAXIMUM":
            value *= (self.settings.max_speed or float(self.tag["MaximumSpeed"])) / 100
        return _within(value * self.settings.counts_per_unit, self.settings.limits.speed)

    def rate(self, value: float, unit: str) -> int | None:
        """Return an acceleration in steps/ms/s, None if the module has no such rate."""
        if unit == "%OFMAXIMUM":
            value *= self._maximum() / 100
        return _within(value * self.settings.counts_per_unit / 1000, self.settings.limits.rate)

    def _maximum(self) -> float:
        return self.settings.max_acceleration or float(self.tag["MaximumAcceleration"])


def _within(value: float, most: int) -> int | None:
    return round(value) if math.isfinite(value) and 1 <= round(value) <= most else None


def _pair(value: int) -> tuple[int, int]:
    """Split a number into thousands and the rest, both signed."""
    size = (abs(value) // 1000, abs(value) % 1000)
    return size if value >= 0 else (-size[0], -size[1])


def _profile(
    command: int, target: int, speed: int, rates: tuple[int, int], shape: int = 0
) -> tuple[int, ...]:
    return command, shape, *_pair(target), *_pair(speed), *rates


Answer = Callable[..., None]


def _servo_on(axis: Axis, motion: MotionControl) -> None:
    if axis.bit("ShutdownStatus"):
        motion.refuse(SHUT_DOWN)
    elif axis.status != 0:
        axis.set_bits(ServoActionStatus=True, DriveEnableStatus=True)
        motion.set(DN=True)
    elif axis.settings.configuration:
        axis.request(motion, CONFIGURE, *axis.settings.configuration)
    else:
        motion.refuse(AXIS_NOT_CONFIGURED)


def _servo_off(axis: Axis, motion: MotionControl, *, shut_down: bool = False) -> None:
    axis.set_bits(ServoActionStatus=False, DriveEnableStatus=False)
    if shut_down:
        axis.set_bits(ShutdownStatus=True)
    if axis.state["Running"]:
        axis.request(motion, HALT)
        motion.ticket = 0
    motion.set(DN=True)


def _reset(axis: Axis, motion: MotionControl, *, restart: bool = False) -> None:
    if restart:
        axis.set_bits(ShutdownStatus=False)
    if axis.status == 0:
        motion.refuse(AXIS_NOT_CONFIGURED)
    else:
        axis.request(motion, RESET, COMMANDS[RESET])


def _move(axis: Axis, motion: MotionControl, kind: Resolved, position: Resolved, *others: Given) -> None:
    request = {0: ABSOLUTE, 1: RELATIVE}.get(int(number_of(axis.machine, kind)))
    target = axis.steps(number_of(axis.machine, position))
    if request is None or target is None:
        motion.refuse(OUT_OF_RANGE)
    else:
        _go(axis, motion, request, COMMANDS[request], target, others)


def _jog(axis: Axis, motion: MotionControl, direction: Given, *others: Given) -> None:
    backwards = word_of(axis.machine, direction, ("Forward", "Reverse")) == "REVERSE"
    _go(axis, motion, VELOCITY, 256 if backwards else 128, 0, others)


STOPPED_BY = {"MOVE": (ABSOLUTE, RELATIVE), "JOG": (VELOCITY,), "HOME": (HOME,)}
"""Kinds of requests by the stop type of MAS that ends them; a 3601 has no others."""


def _go(
    axis: Axis, motion: MotionControl, kind: int, command: int, target: int, operands: tuple[Given, ...]
) -> None:
    """Request a move or a jog, with the operands from the speed on."""
    present = axis.under_way
    merge = len(operands) > 10 and word_of(axis.machine, operands[10], DISABLED_ENABLED) == "ENABLED"
    if not merge and any(present in kinds and kind not in kinds for kinds in STOPPED_BY.values()):
        motion.refuse(IN_MOTION)
        return
    dynamics = _dynamics(axis, *operands[:6])
    if dynamics is None:
        motion.refuse(OUT_OF_RANGE)
        return
    speed, rates = dynamics
    if merge and present and word_of(axis.machine, operands[11], MERGE_SPEEDS) == "CURRENT":
        words = _words_of(axis)
        speed = words[4] * 1000 + words[5] or speed
    axis.request(motion, kind, *_profile(command, target, speed, rates))
    motion.set(DN=True, IP=True, AC=True)


def _dynamics(axis: Axis, *operands: Given) -> tuple[int, tuple[int, int]] | None:
    """Return speed and both rates in the module's units, None if one is out of range."""
    values, units = operands[::2], operands[1::2]
    lists = (SPEED_UNITS, RATE_UNITS, RATE_UNITS)
    words = [word_of(axis.machine, unit, names) for unit, names in zip(units, lists, strict=True)]
    numbers = [number_of(axis.machine, each) for each in values]
    speed = axis.speed(numbers[0], words[0])
    up, down = axis.rate(numbers[1], words[1]), axis.rate(numbers[2], words[2])
    return None if speed is None or up is None or down is None else (speed, (up, down))


def _stop(axis: Axis, motion: MotionControl, what: Given, *_others: Given) -> None:
    named = word_of(axis.machine, what, STOP_TYPES)
    if named == "ALL" or axis.under_way in (*STOPPED_BY.get(named, ()), HALT):
        motion.set(DN=True, IP=True)
        axis.request(motion, HALT)
    else:
        motion.set(DN=True, PC=True)


def _home(axis: Axis, motion: MotionControl) -> None:
    settings = axis.settings
    speed = axis.speed(settings.home_speed or float(axis.tag["HomeSpeed"]), "")
    rate = axis.rate(settings.home_acceleration or axis._maximum(), "")
    if axis.status != STANDSTILL:
        motion.refuse(IN_MOTION)
    elif speed is None or rate is None:
        motion.refuse(OUT_OF_RANGE)
    else:
        command = COMMANDS[HOME] if settings.home_direction > 0 else 2 * COMMANDS[HOME]
        axis.request(motion, HOME, *_profile(command, 0, speed, (rate, rate)))
        motion.set(DN=True, IP=True, AC=True)


def _redefine(axis: Axis, motion: MotionControl, kind: Given, _select: Given, position: Resolved) -> None:
    units = number_of(axis.machine, position)
    if word_of(axis.machine, kind, REDEFINITIONS) == "RELATIVE":
        units += float(axis.tag["ActualPosition"])
    steps = axis.steps(units)
    if axis.status != STANDSTILL:
        motion.refuse(IN_MOTION)
    elif steps is None:
        motion.refuse(OUT_OF_RANGE)
    else:
        thousands, rest = _pair(steps)
        axis.request(motion, SET_POSITION, COMMANDS[SET_POSITION], 0, thousands, rest)


def _change(
    axis: Axis,
    motion: MotionControl,
    kind: Given,
    change_speed: Given,
    speed: Resolved,
    change_up: Given,
    up: Resolved,
    change_down: Given,
    down: Resolved,
    *others: Given,
) -> None:
    """Change the speed of a manual move; a move can't be changed."""
    words = _words_of(axis)
    moving = axis.bit("JogStatus") and word_of(axis.machine, kind, CHANGED_MOTION) == "JOG"
    if not moving:
        motion.refuse(ILLEGAL_CHANGE)
        return
    speed_unit, up_unit, down_unit = (_unit(axis, each) for each in others[4:7])
    changes = [
        word_of(axis.machine, each, NO_YES) == "YES" for each in (change_speed, change_up, change_down)
    ]
    values = (
        axis.speed(number_of(axis.machine, speed), speed_unit) if changes[0] else words[4] * 1000 + words[5],
        axis.rate(number_of(axis.machine, up), up_unit) if changes[1] else words[6],
        axis.rate(number_of(axis.machine, down), down_unit) if changes[2] else words[7],
    )
    if None in values:
        motion.refuse(OUT_OF_RANGE)
        return
    new_speed, new_up, new_down = (int(each or 0) for each in values)
    axis.request(motion, VELOCITY, *_profile(words[0], 0, new_speed, (new_up, new_down)))
    motion.ticket = 0
    motion.set(DN=True)


def _unit(axis: Axis, operand: Given) -> str:
    return word_of(axis.machine, operand, RATE_UNITS)


def _words_of(axis: Axis) -> list[int]:
    place = axis._state.member("Words")
    return [int(axis.machine.get(replace(place, indices=(constant(each),)))) for each in range(8)]


ANSWERS: Mapping[str, tuple[Answer, bool]] = {
    "MSO": (_servo_on, False),
    "MSF": (_servo_off, False),
    "MASD": (lambda axis, motion: _servo_off(axis, motion, shut_down=True), False),
    "MASR": (lambda axis, motion: _reset(axis, motion, restart=True), False),
    "MAFR": (_reset, False),
    "MAM": (_move, True),
    "MAJ": (_jog, True),
    "MAS": (_stop, True),
    "MAH": (_home, True),
    "MRP": (_redefine, True),
    "MCD": (_change, True),
}
"""Function that begins each instruction, and whether it needs an axis that accepts motion."""


def begin(axis: Axis, motion: MotionControl, name: str, operands: tuple[Given, ...]) -> None:
    """Begin an instruction with the operands after the axis and the control."""
    if name not in ANSWERS:  # in an add-on instruction, built before its arguments are known
        motion.refuse(ILLEGAL)
        return
    answer, moves = ANSWERS[name]
    refusal = axis.refusal() if moves else 0
    if refusal:
        motion.refuse(refusal)
    else:
        answer(axis, motion, *operands)


def follow(axis: Axis, motion: MotionControl, name: str) -> None:
    """Update an instruction's bits from its request."""
    ticket = motion.ticket
    if not ticket:
        return
    if axis.state["Failed"] == ticket:
        motion.refuse(AXIS_FAULT)
    elif axis.state["Finished"] == ticket:
        motion.set(IP=False, AC=False, DN=True, PC=name in ("MAM", "MAS", "MAH"))
        if name == "MSO":
            axis.set_bits(ServoActionStatus=True, DriveEnableStatus=True)
    elif axis.state["Ticket"] != ticket:
        motion.set(IP=False, AC=False)
    else:
        return
    motion.ticket = 0


# --- what the tag shows


def show(axis: Axis) -> None:
    """Update the tag from the module's inputs, after each scan."""
    state, tag, machine = axis.state, axis.tag, axis.machine
    status = axis.status
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
    running = int(state["Step"]) in (1, 2, 3)
    kind, words = int(state["RunKind"]), (axis.word(0), axis.word(1))
    lost = status == 0 and axis.bit("ServoActionStatus")
    if lost:
        axis.set_bits(ServoActionStatus=False, DriveEnableStatus=False)
    axis.set_bits(
        MoveStatus=running and kind in (ABSOLUTE, RELATIVE),
        JogStatus=running and kind == VELOCITY,
        HomingStatus=running and kind == HOME,
        StoppingStatus=int(state["Step"]) == 3,
        AxisHomedStatus=status != 0 and not words[0] >> 10 & 1,
        AccelStatus=status != 0 and bool(words[0] >> 5 & 1),
        DecelStatus=status != 0 and bool(words[0] >> 6 & 1),
        PhysicalAxisFault=status == ERROR_STOP,
        ModuleFault=lost or (status == 0 and axis.bit("ModuleFault")),
    )
