"""The machine that a module drives.

Its true position is not the module's count: the module reports its motor steps,
and the machine decides how far the shaft follows, and which inputs switches,
stations and people energize. The module queries ahead (`steps_to_…`,
`next_change_ns`), and goes from one event to the next without a loop over steps
or ticks. Everything is a closed form in integers and does not depend on the
number of queries.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from scanrack.io_images.amci3601.bits import InputBit

from ..loop.events import Event
from ..loop.module import unnoticed
from .encoder import HandTurning, ShaftEncoder
from .shaft import FAR, Shaft
from .spec import EncoderSpec, MachineSpec, Switch
from .stimuli import Stimuli
from .switches import SwitchTable

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

NOTHING_WIRED = MachineSpec()


class Machine:
    """A machine at rest at t = 0 with its shaft at 0.

    `now_ns` never decreases between calls of any methods.

    Attributes:
        before_change: called before a manual change of an input or encoder.
    """

    __slots__ = (
        "_encoder",
        "_first",
        "_hand",
        "_last",
        "_levels",
        "_moving",
        "_refused",
        "_shaft",
        "_stimuli",
        "_switches",
        "before_change",
        "spec",
    )

    def __init__(self, spec: MachineSpec = NOTHING_WIRED, seed: int = 0) -> None:
        self.spec = spec
        self.before_change: Callable[[], None] = unnoticed
        self._shaft = Shaft(spec.slips, spec.jams, seed)
        self._switches = SwitchTable(spec.switches)
        self._stimuli = Stimuli(spec)
        self._encoder = ShaftEncoder(spec.encoder)
        self._hand = HandTurning()
        for hand_turn in spec.turns:
            self._hand.turn(hand_turn.counts, hand_turn.at_ns, hand_turn.end_ns)
        self._refused = spec.fed_inputs
        for entry in spec.timeline:
            self._refused |= entry.input.value
        self._moving = False
        self._stimuli.rest(0, 0)
        self._refresh()

    @property
    def shaft(self) -> int:
        """True position, steps; 0 at power-up of the rack, never reset by the module."""
        return self._shaft.position

    @property
    def events(self) -> list[Event]:
        """Timeline actions and station pulses that have passed, in order of time; the module empties it."""
        return self._stimuli.events

    # --- motion

    def depart(self, now_ns: int) -> None:
        """Note the start of a motion: stations stop their work. `follow` implies it."""
        self._moving = True
        self._stimuli.depart(now_ns)
        self._forget_levels()

    def follow(self, direction: int, steps: int, now_ns: int) -> None:
        """Follow motor steps in a direction, all of them up to and including `now_ns`."""
        if steps:
            if not self._moving:
                self.depart(now_ns)
            self._shaft.follow(direction, steps)

    def rest(self, now_ns: int) -> None:
        """Note the end of a motion: a station at the shaft's position begins its work."""
        if self._moving:
            self._moving = False
            self._stimuli.rest(now_ns, self._shaft.position)
            self._forget_levels()

    def steps_to_shaft(self, direction: int, target: int) -> int | None:
        """Return the motor steps in `direction` to `target`; None = other direction, or beyond a jam."""
        return self._shaft.steps_to(direction, target)

    def free_steps(self, direction: int) -> int:
        """Return the motor steps in `direction` that the shaft follows one to one, 0 at a slip or jam."""
        return self._shaft.free_steps(direction)

    # --- inputs

    def levels(self, now_ns: int) -> int:
        """Return the mask of energized inputs (InputBit values) at `now_ns`."""
        if now_ns >= self._stimuli.next_ns:
            self._stimuli.advance(now_ns)
            self._refresh()
        elif not self._first <= self._shaft.position <= self._last:
            self._refresh()
        return self._levels

    @property
    def shown(self) -> int:
        """Mask of the energized inputs as of the last query of `levels`."""
        return self._levels

    @property
    def held(self) -> int:
        """Mask of the inputs held by timeline or bench, as of the last query of `levels`."""
        return self._stimuli.held_mask

    def rewire(self, bit: InputBit, switches: Sequence[Switch]) -> None:
        """Wire an input to other switches now, and release it; without switches it is de-energized."""
        self.before_change()
        kept_switches = [switch for switch in self.spec.switches if switch.input is not bit]
        self.spec = replace(self.spec, switches=(*kept_switches, *switches))
        self._switches = SwitchTable(self.spec.switches)
        self._refused = self._refused & ~bit.value | (bit.value if switches else 0)
        self._stimuli.hold(bit, None)
        self._forget_levels()

    def _refresh(self) -> None:
        """Compute the levels, and the shaft positions between which they apply."""
        stimuli = self._stimuli
        self._first, self._last, mask = self._switches.row(self._shaft.position)
        self._levels = (mask | stimuli.pulses) & ~stimuli.held_mask | stimuli.held

    def _forget_levels(self) -> None:
        """Invalidate the computed levels: no position is between these two."""
        self._first, self._last = FAR, -FAR

    def steps_to_switch(self, direction: int) -> int | None:
        """Return the motor steps, 1 or more, until a switch next changes its input; None = never.

        The timeline may hold that input, which then does not show the change.
        """
        first_step, last_step, _ = self._switches.row(self._shaft.position)
        target = last_step + 1 if direction > 0 else first_step - 1
        return self._shaft.steps_to(direction, target) if -FAR <= target <= FAR else None

    @property
    def acts_next_ns(self) -> int:
        """The next instant at which timeline or stations act, as far as computed; FAR = never."""
        return self._stimuli.next_ns

    def next_change_ns(self, now_ns: int) -> int | None:
        """Return the next instant after `now_ns` at which timeline or stations act; None = never."""
        if now_ns >= self._stimuli.next_ns:
            self._stimuli.advance(now_ns)
            self._forget_levels()
        return self._stimuli.next_ns if self._stimuli.next_ns < FAR else None

    def set_input(self, bit: InputBit, energized: bool) -> None:
        """Set an input from the bench and hold it.

        Raises:
            ValueError: a switch, a station or the timeline feeds that input.
        """
        if self._refused & bit.value:
            raise ValueError(
                f"set_input: {bit.name} is wired to the machine; allowed: inputs that it leaves free"
            )
        self.before_change()
        self._stimuli.hold(bit, energized)
        self._forget_levels()

    def operate(self, bit: InputBit, energized: bool | None, now_ns: int) -> None:
        """Act on an input now as an entry of the timeline does, and record it as an event.

        Args:
            energized: its level, which overrides switches and stations; None = released.
        """
        self.before_change()
        self._stimuli.operate(bit, energized, now_ns)
        self._forget_levels()

    # --- encoder

    def mount(self, encoder: EncoderSpec) -> None:
        """Mount an encoder on the shaft of a machine without one, for a motor with its own encoder."""
        self._encoder = ShaftEncoder(encoder)

    def encoder_counts(self, now_ns: int) -> int:
        """Return the x4 counts since power-up, from the shaft and from turning by hand."""
        return self._encoder.counts(self._shaft.position) + self._hand.counts(now_ns)

    def encoder_counts_all(self, shafts: NDArray[np.int64], now_ns: int) -> NDArray[np.int64]:
        """Return the x4 counts with the shaft at many positions, without hand turning after `now_ns`."""
        return self._encoder.counts_all(shafts) + self._hand.counts(now_ns)

    def steps_to_counts(self, direction: int, counts: int, now_ns: int) -> int | None:
        """Return the motor steps in `direction` until the encoder reaches or passes `counts`; None = never.

        "Past" is in the motor's direction: `counts` or more for +1, `counts` or less for -1. Hand
        turning after `now_ns` is ignored.
        """
        reached = counts - self._hand.counts(now_ns)
        if (self._encoder.counts(self._shaft.position) - reached) * direction >= 0:
            return 0
        if self._encoder.direction <= 0:
            return None
        return self._shaft.steps_to(direction, self._encoder.shaft_reaching(direction, reached))

    def steps_to_marker(self, direction: int) -> int | None:
        """Return the motor steps, 1 or more, until the next Z pulse of the shaft; None = never."""
        marker = self._encoder.next_marker(direction, self._shaft.position)
        if marker is None:
            return None
        return self._shaft.steps_to(direction, self._encoder.shaft_reaching(direction, marker))

    def turn_encoder(self, counts: int, start_ns: int, end_ns: int) -> None:
        """Turn the encoder by hand: `counts` (x4, signed) spread evenly, the last one at `end_ns`.

        Raises:
            ValueError: it ends before it starts, or starts before the previous turn ends.
        """
        self.before_change()
        self._hand.turn(counts, start_ns, end_ns)

    def turning(self, now_ns: int) -> bool:
        """Return whether turning by hand is planned after `now_ns`."""
        return self._hand.turning(now_ns)

    def turns_ns(self, now_ns: int) -> int | None:
        """Return the first instant from `now_ns` at which the encoder is turned by hand; None = never."""
        return self._hand.turns_ns(now_ns)

    def marker_at(self, at_ns: int) -> None:
        """Give a Z pulse from the bench at `at_ns`."""
        self.before_change()
        self._hand.mark(at_ns)

    def next_marker_ns(self, now_ns: int) -> int | None:
        """Return the instant of the bench's next Z pulse after `now_ns`; None without one."""
        return self._hand.next_marker_ns(now_ns)

    def let_go(self, now_ns: int) -> None:
        """Cancel the counts and Z pulses planned for later than `now_ns`."""
        self.before_change()
        self._hand.let_go(now_ns)
