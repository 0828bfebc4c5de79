"""ALMD and ALMA, row by row of the state diagrams: 1756-RM003N p. 49, 50, 64 and 65."""

import pytest
from ladder_bench import both

TAGS = """TAG Go : BOOL
TAG Ack : BOOL
TAG Reset : BOOL
TAG Off : BOOL
TAG On : BOOL
TAG A : ALARM_DIGITAL
TAG L : ALARM_ANALOG
TAG Value : REAL
"""
DIGITAL = "XIC(Go)ALMD(A,Ack,Reset,Off,On,?,?);"
ANALOG = "ALMA(L,Value,Ack,Off,On,90,80.5,20,10);"


class Bench:
    """A rung on both back ends, which must agree after every scan, 10 ms apart."""

    def __init__(self, rung):
        self.engines = both(TAGS, rung)
        self.tags = self.engines[0].tags

    def scan(self, **values):
        for engine in self.engines:
            for name, value in values.items():
                engine.tags[name.replace("__", ".")] = value
            engine.step(10)
        compiled, interpreted = (engine.memory.snapshot() for engine in self.engines)
        assert compiled == interpreted
        return self

    def state(self, *names):
        return tuple(int(self.tags[name]) for name in names)

    @property
    def alarm(self):
        return self.state("A.InAlarm", "A.Acked", "A.InAlarmUnack")


def test_an_alarm_begins_acknowledged_and_not_in_alarm_p50():
    assert Bench(DIGITAL).scan().alarm == (0, 1, 0)


def test_an_alarm_that_has_to_be_acknowledged_p49():
    bench = Bench(DIGITAL).scan()
    assert bench.scan(Go=True).alarm == (1, 0, 1)
    assert bench.scan(Ack=True).alarm == (1, 1, 0)
    assert bench.scan(Go=False).alarm == (0, 1, 0)
    assert bench.scan(Go=True).alarm == (1, 0, 1)  # Ack has not risen again
    assert bench.scan(Go=False).alarm == (0, 0, 0)
    assert bench.scan(Ack=False).scan(Ack=True).alarm == (0, 1, 0)
    assert bench.state("A.AlarmCount") == (2,)


def test_a_latched_alarm_stays_until_it_is_reset_p49():
    bench = Bench(DIGITAL).scan(A__Latched=True, Go=True)
    assert bench.scan(Reset=True).alarm == (1, 0, 1)  # the condition is still there
    assert bench.scan(Go=False, Reset=False).alarm == (1, 0, 1)
    assert bench.scan(Ack=True).alarm == (1, 1, 0)
    assert bench.scan(Reset=True).alarm == (0, 1, 0)


def test_without_acknowledgement_p50():
    bench = Bench(DIGITAL).scan(A__AckRequired=False, Go=True)
    assert bench.alarm == (1, 1, 0)
    assert bench.scan(Go=False).alarm == (0, 1, 0)


def test_an_operator_acknowledges_once():
    bench = Bench(DIGITAL).scan(Go=True).scan(A__OperAck=True)
    assert bench.alarm == (1, 1, 0)
    assert bench.state("A.OperAck") == (0,)


def test_a_condition_has_to_last_p44():
    bench = Bench("XIC(Go)ALMD(A,0,0,0,0,25,0);").scan(Go=True)
    seen = [(bench.alarm[0], *bench.state("A.MinDurationACC"))]
    for _ in range(3):
        bench.scan()
        seen.append((bench.alarm[0], *bench.state("A.MinDurationACC")))
    assert seen == [(0, 0), (0, 10), (0, 20), (1, 30)]
    bench.scan(Go=False)
    assert bench.state("A.InAlarm", "A.MinDurationACC") == (0, 0)


def test_the_condition_may_be_a_false_rung_p72():
    assert Bench(DIGITAL).scan(A__Condition=False).alarm == (1, 0, 1)


def test_enable_comes_before_disable_p44():
    bench = Bench(DIGITAL).scan(Go=True, Off=True)
    assert (bench.alarm, bench.state("A.Disabled")) == ((0, 1, 0), (1,))
    bench.scan(On=True)
    assert (bench.alarm, bench.state("A.Disabled")) == ((1, 0, 1), (0,))


@pytest.mark.parametrize(
    ("value", "levels"),
    [(50, "0000"), (80.25, "0000"), (80.5, "0100"), (90, "1100"), (20, "0010"), (9.5, "0011")],
)
def test_levels_p64(value, levels):
    bench = Bench(ANALOG).scan(Value=value)
    names = ("HH", "H", "L", "LL")
    assert "".join(map(str, bench.state(*(f"L.{name}InAlarm" for name in names)))) == levels
    assert bench.state("L.InAlarm", "L.AnyInAlarmUnack") == (int("1" in levels),) * 2


def test_a_level_ends_behind_the_deadband_p64():
    bench = Bench(ANALOG).scan(Value=85, L__Deadband=5.0)
    seen = [bench.scan(Value=value).state("L.HInAlarm") for value in (80, 75.5, 75.25, 80)]
    assert seen == [(1,), (1,), (0,), (0,)]


def test_all_levels_are_acknowledged_at_once_p55():
    bench = Bench(ANALOG).scan(Value=95)
    assert bench.state("L.HHAcked", "L.HAcked", "L.AnyInAlarmUnack") == (0, 0, 1)
    bench.scan(Ack=True)
    assert bench.state("L.HHAcked", "L.HAcked", "L.AnyInAlarmUnack") == (1, 1, 0)
    assert bench.state("L.InAlarm") == (1,)


def test_the_duration_counts_for_the_first_excursion_p59():
    bench = Bench(ANALOG).scan(Value=85, L__MinDurationPRE=10)
    assert bench.state("L.HInAlarm") == (0,)
    assert bench.scan().state("L.HInAlarm", "L.HHInAlarm") == (1, 0)
    assert bench.scan(Value=95).state("L.HInAlarm", "L.HHInAlarm") == (1, 1)


def test_rate_of_change_p65():
    """20 ms per sample: 50 to 52 is 100 per second."""
    bench = Bench(ANALOG).scan(Value=50, L__ROCPeriod=0.02, L__ROCPosLimit=90.0, L__ROCNegLimit=90.0)
    bench.scan(Value=51)
    assert bench.state("L.ROCPosInAlarm") == (0,)
    bench.scan(Value=52)
    assert bench.tags["L.ROC"] == pytest.approx(100)
    assert bench.state("L.ROCPosInAlarm", "L.ROCNegInAlarm") == (1, 0)
    bench.scan(Value=50).scan(Value=49)
    assert bench.state("L.ROCPosInAlarm", "L.ROCNegInAlarm") == (0, 1)
