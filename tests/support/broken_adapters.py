"""Adapters with one deliberate mistake each: what the ordeals have to find.

Each stands for a class of mistakes that people make between a PLC and a controller on a line;
made as in `broken3601`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from broken3601 import Mistake
from scanrack.io_images.amci3601 import InputBit
from scanrack.runtime.kinematics import Shape
from scanrack.runtime.line import pcl601_frames as frames601
from scanrack.runtime.line import pcl601_pdus as pdus601
from scanrack.runtime.line import pmc006_frames as frames006
from scanrack.runtime.modules.adapters import exchanges
from scanrack.runtime.modules.adapters.amci_drive.driver import AmciDriver
from scanrack.runtime.modules.adapters.capabilities import RowCapabilities
from scanrack.runtime.modules.adapters.driver import Driver
from scanrack.runtime.modules.adapters.exchanges import ControllerState
from scanrack.runtime.modules.adapters.findings import FindingKind
from scanrack.runtime.modules.adapters.linked_axis import LinkedAxis
from scanrack.runtime.modules.adapters.module import Adapter
from scanrack.runtime.modules.adapters.pcl601 import pcl601_axis as axis601
from scanrack.runtime.modules.adapters.pcl601.driver import Pcl601Driver
from scanrack.runtime.modules.adapters.pcl601.pcl601_axis import Pcl601Axis
from scanrack.runtime.modules.adapters.pmc006 import units as units006
from scanrack.runtime.modules.adapters.pmc006.driver import EXT1_STOP, EXT2_STOP, Pmc006Driver
from scanrack.runtime.modules.adapters.pmc006.pmc006_axis import Pmc006Axis
from scanrack.runtime.modules.adapters.pmc006.pmc006_capabilities import SHARED

MISTAKES: list[tuple[Mistake, str]] = []
"""Each with the controller in whose adapter it is made."""


def mistake(
    owner: Any, attribute: Any, theme: str, controller: str = "PCL601"
) -> Callable[[Callable[[Any], Any]], Callable[[Any], Any]]:
    """Add a mistake: the function takes what is right and returns what is wrong.

    Its theme is a kind of ordeal, or one of the themes of `adapter_scripts`.
    """

    def add(wrong: Callable[[Any], Any]) -> Callable[[Any], Any]:
        assert wrong.__doc__
        MISTAKES.append((Mistake(wrong.__name__, wrong.__doc__, theme, owner, attribute, wrong), controller))
        return wrong

    return add


# ---- the line


@mistake(frames601, "is_frame", "line")
def checksum_unread(right):
    """The checksum of a PCL601's reply is not looked at."""
    return lambda frame: True


@mistake(frames006, "decode", "line", "PMC006")
def sum_unread(right):
    """The checksum of a PMC006's reply is not looked at."""
    return lambda frame: right(bytes((*frame[:-1], sum(frame[:-1]) & 0xFF)))


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


@mistake(exchanges, "FAILURES_MAX", "replies_lost")
def gives_up_at_once(right):
    """A single lost reply counts as a lost controller."""
    return 1


@mistake(Driver, "ask", "line_down")
def never_gives_up(right):
    """However many exchanges fail, the controller counts as there."""

    def ask(self, request):
        return (yield request)

    return ask


@mistake(Pcl601Driver, "forget", "line")
def parameters_believed_after_a_loss(right):
    """What has been written to the controller is thought to be there still after it has lost its power."""
    return lambda self: None


# ---- after a loss


@mistake(Adapter, "_return", "line_down")
def return_not_told(right):
    """The link comes back, and nothing is said of it."""
    return lambda self, now_ns, given: None


@mistake(Adapter, "_return", "line")
def edges_count_at_once(right):
    """When the link comes back, a bit counts before all of them have been low."""

    def returned(self, now_ns, given):
        right(self, now_ns, given)
        self._locked_out = False

    return returned


@mistake(Driver, "_see_again", "line")
def left_running_after_a_loss(right):
    """When the controller answers again it is not stopped."""

    def see_again(self):
        ready, self._was_ready = self._was_ready, False
        yield from right(self)
        self._was_ready = ready
        if ready:
            self.findings.add(FindingKind.RETURNED)
        self.state = ControllerState.READY if ready else ControllerState.PRESENT

    return see_again


@mistake(Adapter, "_begin_anew", "line")
def position_kept_over_loss_of_power(right):
    """A controller that has lost its power still shows the position that it had."""

    def begin_anew(self):
        before = getattr(self, "axis", None)
        right(self)
        if before is not None:
            self.axis.configuration, self.axis._offset = before.configuration, before._offset

    return begin_anew


@mistake(Adapter, "_return", "line_down")
def position_trusted_after_a_loss(right):
    """The position stays valid when the link comes back."""

    def returned(self, now_ns, given):
        right(self, now_ns, given)
        self.layer.state.latches.clear(1 << 10)

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

    def returned(self, now_ns, given):
        right(self, now_ns, given)
        self.driver.rebased = 0

    return returned


# ---- position and direction


@mistake(Driver, "rebase", "homing", "PMC006")
def rebase_shown_as_motion(right):
    """Until the next read, a counter that has been put elsewhere counts as moved."""

    def rebase(self, position):
        before = self.position
        yield from self.write_position(position)
        self.rebased += position - before

    return rebase


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


# ---- what can't be done


@mistake(RowCapabilities, "lacking_for", "states")
def nothing_refused(right):
    """What the controller can't do is sent to it."""
    return lambda self, request: None


@mistake(RowCapabilities, "lacking_for_configuration", "states", "PMC006")
def any_configuration_taken(right):
    """A configuration that the controller can't keep is accepted."""
    return lambda self, configuration: None


# ---- units and ramps


@mistake(axis601, "drive_for", "moves")
def higher_rate_for_both(right):
    """One rate for both ramps is the higher of the two."""

    def drive_for(profile):
        steeper = max(profile.acceleration_spmss, profile.deceleration_spmss)
        return right(replace(profile, acceleration_spmss=steeper, deceleration_spmss=steeper))

    return drive_for


@mistake(axis601, "drive_for", "moves")
def s_curves_at_the_full_rate(right):
    """An S-curve becomes a constant ramp at its highest rate, which takes half as long."""
    return lambda profile: right(replace(profile, shape=Shape.CONSTANT))


@mistake(units006, "coefficient_for", "moves", "PMC006")
def the_steepest_ramp(right):
    """Every rate becomes coefficient 1."""
    return lambda rate_spmss, *, nearest=False: 1


@mistake(pdus601, "signed_pair", "moves")
def encoder_without_its_sign(right):
    """A negative count is read as a large one."""
    return lambda low, high: low | high << 16


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


@mistake(LinkedAxis, "moving", "stopped")
def rest_claimed_with_the_command(right):
    """A hard stop counts as carried out once it is commanded."""
    return property(lambda self: not self._driver.cut and right.fget(self))


@mistake(LinkedAxis, "moving", "stopped", "PMC006")
def rest_claimed_with_the_command_over_a_pmc006(right):
    """The same mistake, on the slower line."""
    return property(lambda self: not self._driver.cut and right.fget(self))


@mistake(Adapter, "_next_words", "pulses_after_a_stop")
def only_the_last_words_wait(right):
    """Of the words that come during a stop only those at its end are obeyed."""

    def next_words(self, given):
        self._waiting.clear()
        return right(self, given)

    return next_words


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


@mistake(Pmc006Driver, "_do", "stops", "PMC006")
def stops_crossed(right):
    """What is to stop at once ramps down, and what is to ramp down stops at once."""

    def do(self, name, value=0):
        crossed = {"abort": "speed_mode"}
        if name == "speed_mode" and value == 0:
            crossed["speed_mode"] = "abort"
        yield from right(self, crossed.get(name, name), value)

    return do


@mistake(Pmc006Axis, "levels", "emergency_stop", "PMC006")
def levels_inverted(right):
    """A pin that is high is taken for an input that is energized."""
    return property(lambda self: right.fget(self) ^ (SHARED | InputBit.CW_LIMIT | InputBit.ESTOP))


@mistake(Pmc006Driver, "note_configuration", "limits", "PMC006")
def stops_on_the_other_edge(right):
    """The external stops act when a switch is left."""

    def note_configuration(self, configuration):
        right(self, configuration)
        self._rising ^= EXT1_STOP | EXT2_STOP

    return note_configuration


@mistake(Pmc006Driver, "_clear_stops", "limits", "PMC006")
def latch_left_set(right):
    """An external stop that is latched is not cleared when the limit is left."""

    def clear_stops(self, *armed):
        self.clear_stops = False
        yield from ()

    return clear_stops


@mistake(Pmc006Driver, "_stops_for", "limits", "PMC006")
def limit_behind_left_armed(right):
    """The limit on which the axis stands stops the motion that leaves it."""
    return lambda self, task: self._limits


@mistake(Pmc006Driver, "_find_zero", "homing", "PMC006")
def home_not_zeroed(right):
    """The controller's own zero at home is left, and taken for a loss of power later."""

    def find_zero(self, task):
        self._zeroing = False
        yield from ()

    return find_zero


@mistake(Pcl601Axis, "note_configuration", "stops")
def emergency_stop_shown_as_limits(right):
    """What comes through the diodes on both hard limits is taken for an end limit."""
    return lambda self, configuration: None


@mistake(Pcl601Driver, "_attribute", "limits")
def side_of_the_limit_guessed(right):
    """A hard limit is always the CW one."""

    def attribute(self):
        self.limit_side = 1
        yield from ()

    return attribute


# ---- a networked drive


@mistake(AmciDriver, "stop", "stopped", "drive")
def stop_unsent(right):
    """An immediate stop is not sent to the drive."""

    def stop(self):
        yield from ()

    return stop


@mistake(AmciDriver, "slow_down", "held", "drive")
def hold_unsent(right):
    """A hold is answered without anything being said to the drive."""

    def slow_down(self, task):
        yield from ()

    return slow_down


@mistake(AmciDriver, "levels", "emergency_stop", "drive")
def drive_levels_inverted(right):
    """An input of the drive that is low is taken for an input that is energized."""
    return property(lambda self: right.fget(self) ^ 3)


@mistake(AmciDriver, "write_position", "preset", "drive")
def preset_of_the_lower_word(right):
    """Only the lower word of a position is written to the drive."""
    return lambda self, position: right(self, position % 1000)
