"""The PCL601 does the same whether time runs at once or in pieces, and its moves are what arithmetic says."""

from __future__ import annotations

from decimal import Decimal, getcontext

import pytest
from bench601 import MS, Bench601
from hypothesis import example, given
from hypothesis import strategies as st
from scanrack.io_images.pcl601 import Register
from scanrack.io_images.pcl601.program import parse_program
from scanrack.runtime import Contact
from scanrack.runtime.controllers.pcl601.motor import EncoderModel
from scanrack.runtime.controllers.pcl601.program import ProgramMachine
from scanrack.runtime.line.rtu import frame
from scanrack.runtime.machine.contacts import GROUND, OPEN

PROGRAM = "MOVE 300\nFINISH\nOUTPUTS 10000001\nWAIT 7\nSLEW\nWAIT 40\nSTOPSOFT\nFINISH\nREPEAT\nEND"
PLACES = st.integers(-700, 700)
CONTACTS = st.one_of(
    st.sampled_from([GROUND, OPEN]),
    PLACES.map(lambda low: Contact(low=low)),
    PLACES.map(lambda high: Contact(high=high)),
)
PIN_NAMES = ("in2", "home", "jog_plus", "jog_minus", "fast_jog", "hard_plus", "soft_plus", "soft_minus")
VALUES = {
    Register.STEPS: st.integers(0, 1500),
    Register.ABS_TARGET: st.integers(-900, 900),
    Register.ACCEL: st.sampled_from([100, 3333, 50_000, 9_999_999]),
    Register.BASE_SPEED: st.integers(200, 900),
    Register.MAX_SPEED: st.integers(800, 9000),
    Register.JOG_SPEED: st.integers(800, 9000),
    Register.DIRECTION: st.integers(0, 1),
    Register.INDEX_ON_FLY: st.integers(0, 1),
    Register.OUTPUT_ON_FLY: st.integers(0, 1),
    Register.FIRST_OUTPUT_POSITION: st.integers(0, 300),
    Register.STEPS_BETWEEN_OUTPUTS: st.integers(0, 50),
    Register.NUMBER_OF_OUTPUTS: st.integers(0, 9),
    Register.ENCODER_AUTOCORRECT: st.integers(0, 1),
    Register.ENCODER_RETRIES: st.integers(0, 3),
    Register.ENCODER_DELAY: st.integers(0, 30),
}
WRITES = st.one_of(*(st.tuples(st.just(register), values) for register, values in VALUES.items()))
ACTIONS = st.one_of(
    st.tuples(st.just("write"), WRITES),
    st.tuples(st.just("code"), st.sampled_from([1, 1, 2, 3, 4, 4, 5, 6, 6, 10, 12, 15])),
    st.tuples(st.just("pin"), st.tuples(st.sampled_from(PIN_NAMES), CONTACTS)),
)
SCRIPTS = st.lists(st.tuples(ACTIONS, st.integers(0, 900)), max_size=14)


def play(script, pieces):
    """Play a script, waiting so many ms after each action in pieces of so many ns; return what was seen."""
    runner = ProgramMachine(parse_program(PROGRAM))
    bench = Bench601(encoder=EncoderModel(3, "lose_steps_once", 9), runner=runner)
    seen = []
    for (kind, what), wait_ms in script:
        now_ns = bench.bus.now_ns
        if kind == "write":
            bench.write(*what)
        elif kind == "code":
            bench.code(what)
        else:
            bench.pin(*what)
        end_ns = now_ns + 60 * MS + wait_ms * MS
        count = 0
        while bench.bus.now_ns < end_ns:
            bench.bus.run_until(min(end_ns, bench.bus.now_ns + pieces[count % len(pieces)]))
            count += 1
        seen.append(
            (
                bench.bus.now_ns,
                bench.position,
                list(bench.controller.read().values()),
                bench.controller.output_pins,
                list(bench.controller.axis.fly.positions),
                bench.controller.program_running,
            )
        )
    return seen


@pytest.mark.slow
@given(SCRIPTS, st.lists(st.integers(100_000, 50 * MS), min_size=1, max_size=5))
@example([(("write", (Register.STEPS, 900)), 0), (("code", 1), 800), (("code", 12), 900)], [333_333])
def test_in_pieces_or_at_once(script, pieces):
    assert play(script, [10**12]) == play(script, pieces)


@given(
    st.integers(100, 9_999_999),
    st.integers(1, 5000),
    st.integers(1, 45_000),
    st.integers(1, 1_000_000),
    st.booleans(),
)
def test_a_move_takes_what_arithmetic_says(accel, base, more, steps, forward):
    getcontext().prec = 40
    top = base + more
    bench = Bench601()
    for register, value in ((Register.ACCEL, accel), (Register.BASE_SPEED, base), (Register.MAX_SPEED, top)):
        bench.controller.values[register] = value
    bench.controller.index(steps if forward else -steps)
    bench.controller.settle(0)
    a, b, m, n = (Decimal(value) for value in (accel, base, top, steps))
    if (m * m - b * b) / a <= n:
        seconds = 2 * (m - b) / a + (n - (m * m - b * b) / a) / m
    else:
        seconds = 2 * ((b * b + a * n).sqrt() - b) / a
    end_ns = bench.controller.next_wake_ns  # no switch on the way: the last step comes next
    bench.controller.advance(end_ns - 1)
    assert abs(bench.position) == steps - 1
    bench.controller.advance(end_ns)
    assert bench.position == (steps if forward else -steps)
    assert not bench.controller.busy
    # the peak is rounded to 1e-9 step/s: over a second of ramp that is 1e-9 step, at 1 step/s 1 ns
    assert abs(end_ns - seconds * 10**9) < 2 + steps * Decimal("1e-6")


@given(st.binary(max_size=300), st.integers(1, 40))
def test_bytes_of_any_kind_do_no_harm(data, pause_bytes):
    bench = Bench601()
    bench.bus.send(data, bench.unit.line_format, gap_ns=pause_bytes * 50_000)
    bench.wait(2000)
    if bench.unit.line_format.parity == "E":
        good = frame(bench.controller.values[Register.ADDRESS], b"\x11")
        assert bench.exchange(good)[1:2] == b"\x11"


TALK = "@@@@1111023589ABCDEGHIJMNOPSTVZRFLW!$%'(+,-./:;[]^{}~=\r\r\r\r\n x"


@given(st.text(TALK, max_size=120))
@example("@1H1\r@1.\r@1EA1\r@1N5\r@1G\r@1,\r@1P\r@1N\r@1M\r")
def test_talk_of_any_kind_does_no_harm(text):
    bench = Bench601()
    bench.to_ascii()
    bench.exchange(text.encode("ascii"))
    bench.wait(1000)
    bench.exchange(b"\r")
    own = bench.controller.values[Register.ADDRESS]
    assert bench.talk("@%") == f"{own}\r\n"
    assert 0 <= int(bench.controller.errors) < 1 << 14
