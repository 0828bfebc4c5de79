"""The machine that a module drives.

The machine's position may differ from the module's count: the module reports its motor steps, and the machine
decides how far the shaft follows and which inputs are energized. The module queries the next event
(`steps_to_…`, `next_change_ns`) and advances from event to event, without a loop over steps or ticks. All
results are closed forms in integers, and do not depend on the number of queries.
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
    """A machine; a new machine is at rest with its shaft at 0.

    `now_ns` never decreases between calls.

    Attributes:
        before_change: called before a manual change of an input or the encoder.
    """

    __slots__ = (
        "_encoder",
        "_first",
        "_hand_turning",
        "_last",
        "_levels",
        "_moving",
        "_shaft",
        "_stimuli",
        "_switches",
        "_unsettable",
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
        self._hand_turning = HandTurning()
        for hand_turn in spec.turns:
            self._hand_turning.turn(hand_turn.counts, hand_turn.at_ns, hand_turn.end_ns)
        self._unsettable = spec.fed_inputs  # mask of inputs that `set_input` refuses
        for entry in spec.timeline:
            self._unsettable |= entry.input.value
        self._moving = False
        self._stimuli.rest(0, 0)
        self._refresh()

    @property
    def shaft(self) -> int:
        """True position, steps; 0 at power-up of the rack. The module never resets it."""
        return self._shaft.position

    @property
    def events(self) -> list[Event]:
        """Past timeline actions and station pulses, in chronological order; the module empties the list."""
        return self._stimuli.events

    # --- motion

    def depart(self, now_ns: int) -> None:
        """Start a motion and stop the work of stations; `follow` calls this method if needed."""
        self._moving = True
        self._stimuli.depart(now_ns)
        self._forget_levels()

    def follow(self, direction: int, steps: int, now_ns: int) -> None:
        """Follow the motor steps made in a direction up to and including `now_ns`."""
        if steps:
            if not self._moving:
                self.depart(now_ns)
            self._shaft.follow(direction, steps)

    def rest(self, now_ns: int) -> None:
        """End a motion; a station at the shaft's position begins its work."""
        if self._moving:
            self._moving = False
            self._stimuli.rest(now_ns, self._shaft.position)
            self._forget_levels()

    def steps_to_shaft(self, direction: int, target: int) -> int | None:
        """Return the motor steps in `direction` to `target`, or None if the shaft can't reach it that way."""
        return self._shaft.steps_to(direction, target)

    def free_steps(self, direction: int) -> int:
        """Return the motor steps in `direction` that the shaft follows one to one; 0 at a slip or jam."""
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
        """Mask of the energized inputs, as of the last call to `levels`."""
        return self._levels

    @property
    def held(self) -> int:
        """Mask of the inputs that the timeline or bench holds, as of the last call to `levels`."""
        return self._stimuli.held_mask

    def rewire(self, bit: InputBit, switches: Sequence[Switch]) -> None:
        """Replace an input's switches, and release the input; an input without switches is de-energized."""
        self.before_change()
        other_switches = [switch for switch in self.spec.switches if switch.input is not bit]
        self.spec = replace(self.spec, switches=(*other_switches, *switches))
        self._switches = SwitchTable(self.spec.switches)
        self._unsettable = self._unsettable & ~bit.value | (bit.value if switches else 0)
        self._stimuli.hold(bit, None)
        self._forget_levels()

    def _refresh(self) -> None:
        """Compute the levels, and the range of shaft positions in which they apply."""
        stimuli = self._stimuli
        self._first, self._last, mask = self._switches.row(self._shaft.position)
        self._levels = (mask | stimuli.pulses) & ~stimuli.held_mask | stimuli.held

    def _forget_levels(self) -> None:
        """Invalidate the levels by setting an empty range of positions."""
        self._first, self._last = FAR, -FAR

    def steps_to_switch(self, direction: int) -> int | None:
        """Return the motor steps, 1 or more, until a switch next changes its input, or None.

        If the timeline is holding the input, the input does not show the change.
        """
        first_step, last_step, _ = self._switches.row(self._shaft.position)
        target = last_step + 1 if direction > 0 else first_step - 1
        return self._shaft.steps_to(direction, target) if -FAR <= target <= FAR else None

    @property
    def acts_next_ns(self) -> int:
        """The computed instant of the next timeline or station action, or FAR."""
        return self._stimuli.next_ns

    def next_change_ns(self, now_ns: int) -> int | None:
        """Return the instant of the next timeline or station action after `now_ns`, or None."""
        if now_ns >= self._stimuli.next_ns:
            self._stimuli.advance(now_ns)
            self._forget_levels()
        return self._stimuli.next_ns if self._stimuli.next_ns < FAR else None

    def set_input(self, bit: InputBit, energized: bool) -> None:
        """Set an input from the bench and hold it.

        Raises:
            ValueError: a switch, a station or the timeline feeds that input.
        """
        if self._unsettable & bit.value:
            raise ValueError(f"set_input: {bit.name} is wired to the machine; choose an unwired input")
        self.before_change()
        self._stimuli.hold(bit, energized)
        self._forget_levels()

    def operate(self, bit: InputBit, energized: bool | None, now_ns: int) -> None:
        """Act on an input as a timeline entry does, and report an event.

        Args:
            energized: a level that overrides switches and stations, or None to release the input.
        """
        self.before_change()
        self._stimuli.operate(bit, energized, now_ns)
        self._forget_levels()

    # --- encoder

    def mount(self, encoder: EncoderSpec) -> None:
        """Mount a motor's encoder on the shaft of a machine that has no encoder."""
        self._encoder = ShaftEncoder(encoder)

    def encoder_counts(self, now_ns: int) -> int:
        """Return the x4 counts since power-up, from the shaft and from turns by hand combined."""
        return self._encoder.counts(self._shaft.position) + self._hand_turning.counts(now_ns)

    def encoder_counts_all(self, shafts: NDArray[np.int64], now_ns: int) -> NDArray[np.int64]:
        """Return the x4 counts at many shaft positions, including turns by hand up to `now_ns`."""
        return self._encoder.counts_all(shafts) + self._hand_turning.counts(now_ns)

    def steps_to_counts(self, direction: int, counts: int, now_ns: int) -> int | None:
        """Return the motor steps in `direction` until the encoder reaches or passes `counts`, or None.

        The encoder has passed `counts` when it reads `counts` or more for direction +1, or `counts` or less
        for -1. Turns by hand after `now_ns` are ignored.
        """
        shaft_counts = counts - self._hand_turning.counts(now_ns)
        if (self._encoder.counts(self._shaft.position) - shaft_counts) * direction >= 0:
            return 0
        if self._encoder.direction <= 0:
            return None
        return self._shaft.steps_to(direction, self._encoder.shaft_reaching(direction, shaft_counts))

    def steps_to_marker(self, direction: int) -> int | None:
        """Return the motor steps, 1 or more, until the shaft's next Z pulse, or None."""
        marker = self._encoder.next_marker(direction, self._shaft.position)
        if marker is None:
            return None
        return self._shaft.steps_to(direction, self._encoder.shaft_reaching(direction, marker))

    def turn_encoder(self, counts: int, start_ns: int, end_ns: int) -> None:
        """Turn the encoder by hand at a constant speed; the last count is at `end_ns`.

        Args:
            counts: x4 counts, with sign.

        Raises:
            ValueError: the turn ends before it starts, or starts before the previous turn ends.
        """
        self.before_change()
        self._hand_turning.turn(counts, start_ns, end_ns)

    def turning(self, now_ns: int) -> bool:
        """Return whether a turn by hand is in progress or planned."""
        return self._hand_turning.turning(now_ns)

    def turns_ns(self, now_ns: int) -> int | None:
        """Return `now_ns` during a turn by hand, otherwise the start of the next turn, or None."""
        return self._hand_turning.turns_ns(now_ns)

    def marker_at(self, at_ns: int) -> None:
        """Plan a Z pulse from the bench at `at_ns`."""
        self.before_change()
        self._hand_turning.mark(at_ns)

    def next_marker_ns(self, now_ns: int) -> int | None:
        """Return the instant of the bench's next Z pulse after `now_ns`, or None."""
        return self._hand_turning.next_marker_ns(now_ns)

    def let_go(self, now_ns: int) -> None:
        """Cancel turns by hand and the bench's Z pulses after `now_ns`."""
        self.before_change()
        self._hand_turning.let_go(now_ns)
