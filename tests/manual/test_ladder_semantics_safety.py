"""DCS and CROUT, as docs/instructions.md reads them; both back ends, scans of 10 ms."""

from typing import Any

import pytest
from ladder_bench import both
from scanrack.ladder import LadderError

INPUTS = "".join(f"TAG {name} : BOOL\n" for name in ("A", "B", "Status", "Reset", "Enable"))
STOP = f"{INPUTS}TAG Stop : DCI_STOP\n"
DCS = "XIC(Enable)DCS(Stop,SAFETY GATE,{kind},50,{restart},{cold},A,B,Status,Reset);"
OUTPUT = f"{INPUTS}TAG Outs : BOOL\nTAG Act : BOOL\nTAG Relay : CONFIGURABLE_ROUT\n"
CROUT = "XIC(Enable)CROUT(Relay,{kind},30,Act,A,B,Status,Outs,Reset);"


class Bench:
    """Both back ends with the same inputs."""

    def __init__(self, tags: str, rung: str, **inputs: int):
        self.engines = both(tags, rung)
        self.scan(Enable=1, **inputs)

    def scan(self, count: int = 1, **inputs: int) -> None:
        for engine in self.engines:
            for name, value in inputs.items():
                engine.tags[name] = bool(value)
            for _ in range(count):
                engine.step()
        first, second = (engine.memory.snapshot() for engine in self.engines)
        assert first == second

    def __getitem__(self, name: str) -> Any:
        return self.engines[0].tags[name]


def stop(restart="MANUAL", cold="AUTOMATIC", kind="EQUIVALENT - ACTIVE HIGH", **inputs):
    return Bench(STOP, DCS.format(kind=kind, restart=restart, cold=cold), **inputs)


def relay(kind, **inputs):
    return Bench(OUTPUT, CROUT.format(kind=kind), Status=1, Outs=1, **inputs)


def state(bench, name="Stop"):
    return bench[f"{name}.O1"], bench[f"{name}.FP"], bench[f"{name}.FaultCode"]


def test_manual_restart_needs_a_rising_reset():
    gate = stop(A=0, B=0, Status=1)
    gate.scan(A=1, B=1)
    assert state(gate) == (False, False, 0)
    gate.scan(Reset=1)
    assert gate["Stop.O1"]
    gate.scan(A=0, B=0)
    assert not gate["Stop.O1"]
    gate.scan(A=1, B=1)
    assert (gate["Stop.O1"], gate["Stop.DiagnosticCode"]) == (False, 5)
    gate.scan(Reset=0)
    gate.scan(Reset=1)
    assert gate["Stop.O1"]


def test_automatic_restart_follows_the_channels():
    gate = stop("AUTOMATIC", A=0, B=1, Status=1, kind="COMPLEMENTARY")
    gate.scan(A=1, B=0)
    assert gate["Stop.O1"]
    gate.scan(A=0, B=1)
    assert not gate["Stop.O1"]


def test_a_cold_start_that_is_manual_needs_a_test_of_the_device():
    assert stop("AUTOMATIC", "AUTOMATIC", A=1, B=1, Status=1)["Stop.O1"]
    gate = stop("AUTOMATIC", "MANUAL", A=1, B=1, Status=1)
    assert not gate["Stop.O1"]
    gate.scan(A=0, B=0)
    gate.scan(A=1, B=1)
    assert gate["Stop.O1"]


@pytest.mark.parametrize(("channel", "code"), [("A", 0x4001), ("B", 0x4000)])
def test_channels_that_differ_too_long_are_a_fault(channel, code):
    gate = stop("AUTOMATIC", A=1, B=1, Status=1)
    gate.scan(5, **{channel: 0})
    assert state(gate) == (False, False, 0)
    gate.scan()
    assert state(gate) == (False, True, code)
    gate.scan(**{channel: 1}, Reset=1)
    assert state(gate) == (False, True, code)
    gate.scan(A=0, B=0, Reset=0)
    gate.scan(Reset=1)
    assert state(gate) == (False, False, 0)
    gate.scan(A=1, B=1)
    assert gate["Stop.O1"]


@pytest.mark.parametrize(("channel", "code"), [("A", 0x4002), ("B", 0x4003)])
def test_a_channel_that_leaves_alone_and_comes_back_is_a_fault(channel, code):
    gate = stop("AUTOMATIC", A=1, B=1, Status=1)
    gate.scan(**{channel: 0})
    gate.scan(**{channel: 1})
    assert state(gate) == (False, True, code)


def test_an_input_status_that_turns_off_is_a_fault():
    gate = stop("AUTOMATIC", A=1, B=1)
    assert (*state(gate), gate["Stop.DiagnosticCode"]) == (False, False, 0, 0x20)
    gate.scan(Status=1)
    assert gate["Stop.O1"]
    gate.scan(Status=0)
    assert state(gate) == (False, True, 0x20)
    gate.scan(Status=1)
    assert gate["Stop.FP"]
    gate.scan(Reset=1)
    assert state(gate) == (True, False, 0)


def test_a_false_rung_turns_everything_off():
    gate = stop("AUTOMATIC", A=1, B=1, Status=1)
    gate.scan(Enable=0)
    assert (gate["Stop.O1"], gate["Stop.EnableIn"]) == (False, False)
    contactor = relay("POSITIVE", Act=1)
    contactor.scan(Enable=0)
    assert (contactor["Relay.O1"], contactor["Relay.O2"]) == (False, False)


@pytest.mark.parametrize(("kind", "on"), [("POSITIVE", 1), ("NEGATIVE", 0)])
def test_outputs_stay_on_with_their_feedback(kind, on):
    contactor = relay(kind, A=not on, B=not on)
    contactor.scan(2, Act=1)
    contactor.scan(9, A=on, B=on)
    assert (*state(contactor, "Relay"), contactor["Relay.O2"]) == (True, False, 0, True)
    contactor.scan(2, Act=0)
    contactor.scan(9, A=not on, B=not on)
    assert state(contactor, "Relay") == (False, False, 0)


FEEDBACKS = [
    ([{"Act": 1}, {}, {}, {}], 0x5006),
    ([{"Act": 1}, {"A": 1}, {}, {}], 0x5008),
    ([{"Act": 1}, {"A": 1, "B": 1}, {"A": 0, "B": 0}], 0x5000),
    ([{"Act": 1}, {"A": 1, "B": 1}, {"A": 0}], 0x5001),
    ([{}, {"A": 1, "B": 1}], 0x5003),
    ([{}, {"B": 1}], 0x5005),
    ([{"Act": 1}, {"A": 1, "B": 1}, {"Act": 0}, {}, {}, {}], 0x5009),
    ([{"Act": 1}, {"A": 1, "B": 1}, {"Act": 0}, {"B": 0}, {}, {}], 0x500A),
    ([{"Status": 0}], 0x20),
    ([{"Outs": 0}], 0x21),
]


@pytest.mark.parametrize(
    ("scans", "code"), FEEDBACKS, ids=lambda each: f"{each:x}" if isinstance(each, int) else ""
)
def test_faults_of_the_feedback(scans, code):
    contactor = relay("POSITIVE")
    for inputs in scans:
        assert not contactor["Relay.FP"]
        contactor.scan(**inputs)
    assert (*state(contactor, "Relay"), contactor["Relay.O2"]) == (False, True, code, False)


def test_after_a_reset_actuate_has_to_rise():
    contactor = relay("POSITIVE")
    contactor.scan(5, Act=1)
    assert contactor["Relay.FP"]
    contactor.scan(Reset=1)
    assert (*state(contactor, "Relay"), contactor["Relay.DiagnosticCode"]) == (False, False, 0, 0x5000)
    contactor.scan(Act=0)
    contactor.scan(Act=1)
    assert contactor["Relay.O1"]


@pytest.mark.parametrize(
    ("rung", "found"),
    [
        (
            "DCS(Stop,SAFETY GATE,EQUIVALENT - ACTIVE HIGH,2,MANUAL,MANUAL,A,B,Status,Reset);",
            "time 2 ms is out of range; must be 5 to 3000 ms",
        ),
        ("DCS(Relay,SAFETY GATE,COMPLEMENTARY,50,MANUAL,MANUAL,A,B,Status,Reset);", "a DCI_STOP is needed"),
        (
            "DCS(Stop,GATE,COMPLEMENTARY,50,MANUAL,MANUAL,A,B,Status,Reset);",
            "GATE is neither a tag nor a word",
        ),
    ],
)
def test_wrong_operands_are_refused(rung, found):
    with pytest.raises(LadderError, match=found):
        both(f"{STOP}TAG Relay : CONFIGURABLE_ROUT\n", rung)
