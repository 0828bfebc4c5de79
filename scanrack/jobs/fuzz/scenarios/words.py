"""Describes a scenario in sentences, one for each part. Permanent conditions come first."""

from __future__ import annotations

from collections.abc import Iterator

from scanrack.io_images.times import seconds, time_text
from scanrack.runtime.live.actions import Action, Force, Mode, Unforce, Write
from scanrack.runtime.loop.incidents import FaultKind, InjectedFault
from scanrack.runtime.machine.spec import input_name

from .scenario import ContactPress, Press, Scenario, Signal, TornUpdate, Turn

HAPPENS = {
    FaultKind.POWER_CYCLE: "slot {slot} loses power for a moment",
    FaultKind.LINK_LOST: "the link to slot {slot} is lost",
    FaultKind.REMOVED: "the module in slot {slot} is removed",
    FaultKind.FATAL_ERROR: "the module in slot {slot} fails",
    FaultKind.ASIC_LOST: "the backplane interface of slot {slot} fails",
    FaultKind.TORN_UPDATE: "the next change of slot {slot}'s outputs is torn: {words} late",
    FaultKind.PROGRAM_MODE: "the CPU's key is turned to program",
    FaultKind.LINE_DOWN: "the line to the controller of slot {slot} is open",
    FaultKind.REPLIES_LOST: "{replies} of slot {slot}'s controller{verb} lost",
    FaultKind.REPLIES_DAMAGED: "{replies} of slot {slot}'s controller{verb} damaged",
    FaultKind.CONDITION: "slot {slot}: {state}",
    FaultKind.CONTROLLER_POWER_CYCLE: "the controller of slot {slot} loses power for a moment",
}
"""Sentence for each kind of fault."""


def described(scenario: Scenario) -> list[str]:
    """Return sentences that describe a scenario.

    >>> from ....io_images.amci3601 import InputBit
    >>> described(Scenario(presses=(Press(1, InputBit.ESTOP, True, 1_500_000_000, 20_000_000),)))
    ['1.5 s: input estop of slot 1 is on for 20 ms']
    >>> described(Scenario())
    ['no events other than in the rack file']
    """
    timed = [(press.at_ns, _press(press)) for press in scenario.presses]
    timed += [(push.at_ns, _input(push, "operated")) for push in scenario.pushes]
    timed += [(signal.at_ns, _input(signal, f"{signal.value:g}")) for signal in scenario.signals]
    timed += [(turn.at_ns, _turn(turn)) for turn in scenario.turns]
    timed += [(incident.at_ns, _incident(incident)) for incident in scenario.incidents]
    timed += [(tear.at_ns, _tear(tear)) for tear in scenario.tears]
    timed += [(order.at_ns, _order(order.order)) for order in scenario.orders]
    timed.sort(key=lambda event: event[0])  # only by time, so that equal times keep their order
    lines = [*_conditions(scenario), *(f"{seconds(at_ns)} s: {text}" for at_ns, text in timed)]
    return lines or ["no events other than in the rack file"]


def _conditions(scenario: Scenario) -> Iterator[str]:
    """Yield a sentence for each condition that lasts for the whole run."""
    for slot, version in scenario.firmware:
        yield f"slot {slot} has firmware {version}"
    for shift in scenario.shifts:
        yield f"the switches of slot {shift.slot} are displaced by {shift.steps:+,} steps"
    for lost in scenario.lost:
        steps = "1 step" if lost.steps == 1 else f"{lost.steps:,} steps"
        yield f"the motor of slot {lost.slot} loses {steps} at {lost.at:,}"


def _press(press: Press) -> str:
    level = "on" if press.energized else "off"
    return f"input {input_name(press.input)} of slot {press.slot} is {level}{_for(press.for_ns)}"


def _input(part: ContactPress | Signal, state: str) -> str:
    return f"input {part.input} of slot {part.slot} is {state}{_for(part.for_ns)}"


def _turn(turn: Turn) -> str:
    direction = "up" if turn.counts > 0 else "down"
    counts = f"{abs(turn.counts):,}"
    return f"the master encoder of slot {turn.slot} counts {direction} by {counts}{_for(turn.for_ns)}"


def _incident(incident: InjectedFault) -> str:
    """Return a sentence about a fault, with its slot, its late words or its state, and its duration."""
    numbers = ", ".join(map(str, incident.late_words))
    words = f"words {numbers} are" if len(incident.late_words) > 1 else f"word {numbers} is"
    replies = "the replies" if incident.for_ns else "a reply"
    verb = " are" if incident.for_ns else " is"
    text = HAPPENS[incident.what].format(
        slot=incident.slot, words=words, replies=replies, verb=verb, state=incident.state
    )
    return text + _for(incident.for_ns)


def _tear(tear: TornUpdate) -> str:
    return f"new inputs are read in the middle of the scan, before rung {tear.rung} of {tear.routine}"


def _order(order: Action) -> str:
    """Return a sentence about an operator's order."""
    if isinstance(order, Unforce):
        return f"the force of {order.tag} is released"
    if isinstance(order, Mode):
        return f"the key is turned to {order.mode}"
    assert isinstance(order, Write | Force)
    verb = "forced" if isinstance(order, Force) else "set"
    return f"{order.tag} is {verb} to {order.value}"


def _for(time_ns: int) -> str:
    return f" for {time_text(time_ns)}" if time_ns else ""
