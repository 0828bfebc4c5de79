"""What the oracle's module is wired to: switches along the travel, an encoder, somebody's hand."""

from __future__ import annotations


class World:
    """Switches, encoder, hand on inputs and encoder.

    Args:
        switches: (input mask, first, last) of normally open switches, `None` for an open end.
        counts_per_step: of an encoder on the shaft; 0 = none.
        marker_every: counts between its Z pulses, one of which lies at 0; None = no Z.
        wired_back: the step outputs go to the encoder inputs (diagnostic feedback).
    """

    def __init__(self, switches=(), counts_per_step=0, marker_every=None, wired_back=False):
        self.switches = switches
        self.edges = [end for _, *ends in switches for end in ends if end is not None]
        self.counts_per_step = counts_per_step
        self.marker_every = marker_every
        self.wired_back = wired_back
        self.shaft = 0
        self.shaft_before = 0
        self.hand_levels = 0
        self.turns = []
        self.markers = []

    def levels(self):
        """Mask of energized inputs."""
        mask = self.hand_levels
        for bit, first, last in self.switches:
            if (first is None or self.shaft >= first) and (last is None or self.shaft <= last):
                mask |= bit
        return mask

    def counts(self, now_ns):
        """Encoder counts: by the shaft and by hand (a turn's counts are spread evenly, toward zero)."""
        total = self.shaft * self.counts_per_step
        for counts, start, end in self.turns:
            if now_ns >= end:
                total += counts
            elif now_ns > start:
                made = abs(counts) * (now_ns - start) // (end - start)
                total += made if counts > 0 else -made
        return total

    def marker_between(self, before_ns, now_ns):
        """Whether a Z pulse came after `before_ns`, up to and including `now_ns`, by hand or by the shaft."""
        return any(before_ns < at <= now_ns for at in self.markers) or self.shaft_passed_marker()

    def shaft_passed_marker(self):
        """Whether the shaft came to a Z line, or over it, since `shaft_before`."""
        if not self.marker_every or not self.counts_per_step:
            return False
        before, now = self.shaft_before * self.counts_per_step, self.shaft * self.counts_per_step
        step = 1 if now > before else -1
        return any(count % self.marker_every == 0 for count in range(before + step, now + step, step))
