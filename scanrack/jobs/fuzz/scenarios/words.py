"""Describes a scenario in sentences, one for each part, permanent conditions first."""

from __future__ import annotations

from collections.abc import Iterator

from scanrack.io_images.times import seconds, time_text
from scanrack.runtime.live.actions import Action, Force, Mode, Unforce, Write
from scanrack.runtime.loop.incidents import FaultKind, InjectedFault
from scanrack.runtime.machine.spec import input_name

from .scenario import ContactPress, Press, Scenario, Signal, TornUpdate, Turn

HAPPENS = {
    FaultKind.POWER_CYCLE: "the power of slot {slot} goes and comes back",
    FaultKind.LINK_LOST: "the link to slot {slot} is lost",
    FaultKind.REMOVED: "the module in slot {slot} is taken out",
    FaultKind.FATAL_ERROR: "the module in slot {slot} fails",
    FaultKind.ASIC_LOST: "the backplane interface of slot {slot} fails",
    FaultKind.TORN_UPDATE: "the next change of slot {slot}'s outputs is torn: {words} late",
    FaultKind.PROGRAM_MODE: "the CPU's key is turned to program",
    FaultKind.LINE_DOWN: "the line to the controller of slot {slot} is open",
    FaultKind.REPLIES_LOST: "{replies} of the controller of slot {slot} got lost",
    FaultKind.REPLIES_DAMAGED: "{replies} of the controller of slot {slot} got damaged",
    FaultKind.CONDITION: "around slot {slot}: {state}",
    FaultKind.CONTROLLER_POWER_CYCLE: "the power of the controller of slot {slot} goes and comes back",
}
"""Sentence for each kind of fault."""


def described(scenario: Scenario) -> list[str]:
    """Return sentences that describe a scenario.

    >>> from ....io_images.amci3601 import InputBit
    >>> described(Scenario(presses=(Press(1, InputBit.ESTOP, True, 1_500_000_000, 20_000_000),)))
    ['1.5 s: input estop of slot 1 is on for 20 ms']
    >>> described(Scenario())
    ['nothing: the rack as its file has it']
    """
    timed = [(press.at_ns, _press(press)) for press in scenario.presses]
    timed += [(push.at_ns, _input(push, "operated")) for push in scenario.pushes]
    timed += [(signal.at_ns, _input(signal, f"{signal.value:g}")) for signal in scenario.signals]
    timed += [(turn.at_ns, _turn(turn)) for turn in scenario.turns]
    timed += [(incident.at_ns, _incident(incident)) for incident in scenario.incidents]
    timed += [(tear.at_ns, _tear(tear)) for tear in scenario.tears]
    timed += [(order.at_ns, _given(order.order)) for order in scenario.orders]
    lines = list(_from_the_start(scenario))
    lines += [f"{seconds(at_ns)} s: {text}" for at_ns, text in sorted(timed, key=lambda entry: entry[0])]
    return lines or ["nothing: the rack as its file has it"]


def _from_the_start(scenario: Scenario) -> Iterator[str]:
    for slot, version in scenario.firmware:
        yield f"slot {slot} has firmware {version}"
    for shift in scenario.shifts:
        yield f"the switches of slot {shift.slot} are {shift.steps:+,} steps from where they should be"
    for lost in scenario.lost:
        steps = "1 step" if lost.steps == 1 else f"{lost.steps:,} steps"
        yield f"the motor of slot {lost.slot} loses {steps} at {lost.at:,}"


def _press(press: Press) -> str:
    level = "on" if press.energized else "off"
    return f"input {input_name(press.input)} of slot {press.slot} is {level}{_for(press.for_ns)}"


def _input(part: ContactPress | Signal, state: str) -> str:
    return f"input {part.input} of slot {part.slot} is {state}{_for(part.for_ns)}"


def _turn(turn: Turn) -> str:
    way = "up" if turn.counts > 0 else "down"
    return f"the master encoder of slot {turn.slot} counts {way} by {abs(turn.counts):,}{_for(turn.for_ns)}"


def _incident(incident: InjectedFault) -> str:
    late = ", ".join(map(str, incident.late_words))
    words = f"words {late} come" if len(incident.late_words) > 1 else f"word {late} comes"
    replies = "replies" if incident.for_ns else "a reply"
    text = HAPPENS[incident.what].format(
        slot=incident.slot, words=words, replies=replies, state=incident.state
    )
    return text + _for(incident.for_ns)


def _tear(tear: TornUpdate) -> str:
    return f"new inputs come in the middle of the scan, before rung {tear.rung} of {tear.routine}"


def _given(order: Action) -> str:
    if isinstance(order, Unforce):
        return f"the force of {order.tag} is released"
    if isinstance(order, Mode):
        return f"the key is turned to {order.mode}"
    assert isinstance(order, Write | Force)
    return f"{order.tag} is {'forced to' if isinstance(order, Force) else 'set to'} {order.value}"


def _for(time_ns: int) -> str:
    return f" for {time_text(time_ns)}" if time_ns else ""
