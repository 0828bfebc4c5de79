"""The latched status bits of the simulated 3601, and which rule set each."""

from __future__ import annotations

from scanrack.runtime.loop.events import Event
from scanrack.runtime.modules.amci3601.latches import COMMAND_ERROR, INVALID_PROFILE, Latches


def test_the_first_rule_is_the_cause_until_the_bit_is_cleared():
    latches = Latches([])
    latches.fire(0, "CMD-03")
    latches.fire(1, "CMD-05")
    assert latches.causes == {COMMAND_ERROR: "CMD-03", INVALID_PROFILE: "PRF-01"}
    latches.clear(COMMAND_ERROR)
    assert latches.causes == {INVALID_PROFILE: "PRF-01"}
    latches.fire(2, "CMD-06")
    assert latches.causes == {COMMAND_ERROR: "CMD-06", INVALID_PROFILE: "PRF-01"}


def test_every_rule_that_fires_is_written_down_though_its_bit_is_set_already():
    events: list[Event] = []
    latches = Latches(events)
    assert latches.fire(5, "CMD-04") == COMMAND_ERROR | INVALID_PROFILE
    assert latches.fire(6, "CMD-04", alone=True) == COMMAND_ERROR
    told = [(event.at_ns, event.name, event.fields["bits"]) for event in events]
    assert told == [
        (5, "CMD-04", ["COMMAND_ERROR"]),
        (5, "PRF-02", ["INVALID_PROFILE"]),
        (6, "CMD-04", ["COMMAND_ERROR"]),
    ]
    assert events[0].fields["section"] == "chapter 6, Command Error 4"
