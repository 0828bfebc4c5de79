"""The oracle's homing [chapter 4, Find Home; readings A-72 to A-77, A-99, A-100].

`m.phase` is one of

    seek            at the programmed speed, in the commanded direction
    seek stop       home switch only: decelerating, the switch has come on
    near            the proximity has been seen: ramp to the starting speed, then on at it
    dwell           two seconds on an end limit
    back            the other way at the programmed speed, until the signal has been on and is off
    back stop       decelerating after that
    creep           in the commanded direction at the starting speed
    back next, creep next
                    the ramp is over, the next tick turns round

The signal is the home switch or the backplane proximity bit, whichever tells that home is near.
"""

from __future__ import annotations

import oracle_commands as commands
import oracle_motion as motion
from oracle_bits import CCW_LIMIT, CW_LIMIT, ESTOP, HOME, PROXIMITY, S_CURVE

DWELL_NS = 2_000_000_000


def find_home(m, direction, refused):
    vs, told = commands.speed(m, 1), commands.pair(m.words[4], m.words[5])
    too_slow = told is not None and told < m.starting_speed  # 0 and negative speeds, too
    limit, opposite = (CW_LIMIT, CCW_LIMIT) if direction > 0 else (CCW_LIMIT, CW_LIMIT)
    refused = commands.is_busy(m) or refused
    if vs is None or not commands.rates_are_legal(m) or commands.target(m) is None:
        commands.error(m, profile=True)  # CMD-04
        refused = True
    if too_slow:
        commands.error(m, profile=True)  # CMD-05
    if m.o1 & S_CURVE:
        commands.error(m)  # CMD-10
        refused = True
    if too_slow or m.words[2] or m.words[3] or not m.used & limit:
        commands.error(m)
        m.home_invalid = True  # HOM-01, HOM-02, HOM-03
        refused = True
    if commands.refused_by_input(m, ESTOP) or refused:
        return
    commands.take_rates(m)
    m.home_invalid = False
    m.home_began_ns = m.start_ns
    m.home_direction = direction
    m.home_speed = vs
    m.home_signal = m.home_signal_before = signal(m)
    m.limit_met = False
    m.start("homing", direction, None)
    if m.on(limit):
        dwell(m)
    elif m.home_signal or (m.homing_kind == "switch after proximity bit" and m.on(HOME)):
        if m.on(opposite):
            fail(m)
        else:
            back(m)
    else:
        m.phase = "seek"
        at_speed(m, direction)


def signal(m):
    if "proximity bit" in m.homing_kind:
        return bool(m.o1 & PROXIMITY)
    return m.on(HOME)


def at_speed(m, direction):
    course = motion.run(m.start_ns, m.starting_speed, m.home_speed, m.acceleration, motion.CONSTANT)
    m.go(course, direction)


def back(m):
    m.phase = "back"
    m.signal_was_on = False  # a stop may have gone past a narrow switch
    at_speed(m, -m.home_direction)


def creep(m):
    m.phase = "creep"
    m.near = False
    m.go(motion.Course(m.start_ns, motion.cruise(motion.inf, m.starting_speed)), m.home_direction)


def dwell(m):
    """Stop outputting steps, wait for two seconds, reverse direction [chapter 4]."""
    m.phase = "dwell"
    m.limit_met = True
    m.dwell_until = m.start_ns + DWELL_NS
    m.course = None
    m.moving = m.ramp = 0


def phase_over(m):
    """A ramp has ended within this tick; the next phase begins with the next tick."""
    m.phase = "back next" if m.phase == "seek stop" else "creep next"
    m.course = None


def begin_next_phase(m):
    if m.phase == "back next" or (m.phase == "dwell" and m.start_ns >= m.dwell_until):
        back(m)
    elif m.phase == "creep next":
        creep(m)


def watch(m):
    if m.on(ESTOP):
        return
    m.home_signal_before = m.home_signal
    m.home_signal = signal(m)
    came_on = m.home_signal and not m.home_signal_before
    came_on = came_on and m.phase != "creep next"  # the stop before made that edge, not the creeping
    kind = m.homing_kind
    begin_next_phase(m)
    if m.phase == "seek":
        if came_on and kind == "switch":
            m.phase = "seek stop"
            m.controlled_stop("homing")
        elif came_on:
            m.phase = "near"
            if m.course.at(m.start_ns)[1] > m.starting_speed:
                m.course = motion.change(
                    m.course, m.start_ns, m.starting_speed, m.acceleration, m.deceleration, motion.CONSTANT
                )
    elif m.phase == "near":
        if home_found(m):
            done(m)
    elif m.phase == "back":
        if m.home_signal:
            m.signal_was_on = True
        elif m.signal_was_on:
            m.phase = "back stop"
            m.controlled_stop("homing")
    elif m.phase == "creep":
        if kind == "switch":
            if came_on:
                done(m)
        elif m.near:
            if home_found(m):
                done(m)
        else:
            m.near = m.home_signal


def home_found(m):
    if "marker" in m.homing_kind:
        return m.world.marker_between(m.start_ns - 250_000, m.start_ns)
    return m.became(HOME)


def done(m):
    """At Home, and position, encoder and captured value are zero, in the same image (A-77)."""
    m.close_call = m.became(CW_LIMIT | CCW_LIMIT)  # which of two that come at once counts is open
    m.rest("idle")
    m.at_home = True
    m.position = 0
    m.position_invalid = False
    m.captured = 0
    m.set_encoder(0)


def obey_limits(m):
    """Reaching an End Limit Switch During a Homing Operation [chapter 4]."""
    same, opposite = (CW_LIMIT, CCW_LIMIT) if m.home_direction > 0 else (CCW_LIMIT, CW_LIMIT)
    if m.home_began_ns == m.start_ns:
        return  # what has changed before the start counts as it is at the start
    if m.phase == "dwell":
        return  # what is active by then is looked at when the axis turns round
    if m.phase in ("back", "back stop", "creep next"):
        if m.became(opposite) or (m.limit_met and m.on(opposite)):
            fail(m)  # HOM-04, HOM-05
        return
    if m.on(same):
        if m.limit_met:
            fail(m)  # HOM-04
        else:
            dwell(m)
    elif m.became(opposite):
        fail(m)  # HOM-05


def fail(m):
    """Home Invalid, Input Error, Position Invalid; not Stopped, which excludes homing."""
    m.rest("idle")
    m.home_invalid = m.input_error = m.position_invalid = True
