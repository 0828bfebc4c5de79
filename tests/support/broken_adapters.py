"""Adapters with one deliberate mistake each: what the ordeals have to find.

Each stands for a class of mistakes that people make between a PLC and a controller on a line;
made as in `broken3601`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from broken3601 import Mistake
from scanrack.runtime.adapters import driver
from scanrack.runtime.adapters.axis import LinkedAxis
from scanrack.runtime.adapters.driver import Driver
from scanrack.runtime.adapters.module import Adapter
from scanrack.runtime.adapters.pcl601 import axis as axis601
from scanrack.runtime.adapters.pcl601.driver import Pcl601Driver
from scanrack.runtime.adapters.pmc006.driver import Pmc006Driver

MISTAKES: list[tuple[Mistake, str]] = []
"""Each with the controller in whose adapter it is made; its theme is the kind of ordeal that looks for it."""


def mistake(
    owner: Any, attribute: Any, theme: str, controller: str = "PCL601"
) -> Callable[[Callable[[Any], Any]], Callable[[Any], Any]]:
    """Add a mistake: the function takes what is right and returns what is wrong."""

    def add(wrong: Callable[[Any], Any]) -> Callable[[Any], Any]:
        assert wrong.__doc__
        MISTAKES.append((Mistake(wrong.__name__, wrong.__doc__, theme, owner, attribute, wrong), controller))
        return wrong

    return add


# ---- the line


@mistake(Driver, "start", "replies_lost")
def start_repeated_blindly(right):
    """A start whose answer is lost is sent again."""

    def start(self, task, request):
        yield from self.insist(request)
        self.model(task)

    return start


@mistake(Driver, "start", "replies_lost")
def start_never_looked_after(right):
    """A start whose answer is lost is taken for a start that was refused: the motion is not watched."""

    def start(self, task, request):
        reply = yield from self.ask(request)
        self.model(task)
        if reply is None:
            task.steps = 0

    return start


@mistake(driver, "FAILURES_MAX", "replies_lost")
def gives_up_at_once(right):
    """A single lost reply counts as a lost controller."""
    return 1


@mistake(Driver, "ask", "line_down")
def never_gives_up(right):
    """However many exchanges fail, the controller counts as there."""

    def ask(self, request):
        return (yield request)

    return ask


# ---- after a loss


@mistake(Adapter, "_return", "line_down")
def position_trusted_after_a_loss(right):
    """The position stays valid when the link comes back."""

    def returned(self, now_ns):
        right(self, now_ns)
        self.layer.latches.clear(1 << 10)

    return returned


@mistake(Driver, "note_position", "power_lost")
def loss_of_power_unnoticed(right):
    """A counter that is suddenly near 0 is believed."""

    def note_position(self, position):
        self.position = position

    return note_position


@mistake(Adapter, "_return", "line_down")
def origin_forgotten_after_a_loss(right):
    """Where the controller's counter was put is forgotten when the link comes back."""

    def returned(self, now_ns):
        right(self, now_ns)
        self.driver.rebased = 0

    return returned


# ---- position and direction


@mistake(LinkedAxis, "preset_position", "preset")
def preset_with_the_wrong_sign(right):
    """A preset moves the offset the wrong way."""
    return lambda self, value: right(self, 2 * self.position - value)


@mistake(LinkedAxis, "task_for", "by_hand")
def direction_turned_round(right):
    """CW is sent as CCW."""
    return lambda self, kind, direction, profile, steps=0: right(self, kind, -direction, profile, steps)


@mistake(Driver, "conclude", "undisturbed")
def complete_wherever_it_stands(right):
    """The end of a motion is not compared with its target, and a step is lost on the way."""

    def conclude(self, task, began_at):
        self.rebased += task.direction
        yield from right(self, task, self.position - task.direction * task.steps)

    return conclude


# ---- units and ramps


@mistake(axis601, "drive_for", "undisturbed")
def speed_in_half_steps(right):
    """The controller is told twice the speed."""

    def drive_for(profile):
        drive = right(profile)
        return replace(drive, speed_sps=2 * drive.speed_sps)

    return drive_for


@mistake(axis601, "drive_for", "undisturbed")
def rate_in_the_wrong_unit(right):
    """The acceleration is sent a thousand times too low."""

    def drive_for(profile):
        drive = right(profile)
        return replace(drive, accel_sps2=max(100, drive.accel_sps2 // 1000))

    return drive_for


# ---- inputs and stops


@mistake(axis601, "LIMITS", "limit_met")
def limits_on_the_wrong_sides(right):
    """The CW limit is shown as the CCW limit."""
    return right | {1: right[-1], -1: right[1]}


@mistake(axis601, "WIRED_INPUTS", "emergency_stop")
def emergency_stop_unread(right):
    """The emergency stop is left to the controller's own limits."""
    return {mask: bit for mask, bit in right.items() if mask != 1 << 3}


@mistake(LinkedAxis, "stop", "held")
def hold_ignored(right):
    """A controlled stop does not reach the controller."""
    return lambda self, now_ns, deceleration_spmss, shape: None


@mistake(LinkedAxis, "cut", "stopped")
def immediate_stop_ignored(right):
    """A hard stop does not reach the controller."""
    return lambda self, now_ns: None


@mistake(Pcl601Driver, "slow_down", "held")
def creeps_on(right):
    """An index that is held is left creeping at its base speed."""

    def slow_down(self, task):
        yield from self._command(6)

    return slow_down


@mistake(Pmc006Driver, "slow_down", "held", "PMC006")
def hold_taken_for_done(right):
    """A hold is answered without anything being said to the controller."""

    def slow_down(self, task):
        yield from ()

    return slow_down
