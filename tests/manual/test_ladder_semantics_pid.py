"""PID, worked by hand; ids name the page (RM003 = 1756-RM003N, help = anti-reset windup, PID)."""

import pytest
from ladder_bench import both

TAGS = "TAG Go : BOOL := true\nTAG P : PID\nTAG PV : REAL\nTAG CV : REAL\nTAG Tie : REAL\nTAG Hold : BOOL\n"
RUNG = "XIC(Go)PID(P,PV,Tie,CV,0,Hold,25);"


class Loop:
    """A loop on both back ends, which must agree after every update of a second."""

    def __init__(self, rung=RUNG, **members):
        self.engines = both(TAGS, rung)
        for engine in self.engines:
            for name, value in {"UPD": 1.0, "MAXS": 200.0, "MAXCV": 1000.0, **members}.items():
                engine.tags[f"P.{name}"] = value
        self.tags = self.engines[0].tags

    def update(self, **values):
        for engine in self.engines:
            for name, value in values.items():
                engine.tags[name if name in ("PV", "Go", "Tie", "Hold") else f"P.{name}"] = value
            engine.step(1000)
        compiled, interpreted = (engine.memory.snapshot() for engine in self.engines)
        assert compiled == interpreted
        return self.tags["P.OUT"]


def test_the_error_is_in_percent_of_the_span_rm003_p511():
    loop = Loop(KP=2.0, BIAS=5.0)
    assert loop.update(SP=120.0, PV=100.0) == 25.0  # 2 * 20/200 * 100 + 5
    assert loop.tags.CV == 250.0
    assert loop.tags["P.ERR"] == 20.0


def test_control_action_reverses_the_error_rm003_p517():
    assert Loop(KP=2.0, CA=True).update(SP=100.0, PV=120.0) == 20.0


def test_the_integral_grows_with_time_rm003_p512():
    """KI is 1/s: 10 % for a second at 0.5/s are 5 %."""
    loop = Loop(KI=0.5)
    assert [loop.update(SP=120.0, PV=100.0) for _ in range(3)] == [5.0, 10.0, 15.0]


def test_the_derivative_is_of_pv_or_of_the_error_rm003_p517():
    of_value, of_error = (
        Loop(KD=3.0, MINO=-100.0, MAXO=100.0),
        Loop(KD=3.0, DOE=True, MINO=-100.0, MAXO=100.0),
    )
    for loop in (of_value, of_error):
        assert loop.update(SP=100.0, PV=100.0) == 0.0
    assert of_value.update(SP=120.0) == 0.0  # a step of SP is not a change of PV
    assert of_error.update(SP=120.0) == 30.0
    assert of_value.update(PV=102.0) == -3.0


def test_dependent_gains_rm003_p512():
    """KP 2, reset 0.5 min, rate 0: 10 % give 20, and 10 * 2 / 30 a second."""
    loop = Loop(PE=True, KP=2.0, KI=0.5)
    assert loop.update(SP=120.0, PV=100.0) == pytest.approx(20 + 20 / 30)


def test_the_sum_is_frozen_at_a_limit_help():
    loop = Loop(KI=5.0, MAXO=80.0)
    assert [loop.update(SP=120.0, PV=100.0) for _ in range(3)] == [50.0, 80.0, 80.0]
    assert loop.tags["P.OLH"] is True
    assert loop.update(SP=100.0, PV=102.0) == 45.0  # 50 - 5 * 1


@pytest.mark.parametrize(("mode", "values"), [("SWM", {"SO": 40.0}), ("MO", {"Tie": 40.0})])
def test_the_change_from_manual_to_automatic_has_no_bump_help(mode, values):
    loop = Loop(KP=1.0, KI=0.1, **{mode: True})
    assert loop.update(SP=100.0, PV=90.0, **values) == 40.0
    assert loop.update(SP=100.0, PV=90.0, **{mode: False}) == pytest.approx(40.5)  # 0.1 * 5 % more


def test_inputs_are_scaled_rm003_p513():
    loop = Loop(KP=1.0, MAXI=4000.0)
    loop.update(SP=110.0, PV=2000.0)
    assert loop.tags["P.PV"] == 100.0
    assert loop.tags["P.OUT"] == 5.0


def test_hold_puts_the_output_to_its_value():
    assert Loop(KP=1.0).update(SP=100.0, PV=0.0, Hold=True) == 2.5  # 25 of 1000


@pytest.mark.parametrize(("members", "code"), [({"UPD": 0.0}, 35), ({"SP": 201.0}, 36)])
def test_minor_faults(members, code):
    loop = Loop(KP=1.0, **members)
    loop.update(PV=100.0)
    assert [(fault.type, fault.code) for fault in loop.engines[0].minor_faults] == [(4, code)]


def test_equal_limits_become_the_default_rm003_p517():
    loop = Loop(KP=1.0, MAXO=7.0, MINO=7.0)
    assert loop.update(SP=120.0, PV=100.0) == 10.0
    assert (loop.tags["P.MAXO"], loop.tags["P.MINO"]) == (100.0, 0.0)


def test_a_false_rung_leaves_the_output():
    loop = Loop(KP=1.0)
    loop.update(SP=120.0, PV=100.0)
    assert loop.update(Go=False, PV=0.0) == 10.0
    assert loop.tags["P.EN"] is False


def test_alarms_of_the_process_variable_rm003_p512():
    loop = Loop(KP=1.0, PVH=150.0, PVL=10.0, DVP=30.0, DVN=30.0)
    loop.update(SP=100.0, PV=160.0)
    assert [loop.tags[f"P.{name}"] for name in ("PVHA", "PVLA", "DVPA", "DVNA")] == [True, False, True, False]
