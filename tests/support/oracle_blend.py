"""The oracle's blend moves [chapter 4, Blend Move; chapter 5, Blend Move Programming]."""

from __future__ import annotations

import oracle_commands as commands
import oracle_motion as motion
from oracle_bits import COMMAND_ERROR, ESTOP, LIMITS, PROGRAM, TRANSMIT

SHAPES = {0b00: motion.CONSTANT, 0b01: motion.TRIANGULAR, 0b11: motion.TRAPEZOIDAL, 0b10: motion.CONSTANT}


class Session:
    """A profile in the making."""

    def __init__(self):
        self.wanted = 0
        self.types = []
        self.segments = []
        self.good = True
        self.final_deceleration = 0
        self.final_shape = motion.CONSTANT


def handshake(m, edge1):
    """Blend Move Programming Routine, steps 1 to 6."""
    program, transmit = m.o1 & PROGRAM, m.o1 & TRANSMIT
    if m.session is not None and not program:
        finish(m)
    if not transmit:
        m.ack = False
    if not (program and edge1 & TRANSMIT):
        return
    if m.session is not None:
        m.ack = True
        segment_block(m)
    elif m.command_error or m.invalid_profile:
        return
    elif m.in_motion():
        commands.error(m)  # CMD-18; any other move goes on
        if m.op == "blend":
            stop(m)
            m.profile = None
    else:
        m.resumable = False
        m.ack = True
        m.profile = None
        m.session = Session()
        first_block(m)


def stop(m):
    """Brake now, even beyond the end (A-111); on the last ramp anyway, unless another one ends sooner."""
    was, m.deceleration, m.shape = m.course, m.profile.final_deceleration, m.profile.final_shape
    m.controlled_stop("blend stop")
    if was.only_brakes_from(m.start_ns) and was.last_step < m.course.last_step + 0.5:
        m.course = was


def finish(m):
    """Bit 8 is off: the profile is stored if all of it was good (A-60)."""
    session, m.session = m.session, None
    m.ack = False
    if session.good and len(session.segments) == session.wanted:
        m.profile = session


def fault(m, command_error=False):
    """Invalid Profile; Command Error where it is listed (A-57)."""
    m.session.good = False
    m.invalid_profile = True
    m.command_error = m.command_error or command_error
    m.resumable = False


def first_block(m):
    count, types_9_16, types_1_8, final = (word & 0xFFFF for word in m.words[2:6])
    session = m.session
    session.wanted = count
    both = types_1_8 | types_9_16 << 16
    session.types = [SHAPES[both >> 2 * index & 0b11] for index in range(16)]
    session.final_deceleration = final & 0x3FFF
    session.final_shape = SHAPES[final >> 14]
    if not 2 <= count <= 16:
        fault(m)  # PRF-04
    if not 1 <= session.final_deceleration <= 2000 or final >> 14 == 0b10:
        fault(m, command_error=True)  # PRF-07


def segment_block(m):
    session = m.session
    if not session.good or len(session.segments) == session.wanted:
        return  # A-57; A-60
    vo = m.starting_speed
    length, vs = commands.target(m), commands.speed(m, 1)
    rate = m.words[6]
    shape = session.types[len(session.segments)]
    before = session.segments[-1][1] if session.segments else vo
    if vs is not None and vs < vo:
        fault(m, command_error=True)  # CMD-05
    if vs is None:
        fault(m)
        m.leave_open(COMMAND_ERROR)  # CMD-04 speaks of speeds, A-57 of blend faults without it
    if length is None or length < 1 or not 1 <= rate <= 2000:
        fault(m)
    if session.segments and vs == before:
        fault(m)  # PRF-06
    if length is not None and sum(row[0] for row in session.segments) + length > 8_388_607:
        fault(m)
    if not session.good:
        return
    way = motion.ramp_distance(before, vs, rate, shape)
    if len(session.segments) == session.wanted - 1:
        way += motion.ramp_distance(vs, vo, session.final_deceleration, session.final_shape)
    if way > length + motion.NUDGE:
        fault(m)  # PRF-05
        return
    session.segments.append((length, vs, rate, shape))


def run(m, direction, refused):
    """Run Blend Move Profile; CMD-16, CMD-17."""
    refused = commands.is_busy(m) or refused
    if any(m.words[1:]) or m.profile is None:
        commands.error(m)
        refused = True
    if commands.refused_by_input(m, ESTOP | LIMITS) or refused:
        return
    profile = m.profile
    course = motion.blend(
        m.start_ns,
        m.starting_speed,
        profile.segments,
        profile.final_deceleration,
        profile.final_shape,
    )
    m.hold_error = False
    m.start("blend", direction, course)
