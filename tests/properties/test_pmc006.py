"""A PMC006x3s at random: in pieces as at once, through noise, there and back."""

from __future__ import annotations

import random
from typing import Any

from bench006 import MS
from hypothesis import given
from hypothesis import strategies as st
from scanrack.io_images.pmc006.frame import Frame, Framer, command, decode, encode
from scanrack.io_images.pmc006.instructions import INSTRUCTIONS
from scanrack.io_images.pmc006.program import USER_OPS, UserInstruction, assemble
from scanrack.runtime import Contact
from scanrack.runtime.controllers.pmc006.controller import Pmc006Controller
from scanrack.runtime.controllers.pmc006.line import Pmc006
from scanrack.runtime.controllers.pmc006.pins import Pin
from scanrack.runtime.controllers.pmc006.ramps import Pmc006Speeds, plan_move, plan_run, plan_slowing
from scanrack.runtime.kinematics import FOREVER

int32 = st.integers(-(1 << 31), (1 << 31) - 1)
bytes_ = st.integers(0, 255)
frames = st.builds(Frame, bytes_, bytes_, int32)
coefficients = st.integers(0, 8)


@st.composite
def speeds(draw: st.DrawFn) -> Pmc006Speeds:
    top = draw(st.integers(65, 256_000))
    edge = st.integers(65, min(top, 30_000))
    return Pmc006Speeds(draw(edge), top, draw(edge), draw(coefficients), draw(coefficients))


@given(frames)
def test_a_frame_there_and_back(frame: Frame) -> None:
    assert decode(encode(frame.second, frame.third, frame.data)) == frame


@given(st.lists(frames, max_size=5), st.integers(1, 7))
def test_frames_are_found_however_the_stream_is_cut(sent: list[Frame], size: int) -> None:
    stream = b"".join(encode(frame.second, frame.third, frame.data) for frame in sent)
    framer, found = Framer(), []
    for at in range(0, len(stream), size):
        found += framer.feed(stream[at : at + size])
    assert found == sent
    assert (len(framer), framer.skipped) == (0, 0)


def test_noise_never_escapes_and_costs_no_frame_once_the_line_is_quiet() -> None:
    draw = random.Random(6)
    device, now_ns = Pmc006(Pmc006Controller(address=1)), 0
    for _ in range(300):
        noise = bytearray(draw.randbytes(draw.randrange(30)))
        if draw.random() < 0.5:
            noise += command(1, ord("k"))
            noise[draw.randrange(len(noise))] ^= 1 << draw.randrange(8)
        for value in noise:
            now_ns += draw.randrange(MS, 40 * MS)
            device.receive(now_ns, bytes((value,)))
            device.advance(now_ns)
        now_ns += 51 * MS
        address = device.controller.address  # the noise may have changed it
        device.receive(now_ns, command(address, ord("K")))
        answer = decode(device.advance(now_ns))
        assert answer == Frame(0x7A, address, device.controller.memory["ext_trigger_mode"])


@given(st.integers(1, 100_000), speeds(), st.integers(0, 10**12))
def test_a_move_ends_on_its_step_and_never_goes_back(
    steps: int, given_speeds: Pmc006Speeds, now_ns: int
) -> None:
    motion = plan_move(now_ns, 7, -steps, given_speeds)
    assert motion.final_steps == steps
    assert motion.end_ns is not None
    assert motion.position_at(motion.end_ns) == 7 - steps
    span = motion.end_ns - now_ns
    made = [motion.travel_at(now_ns + span * part // 20) for part in range(21)]
    assert made == sorted(made)


@given(speeds(), st.integers(0, 10**10), coefficients)
def test_slowing_takes_over_where_the_run_is(
    given_speeds: Pmc006Speeds, after_ns: int, coefficient: int
) -> None:
    running = plan_run(0, 0, 1, given_speeds)
    slowing = plan_slowing(running, after_ns, given_speeds.stop_sps, coefficient)
    assert slowing.end_ns is not None
    assert slowing.final_steps is not None
    assert slowing.steps_at(after_ns) == running.steps_at(after_ns) <= slowing.final_steps
    assert slowing.end_ns >= after_ns


@st.composite
def user_instructions(draw: st.DrawFn) -> UserInstruction:
    op = draw(st.sampled_from(list(USER_OPS.values())))
    low, high = op.data or (0, 0)
    data = st.sampled_from(op.values) if op.values else st.integers(low, min(high, 3000))
    return UserInstruction(op.name, draw(st.integers(*op.options)), draw(data))


programs = st.lists(user_instructions(), max_size=12)


@given(programs)
def test_a_program_there_and_back(lines: list[UserInstruction]) -> None:
    assert assemble("\n".join(map(str, lines))).lines == tuple(lines)


happenings = st.one_of(
    st.tuples(st.sampled_from([row.code for row in INSTRUCTIONS]), st.integers(0, 9) | st.integers(0, 5000)),
    st.tuples(
        st.sampled_from(Pin),
        st.booleans()
        | st.builds(Contact, low=st.integers(-300, 300))
        | st.builds(Contact, high=st.integers(-300, 300)),
    ),
    st.just("power"),
)


def do(controller: Pmc006Controller, happening: Any) -> object:
    """Let one thing happen; return what the controller says to it."""
    if happening == "power":
        controller.power_cycle()
        return None
    what, value = happening
    if isinstance(what, Pin):
        controller.set_pin(what, value)
        return None
    return controller.execute(what, value)


def seen(controller: Pmc006Controller) -> tuple[object, ...]:
    """Return all that can be seen of a controller."""
    interpreter, axis = controller.interpreter, controller.axis
    state = interpreter.running, interpreter.line, interpreter.counter, interpreter.equal, interpreter.paused
    levels = controller.levels, controller.gpio
    return axis.physical, axis.position, axis.doing, controller.status1, controller.status2, levels, state


@given(
    programs,
    st.lists(st.tuples(st.integers(0, 700 * MS), happenings), min_size=1, max_size=12),
    st.lists(st.integers(0, 4000 * MS), max_size=25),
)
def test_in_pieces_it_is_what_it_is_at_once(
    lines: list[UserInstruction], plan: list[tuple[int, Any]], glances: list[int]
) -> None:
    text = "\n".join(map(str, lines))
    whole, pieces = (Pmc006Controller(address=1, program=assemble(text)) for _ in range(2))
    at_ns = 0
    for wait_ns, happening in plan:
        for glance in sorted(glance for glance in glances if at_ns <= glance < at_ns + wait_ns):
            pieces.advance(glance)
            pieces.next_ns()
        at_ns += wait_ns
        whole.advance(at_ns)
        pieces.advance(at_ns)
        assert seen(whole) == seen(pieces)
        assert do(whole, happening) == do(pieces, happening)
        assert seen(whole) == seen(pieces)
        assert at_ns <= whole.next_ns() <= FOREVER
