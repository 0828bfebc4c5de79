"""The oracle's manual and registration moves [chapter 4, Manual Move and Registration Move]."""

from __future__ import annotations

import oracle_commands as commands
import oracle_motion as motion
from oracle_bits import ESTOP, EXTERNAL, MANUAL_CCW, MANUAL_CW


def begin(m, direction, refused):
    vo = m.starting_speed
    vs = commands.speed(m, 0)
    distance = commands.target(m)
    refused = commands.is_busy(m) or refused
    if is_at_fault(m, vs, distance):
        commands.error(m, profile=True)
        refused = True
    if commands.refused_by_input(m, ESTOP):
        refused = True
    if m.on(m.ahead(direction)):
        m.input_error = True  # INP-03
        m.resumable = False
        refused = True
    if refused:
        return
    commands.take_rates(m)
    registration = distance != 0
    m.manual_bit = MANUAL_CW if direction > 0 else MANUAL_CCW
    m.programmed_speed = vs
    m.seen_target = m.words[2:4]
    m.seen_speed = m.words[4:6]
    m.constant_speed = vs <= vo
    m.registration_steps = distance
    if vs == 0:
        m.start("one shot", direction, None)
        m.make_steps(1)
    elif m.on(EXTERNAL):
        one_step = motion.Course(m.start_ns, motion.cruise(1, min(vs, vo)))
        m.start("step to stop", direction, one_step)
    else:
        course = motion.run(m.start_ns, vo, vs, m.acceleration, m.shape)
        m.start("registration" if registration else "manual", direction, course)


def is_at_fault(m, vs, distance):
    """Whether something is wrong with the words, all of which sets Command Error and Invalid Profile."""
    vo = m.starting_speed
    if vs is None or distance is None:
        return True  # CMD-04
    if vs > vo and not commands.rates_are_legal(m):
        return True  # CMD-04; at or below Vo they are ignored
    if distance == 0:
        return False
    if m.firmware < (3, 1) or distance < 0 or vs == 0 or m.on(EXTERNAL):
        return True  # CMD-12, CMD-24; a registration move has no one-shot; CMD-22
    shape = commands.shape_told(m)
    return vs > vo and distance < motion.ramp_distance(vo, vs, m.words[7], shape) - motion.NUDGE  # CMD-23


def watch(m):
    """The words and the external input, while the move runs; the stop inputs come first."""
    released = not m.o0 & m.manual_bit
    if m.op != "one shot" and m.on(ESTOP | m.ahead(m.direction)):
        if released or m.words[2:6] != m.seen_target + m.seen_speed:
            m.close_call = True  # which of two that come at once counts is open
        return
    if m.op == "one shot":
        if released:
            m.rest("idle")
    elif m.op == "manual":
        watch_manual(m, released)
    else:
        watch_registration(m, released)


def watch_manual(m, released):
    if released or m.on(EXTERNAL):
        if released and m.firmware < (3, 1) and not any(m.words):
            commands.error(m)  # CMD-14
        m.controlled_stop("manual stop")
    elif m.command_error or m.invalid_profile:
        return
    elif m.firmware >= (3, 1) and m.words[2:4] != m.seen_target:
        commands.error(m, profile=True)  # CMD-25
        m.controlled_stop("manual stop")
    elif m.words[4:6] != m.seen_speed:
        change_speed(m)


def watch_registration(m, released):
    barred = m.command_error or m.invalid_profile
    compared = not barred and not m.configuring
    if compared and m.words[2:4] != m.seen_target:
        commands.error(m, profile=True)  # CMD-26
        m.controlled_stop("manual stop")
        return
    if m.op == "registration end":
        return  # speed changes are ignored now
    if (released or m.on(EXTERNAL)) and (m.minimum == 0 or m.travelled > m.minimum):
        if compared and not released and m.words[4:6] != m.seen_speed:
            m.close_call = True  # the input comes with another speed: which of them is seen first is open
        m.op = "registration end"
        m.course = motion.register(
            m.course, m.start_ns, m.registration_steps, m.starting_speed, m.deceleration, m.shape
        )
    elif compared and m.words[4:6] != m.seen_speed:
        change_speed(m)


def change_speed(m):
    """The speed words differ from those in force."""
    vs = commands.speed(m, 1)
    registration = m.op == "registration"
    rates_changed = m.words[6:8] != [m.acceleration, m.deceleration]
    if registration and (rates_changed or (vs is not None and vs > m.programmed_speed)):
        commands.error(m, profile=True)  # CMD-27, CMD-28
        m.controlled_stop("manual stop")
    elif m.constant_speed:
        commands.error(m, profile=True)  # CMD-13
        m.rest("idle")
        m.stopped = True
    elif vs is None or not commands.rates_are_legal(m):
        commands.error(m, profile=True)  # CMD-15
        m.controlled_stop("manual stop")
    else:
        m.programmed_speed = vs
        m.seen_speed = m.words[4:6]
        if not registration:
            commands.take_rates(m)  # with the acceleration type of these words
        m.course = motion.change(m.course, m.start_ns, vs, m.acceleration, m.deceleration, m.shape)
