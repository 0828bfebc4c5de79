"""The law of commands in a search: none is busy while its axis rests for a second and the link is good."""

import pytest
from scanrack.io_images.amci3601 import Configuration, InputBit
from scanrack.jobs.fuzz import STANDARD, Scenario, TrialBench
from scanrack.jobs.fuzz.invariants.busy import RestMeter, axes_in
from scanrack.ladder.python.axis3601 import Axis3601
from scanrack.ladder.python.axis3601.evidence import Evidence
from scanrack.ladder.python.sequences import Logic, dwell, sequence
from scanrack.runtime import FaultKind, InjectedFault, RackSpec

MS = 1_000_000
USED = InputBit.HOME | InputBit.CW_LIMIT
SPEC = RackSpec.model_validate({"program": "none.py", "slot": [{"number": 1, "module": "amci3601"}]})
LOST = Scenario(incidents=(InjectedFault(600 * MS, FaultKind.LINK_LOST, 1, 40 * MS),))


class Line(Logic):
    axis = Axis3601(1, Configuration(inputs_used=USED, starting_speed=500))

    @sequence
    async def cycle(self) -> None:
        await self.axis.configure()
        await self.axis.set_position(0)
        self.axis.move_to(90_000, speed=5000, acceleration=10, deceleration=10)
        await dwell("1 h")


def broken_after_a_lost_link(scans=1_500):
    return TrialBench(SPEC, Line, [STANDARD["commands-end"]], scans).run(LOST).broken


def test_the_axis_keeps_it():
    assert broken_after_a_lost_link() is None


def test_an_axis_that_does_not_is_found(monkeypatch):
    """The link is back at 640 ms, and the axis rests: 1 s later it is too long."""
    monkeypatch.setattr(Evidence, "rests_too_long", lambda *_, **__: False)
    broken = broken_after_a_lost_link()
    assert (broken.invariant, broken.now_ns // MS) == ("commands-end", 1_642)
    assert broken.why == "axis.move_to(90000) is busy, and its axis has rested for 1.002 s"


MODULE_OK, FOLLOWING = 0x4000, 0x80
AXIS = {"Step": 2, "Ticket": 3, "Taken": 3, "RunKind": 1, "Moving": False}
AXIS |= {"In[0]": MODULE_OK, "In[1]": 0, "Out[1]": 0, "RoundTrip": 10}


@pytest.mark.parametrize(
    ("members", "linked", "held_s"),
    [
        ({}, True, 1),
        ({"Step": 0}, True, None),
        ({"Step": 0, "Ticket": 4}, True, 1),
        ({"Moving": True}, True, None),
        ({"In[0]": 0}, True, None),
        ({}, False, None),
        ({"RunKind": 4}, True, 4),
        ({"RoundTrip": 600}, True, 1.8),
        ({"RunKind": 10}, True, 1),
        ({"RunKind": 10, "In[1]": FOLLOWING}, True, None),
    ],
)
def test_the_law_of_an_axis_of_motion_blocks(members, linked, held_s):
    """A search for home may rest for 3 s more; a follower rests with its encoder."""
    tags = {f"Axis.{name}": value for name, value in {**AXIS, **members}.items()}
    rests = RestMeter(axes_in(lambda scan: None, Tags(tags)))
    said = [rests.update(at_ms * MS, linked=linked) for at_ms in range(0, 10_000, 100)]
    held = next((row for row, each in enumerate(said) if each), None)
    assert held == (None if held_s is None else 10 * held_s + 1)


class Tags(dict):
    """The tags of a program with one axis: its name is all that is listed."""

    def __iter__(self):
        return iter(["Axis"])


def test_a_blend_that_is_programmed_goes_on_at_rest():
    tags = Tags({f"Axis.{name}": value for name, value in AXIS.items()})
    rests = RestMeter(axes_in(lambda scan: None, tags))
    for at_ms in range(0, 10_000, 500):
        tags["Axis.Out[1]"] ^= 0x200
        assert rests.update(at_ms * MS, linked=True) is None
