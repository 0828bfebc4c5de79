"""The CPU's mode in invariants: clocks pause while the logic rests, commands are the words in force."""

from __future__ import annotations

import pytest
from scanrack.io_images.amci3601 import Configuration, Direction, Idle, InputBit, Manual, StatusView
from scanrack.jobs.fuzz import Scenario, TrialBench, always, eventually, never
from scanrack.runtime import FaultKind, InjectedFault, RackSpec

MS = 1_000_000
USED = InputBit.HOME | InputBit.ESTOP | InputBit.CW_LIMIT | InputBit.CCW_LIMIT
WORDS = Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500).to_image()
JOG, IDLE = Manual(Direction.CW, 400).to_image(), Idle().to_image()
KEY_FROM_100_TO_300_MS = Scenario(incidents=(InjectedFault(100 * MS, FaultKind.PROGRAM_MODE, 0, 200 * MS),))


def jogs_until_the_tenth_call_after_100_ms():
    calls = 0

    def logic(scan):
        nonlocal calls
        status, out = StatusView(scan.slot[1].inputs), scan.slot[1].outputs
        calls += scan.now_ns >= 100 * MS
        if status.CONFIG_ERROR:
            out.load(WORDS)
        else:
            out.load(IDLE if status.MODE_CONFIG or calls > 10 else JOG)

    return logic


def broken(*invariants, mode="run"):
    slot = {"number": 1, "module": "amci3601"}
    spec = RackSpec.model_validate({"program": "none.py", "mode": mode, "slot": [slot]})
    bench = TrialBench(spec, jogs_until_the_tenth_call_after_100_ms, invariants, 250)
    return bench.run(KEY_FROM_100_TO_300_MS).broken


def ends(now):
    return now.slot[1].outputs[0] == 0


def after_100_ms(now):
    return now.ns >= 100 * MS


def test_a_clock_pauses_while_the_logic_rests():
    """The program needs ten calls, of which the key in program takes away those between 100 and 300 ms."""
    assert broken(eventually("50 ms", after=after_100_ms)(ends)) is None


def test_a_clock_may_run_on():
    late = broken(eventually("50 ms", after=after_100_ms, while_resting=True)(ends))
    assert late.now_ns == 152 * MS  # the first scan more than 50 ms after the one at 100 ms


def test_a_clock_that_has_paused_runs_out_nevertheless():
    """From 100 to 102 ms and again from 302 ms on, less the 200 ms between: 20 ms are over at 322 ms."""
    late = broken(eventually("15 ms", after=after_100_ms)(lambda _now: False))
    assert 300 * MS < late.now_ns < 330 * MS
    assert "ms in program mode not counted" in late.why


def test_commands_that_nobody_sends_are_not_in_force():
    @never
    def jogs_at_rest(now):
        return now.mode == "program" and (now.slot[1].commands or now.slot[1].motions)

    @always
    def written_words_stay(now):
        return not now.resting or now.slot[1].outputs[0] != 0

    assert broken(jogs_at_rest, written_words_stay) is None


@pytest.mark.parametrize(
    ("mode", "modes"), [("run", {"run", "program"}), ("test", {"test", "program", "run"})]
)
def test_the_mode_is_told(mode, modes):
    seen = set()

    @always
    def look(now):
        seen.add((now.mode, now.resting))
        return True

    broken(look, mode=mode)
    assert {name for name, _resting in seen} == modes
    assert {name for name, resting in seen if resting} == {"program"}


def test_in_test_mode_nothing_is_in_force():
    @never
    def in_force(now):
        return now.mode == "test" and now.slot[1].configuring

    assert broken(in_force, mode="test") is None
