"""How long nothing happens to the oracle but that its motion goes on.

Under words and inputs that have been seen, most ticks change a position and nothing else. Then
nobody has to go through them one by one: time may pass, and the last of these ticks tells where the
axis is. Whoever does so has to give no new word, input or mode in between.

It is calm as long as

* the motion stays on one piece of its course, and
* no switch is near its way, and
* what the motion waits for (an encoder count, a Z pulse, a minimum distance) cannot come.

Where that is laborious to tell, it is not calm.
"""

from __future__ import annotations

from oracle_bits import EXTERNAL

TICK_NS = 250_000

FOREVER = 1_000_000_000
"""Ticks, three days of them."""

LEAPS = (64, 16, 4)
"""Ticks that are tried, the most first: 16 ms at the utmost without a look at a moving axis."""

MARGIN = 3
"""Steps by which the module under test may be ahead or behind."""


def calm_ticks(m):
    """Ticks, none of which does more than move the axis on, 0 where each counts."""
    if m.configuring and not m.mode_config:
        return 0  # the mode begins with the first tick that finds the axis at rest
    if m.op in ("idle", "held", "one shot"):
        return FOREVER
    if m.phase == "dwell":
        return (m.dwell_until - m.now_ns) // TICK_NS - 1
    return next((ticks for ticks in LEAPS if goes_on(m, ticks * TICK_NS)), 0)


def goes_on(m, ns):
    """Whether the motion just goes on for so long."""
    if m.op == "follower":
        return stands_still(m)
    if m.course is None or waits(m):
        return False
    return m.course.is_on_one_piece(m.now_ns, m.now_ns + ns) and way_is_free(m, ns)


def stands_still(m):
    """A follower whose encoder rests, with no step left to make."""
    return not turning(m) and m.followed == m.encoder(m.now_ns) and abs(m.owed) < 1


def waits(m):
    """Whether the motion waits for something that may come in any tick."""
    if m.op == "encoder":
        return turning(m) or m.world.counts_per_step > 0 or m.diagnostic
    if m.op == "homing":
        return "marker" in m.homing_kind and m.phase in ("near", "creep")
    return m.op in ("move", "registration") and (m.on(EXTERNAL) or not m.o0)


def turning(m):
    """Whether somebody's hand is on the encoder, or was so after it had been looked at."""
    return any(end > m.start_ns for _, _, end in m.world.turns)


def way_is_free(m, ns):
    """Whether no switch changes on the way of so long a time, nor has done so since it was looked at."""
    seen_at = m.world.shaft_before
    there = m.world.shaft + m.direction * (m.course.at(m.now_ns + ns)[0] - m.travelled)
    first, last = min(seen_at, there) - MARGIN, max(seen_at, there) + MARGIN
    return not any(first <= edge <= last for edge in m.world.edges)
