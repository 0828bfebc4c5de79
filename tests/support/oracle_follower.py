"""The oracle's encoder follower [chapter 4, Encoder Follower Function], rates zero: each count at once."""

from __future__ import annotations

from fractions import Fraction

import oracle_commands as commands
from oracle_bits import ESTOP, FOLLOW, LIMITS, MANUAL_CCW, MANUAL_CW, RESET_ERRORS, S_CURVE

STEPS_PER_TICK = 250
"""Maximum output frequency: 1 MHz [chapter 1, Stepper Outputs]."""


def words_are_legal(m):
    """Multiplier and divisor 1 to 32767, words 4 and 5 zero, rates 0 to 2000, no S-curve."""
    multiplier, divisor, *zero, up, down = m.words[2:]
    return (
        multiplier >= 1
        and divisor >= 1
        and not any(zero)
        and 0 <= up <= 2000
        and 0 <= down <= 2000
        and not m.o1 & S_CURVE
    )


def enter(m):
    """Bit 7 of the command LSW went on."""
    bits = m.o0 & 0x7FFF
    refused = commands.is_busy(m)  # CMD-30
    if not m.quadrature or not words_are_legal(m) or bits not in (0, MANUAL_CW, MANUAL_CCW):
        commands.error(m)  # CMD-29, 31, 32, 34, 36; A-103
        refused = True
    if not commands.refused_by_input(m, ESTOP | LIMITS) and not refused:
        m.start("follower", 1, None)
        m.moving = 0
        m.followed = m.encoder(m.start_ns)
        m.followed_bit = bits
        m.owed = 0


def follow(m):
    """One tick of the mode: is it left, are the words legal, how many steps."""
    bits = m.o0 & 0x7FFF
    if not m.o1 & FOLLOW:
        leave(m)
        if bits not in (0, RESET_ERRORS):
            commands.error(m)  # CMD-35; CMD-34, whatever the LSW says by then
        return
    swapped = bits and m.followed_bit and bits != m.followed_bit
    if bits not in (0, MANUAL_CW, MANUAL_CCW) or swapped or not words_are_legal(m):
        leave(m)
        commands.error(m)  # CMD-31 to 34, 36
        return
    if bits and not m.followed_bit:
        m.followed = m.encoder(m.start_ns)  # what was counted without a direction is not followed
    m.followed_bit = bits


def leave(m):
    m.rest("idle")
    m.stopped = True


def steps(m):
    """Steps of this tick for what is counted by its end: counts times multiplier over divisor.

    The remainder is kept exactly (A-66).
    """
    if any(m.words[6:]):
        m.close_call = True  # ramps are not in here
    count = m.encoder(m.now_ns)
    counted, m.followed = count - m.followed, count
    if not m.followed_bit:
        m.moving = 0
        m.owed = 0
        return
    sense = 1 if m.followed_bit == MANUAL_CW else -1
    multiplier, divisor = m.words[2:4]
    m.owed += Fraction(sense * counted * multiplier, divisor)
    made = min(int(abs(m.owed)), STEPS_PER_TICK) * (1 if m.owed > 0 else -1)
    m.owed -= made
    m.direction = 1 if made > 0 else -1
    m.make_steps(abs(made))
    m.moving = (made > 0) - (made < 0)
