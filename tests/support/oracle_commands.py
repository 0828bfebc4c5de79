"""The oracle's chapter 4 and 5: what a change in the command words does, and what refuses it.

`edge0` and `edge1` are the bits of the two command words that went from 0 to 1.
"Only a 0 to 1 transition of any of the control bits will cause the specified
operation to take place" [chapter 4, General Command Mode Operation Notes 3].
"""

from __future__ import annotations

import oracle_blend
import oracle_follower
import oracle_homing
import oracle_manual
import oracle_motion as motion
from oracle_bits import (
    ABSOLUTE,
    ENCODER_MOVE,
    ESTOP,
    EXTERNAL,
    FIND_HOME_CCW,
    FIND_HOME_CW,
    FOLLOW,
    HOLD,
    IMMEDIATE_STOP,
    LIMITS,
    MANUAL_CCW,
    MANUAL_CW,
    PRESET_ENCODER,
    PRESET_POSITION,
    RELATIVE,
    RESERVED_14,
    RESET_ERRORS,
    RESUME,
    RUN_BLEND_CCW,
    RUN_BLEND_CW,
    S_CURVE,
    STORE_MINIMUM,
    TRAPEZOIDAL,
)


def command(m, edge0, edge1):
    if m.config_error:
        return
    if m.op == "follower":
        oracle_follower.follow(m)
        edge1 = 0  # words 2 to 7 were the follower's: no block, no distance
        if m.op == "follower" or m.command_error:
            oracle_blend.handshake(m, edge1)
            return
    if m.command_error or m.invalid_profile:
        oracle_blend.handshake(m, edge1)
        if edge0 & RESET_ERRORS and m.o0 == RESET_ERRORS and m.o1 == 0:
            reset_errors(m)
        return
    if edge0 & (HOLD | IMMEDIATE_STOP) and m.o0 in (HOLD, IMMEDIATE_STOP) and m.in_motion():
        if m.session is not None:
            oracle_blend.handshake(m, edge1)
        one_command(m, edge0)  # whatever else the LSW says
        return
    if m.firmware >= (4, 1) and edge1 & FOLLOW:
        oracle_blend.handshake(m, 0)
        oracle_follower.enter(m)
        return
    oracle_blend.handshake(m, edge1)
    if m.command_error or m.invalid_profile:
        return
    several = edge0 and m.o0 & m.o0 - 1
    if m.firmware >= (3, 1) and edge1 & STORE_MINIMUM and not several:  # the command word is first
        store_minimum(m)
    if m.command_error or not edge0:
        return
    one_command(m, edge0)


def one_command(m, edge0):
    """A bit of the command MSW went from 0 to 1."""
    bits = m.o0 & 0x7FFF
    if bits & bits - 1:
        several_commands(m, edge0)
    elif bits == RESERVED_14:
        error(m)
    elif bits == IMMEDIATE_STOP:
        m.resumable = False
        if m.in_motion():
            m.cut()
    elif bits == HOLD:
        hold(m)
    elif bits == RESET_ERRORS:
        if m.o1:
            error(m)
        else:
            reset_errors(m)
    else:
        move_or_preset(m, bits, refused=False)


def several_commands(m, edge0):
    """CMD-02, and for each of the new commands what is wrong with the words for it (A-110)."""
    for number in range(15):
        if edge0 & 1 << number:
            move_or_preset(m, 1 << number, refused=True)
    error(m)
    if m.op in ("manual", "registration", "registration end"):
        m.controlled_stop("manual stop")


def move_or_preset(m, bits, refused):
    """Commands that their words can refuse; `refused` says that they are so already (A-110)."""
    if bits == RESUME:
        resume(m, refused)
    elif bits in (PRESET_POSITION, PRESET_ENCODER):
        preset(m, bits, refused)
    elif bits in (ABSOLUTE, RELATIVE):
        absolute_or_relative(m, bits == ABSOLUTE, refused)
    elif bits in (FIND_HOME_CW, FIND_HOME_CCW):
        oracle_homing.find_home(m, 1 if bits == FIND_HOME_CW else -1, refused)
    elif bits in (MANUAL_CW, MANUAL_CCW):
        oracle_manual.begin(m, 1 if bits == MANUAL_CW else -1, refused)
    elif bits in (RUN_BLEND_CW, RUN_BLEND_CCW):
        oracle_blend.run(m, 1 if bits == RUN_BLEND_CW else -1, refused)


# ---- errors


def error(m, profile=False):
    """Command Error, and Invalid Profile for the causes that stand in both lists (A-20)."""
    m.command_error = True
    m.invalid_profile = m.invalid_profile or profile
    m.resumable = False


def is_busy(m):
    """CMD-03: a move before the previous one is complete; the pulse of a one-shot is over at once."""
    if m.in_motion():
        error(m)
    return m.in_motion()


def reset_errors(m):
    """Chapter 4, Reset Errors: not Configuration Error, not Position Invalid, not Move Complete."""
    m.command_error = m.invalid_profile = m.home_invalid = m.input_error = False
    m.hold_error = False
    m.resumable = False


# ---- parameters [chapter 5]


def pair(msw, lsw):
    """The value of two words, or None: |LSW| up to 999, not of opposite signs (A-36)."""
    if abs(lsw) > 999 or msw * lsw < 0:
        return None
    return 1000 * msw + lsw


def target(m):
    """Target position -8,388,608 to 8,388,607, or None."""
    value = pair(m.words[2], m.words[3])
    return value if value is not None and -8_388_608 <= value <= 8_388_607 else None


def speed(m, least):
    """Programmed speed from `least` to 1,000,000, LSW 0 to 999, or None."""
    value = pair(m.words[4], m.words[5])
    return value if value is not None and m.words[5] >= 0 and least <= value <= 1_000_000 else None


def rates_are_legal(m):
    return 1 <= m.words[6] <= 2000 and 1 <= m.words[7] <= 2000


def take_rates(m):
    m.acceleration, m.deceleration = m.words[6], m.words[7]
    m.shape = shape_told(m)


def shape_told(m):
    """The acceleration type of the command LSW [chapter 5]."""
    if not m.o1 & S_CURVE:
        return motion.CONSTANT
    return motion.TRAPEZOIDAL if m.o1 & TRAPEZOIDAL else motion.TRIANGULAR


# ---- the commands


def absolute_or_relative(m, absolute, refused):
    """Absolute & Relative Moves, Encoder Move [chapter 4]; each list by itself (A-110)."""
    by_encoder = bool(m.o1 & ENCODER_MOVE)
    wanted, vs = target(m), speed(m, m.starting_speed)
    refused = is_busy(m) or refused
    if wanted is None or vs is None or not rates_are_legal(m):
        error(m, profile=True)  # CMD-04, CMD-05
        refused = True
    if by_encoder and not m.quadrature:
        error(m, profile=True)  # PRF-11
        refused = True
    if absolute and m.position_invalid:
        error(m)  # CMD-06
        refused = True
    if refused_by_input(m, ESTOP | LIMITS) or refused:
        return
    take_rates(m)
    here = m.encoder(m.start_ns) if by_encoder else m.position
    distance = wanted - here if absolute else wanted
    if by_encoder:
        m.encoder_target = here + distance
    m.hold_target = m.position + distance
    set_out(m, distance, vs, by_encoder)


def refused_by_input(m, inputs):
    """An axis at rest does not start under these inputs (A-16, A-17)."""
    if not m.on(inputs) or m.in_motion():
        return False
    m.input_error = True
    m.resumable = False
    return True


def set_out(m, distance, vs, by_encoder=False):
    """Start toward a distance that may be 0, with the external input on or not."""
    vo = m.starting_speed
    direction = 1 if distance > 0 else -1
    if distance == 0:
        m.start("idle", 1, None)
        m.rest("idle")
        m.move_complete = True
    elif m.on(EXTERNAL):
        one_step = motion.Course(m.start_ns, motion.cruise(1, vo))
        m.start("step to stop" if by_encoder else "step to hold", direction, one_step)
        m.resumable = True
    elif by_encoder:
        m.start("encoder", direction, motion.run(m.start_ns, vo, vs, m.acceleration, m.shape))
    else:
        course = motion.move(m.start_ns, abs(distance), vo, vs, m.acceleration, m.deceleration, m.shape)
        m.start("move", direction, course)


def hold(m):
    """Hold Move [chapter 4]; CMD-07."""
    if m.op == "move":
        m.hold()
    elif m.op in ("stop to hold", "step to hold"):
        pass
    elif m.op == "blend":
        error(m)
        m.hold_error = True  # CMD-19
    elif m.op in ("manual", "registration"):
        error(m)
        m.controlled_stop("manual stop")  # A-26; CMD-21
    else:
        error(m)


def resume(m, refused):
    """Resume Move [chapter 4]; CMD-08. The target words are ignored."""
    vs = speed(m, m.starting_speed)
    if m.op != "held" or not m.resumable:
        error(m)
        refused = True
    if vs is None or not rates_are_legal(m):
        error(m, profile=True)
        refused = True
    if not refused_by_input(m, ESTOP | LIMITS) and not refused:
        take_rates(m)
        set_out(m, m.hold_target - m.position, vs)


def preset(m, bits, refused):
    """Preset Current Position, Preset Encoder Position [chapter 4]; CMD-09, CMD-11."""
    value = target(m)
    m.resumable = False
    if refused:
        return  # every fault of a preset is a command error, which is set
    if value is None or m.o1 or any(m.words[4:]) or m.in_motion():
        error(m)
    elif bits == PRESET_POSITION:
        m.position = value
        m.position_invalid = False
        if m.diagnostic:
            m.set_encoder(value)
    elif m.quadrature:
        m.set_encoder(value)
    else:
        error(m)


def store_minimum(m):
    """Program Minimum Registration Move Distance [chapter 4, Registration Move]; A-93, CMD-20."""
    value = target(m)
    if m.o0 or any(m.words[4:]) or m.in_motion() or value is None or value < 0:
        error(m)
    else:
        m.minimum = value
        m.resumable = False
