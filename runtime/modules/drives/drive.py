"""A simulated networked drive: its time, its inputs, and its images of ten words in each direction.

It has no clock and no port. In a slot, the scan loop calls `update`; a server or an adapter calls `advance`
and `obey`. New words act when they arrive. The drive samples its inputs every 250 us (interpretation R-41),
and the end of a motion is exact. Between these instants, only the position changes, and a formula computes
it, so the image does not depend on the number of calls.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.drives.bits import StatusBit
from scanrack.io_images.drives.models import WORDS, Model
from scanrack.io_images.image import Image, signed_word
from scanrack.io_images.number_formats import NumberFormat
from typing_extensions import override

from ...kinematics import Segment
from ...loop.events import Event, JsonValue
from ...loop.module import unnoticed
from ...machine import Machine
from ..amci3601.step_generator import NEVER, StepGenerator, SteppedModule
from .drive_options import options_of
from .layer import DriveLayer
from .nonvolatile import DriveMemory

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

NS_PER_MS = 1_000_000
HOT_C = 90
"""Temperature in degC above which TEMPERATURE_90C is on [17 p. 84]."""

HEARTBEAT, PLC_IN_PROGRAM_MODE = StatusBit.HEARTBEAT.value, StatusBit.PLC_IN_PROGRAM_MODE.value

NO_WORDS = (0,) * WORDS


class DriveUnit(SteppedModule):
    """A simulated unit of the family with its machine; satisfies `runtime.loop.module.Module`.

    Attributes:
        events: events in order of time; the caller empties the list.
        before_change: function called before any access to the unit or its machine other than `update`.
        words: the ten output words in force, unsigned.
        terminals: the machine's inputs that are wired to the drive's inputs, in order.

    Args:
        machine: by default a machine without switches.
        options: options of the model by name; see `SmdOptions`.
        memory: the flash; by default empty, or with the configuration of option `stored`.

    Raises:
        ValueError: an unknown option, or a stored configuration that the model does not accept.
    """

    def __init__(
        self,
        model: Model,
        machine: Machine | None = None,
        options: Mapping[str, JsonValue] | None = None,
        memory: DriveMemory | None = None,
    ) -> None:
        self.model = model
        self.machine = Machine() if machine is None else machine
        self.options = options_of(model).of(options)
        stored_words = self.options.stored_in(model)
        self.terminals = self.options.terminals(model)
        self.events: list[Event] = []
        self.before_change: Callable[[], None] = unnoticed
        self.machine.before_change = self.look_again
        self._tick_ns = 1000 * self.options.input_scan_us
        self._now_ns = 0
        self._running = self._cable = True  # PLC in run mode, network cable connected
        self._due_ns = 0  # until this instant only position and encoder change
        self._hot = False  # too hot to work
        self._condition_bits = StatusBit(0)  # temperature and encoder error
        self._image = Image(size=WORDS)
        self._power_up(DriveMemory(configuration=stored_words) if memory is None else memory)

    def _power_up(self, memory: DriveMemory) -> None:
        """Make a new axis and command layer with the content of the flash; shaft and clock continue."""
        self.axis = StepGenerator(self.machine)
        self.axis.advance(self._now_ns)
        self.layer = DriveLayer(self.axis, self.model, self.options, memory, self.events, self._now_ns)
        self.words = NO_WORDS
        self._acted_on = b""
        self._counting = False
        self._segment: Segment | None = None
        self._due_ns = 0
        self._tick(self._now_ns)

    @property
    def memory(self) -> DriveMemory:
        """The content of the flash."""
        return self.layer.memory

    @property
    def number_format(self) -> NumberFormat:
        """The format of the numbers that the PLC reads."""
        return self.layer.input_format

    @property
    def now_ns(self) -> int:
        """The instant to which the unit has been advanced."""
        return self._now_ns

    # -- the contract of a slot -----------------------------------------------------------------

    def update(self, now_ns: int, outputs: Image) -> Image:
        """Advance to `now_ns` with `outputs` in force since the last call, and return the input image."""
        raw = outputs.raw.tobytes()
        if now_ns >= self._due_ns or raw != self._acted_on:
            self.obey(outputs)
            self._acted_on = raw
            self.advance(now_ns)
            words = self._image.words
            for index, word in enumerate(self.inputs()):
                words[index] = signed_word(word)
            self._foresee(now_ns)
        elif self._counting:
            self._report_counts(now_ns)
        elif self._segment is not None:
            self._report_travel(now_ns, self._segment)
        self._now_ns = now_ns
        return self._image

    def _foresee(self, now_ns: int) -> None:
        """Compute the next instant at which anything other than the position and the encoder can change."""
        beat_ns = NS_PER_MS * self.options.beat_ms
        due_ns = min(self.axis.next_change_ns(), self._tick_due_ns, self._stall_due_ns)
        self._due_ns = min(due_ns, (now_ns // beat_ns + 1) * beat_ns)
        is_shown = not self.layer.in_configuration
        self._counting = is_shown and self.axis.counting
        self._segment = self.axis.segment if is_shown else None

    def _report_travel(self, now_ns: int, segment: Segment) -> None:
        """Update the position in the input image; nothing else can have changed."""
        words, motion = self._image.words, self.axis.motion
        assert motion is not None
        position = motion.origin + motion.direction * segment.steps_at(now_ns)
        words[2], words[3] = self.layer.input_format.split(position)

    def _report_counts(self, now_ns: int) -> None:
        """Update the position and the encoder in the input image; nothing else can have changed."""
        self.axis.advance(now_ns)
        words, split_number = self._image.words, self.layer.input_format.split
        words[2], words[3] = split_number(self.axis.position)
        words[4], words[5] = split_number(self.axis.encoder)

    @override
    def _split_all(self, values: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        return self.layer.input_format.split_all(values)

    def plc_run(self, running: bool) -> None:
        """Set whether the PLC is in run mode; program mode drops the connection [interpretation R-22]."""
        if running != self._running:
            self._touch()
            self._running = running
            if running:
                self.layer.regain_connection(self._now_ns)
            else:
                self.lose_connection()
            self.look_again()

    def power_cycle(self) -> None:
        """Cycle the power at the last `now_ns`; the flash and the shaft keep their state."""
        self._touch()
        self.axis.cut(self._now_ns)
        self._power_up(self.memory)

    # -- a server or an adapter -----------------------------------------------------------------

    def obey(self, words: Sequence[int] | Image) -> None:
        """Obey ten output words, signed or unsigned, at the instant of the last call."""
        new_words = tuple(word & 0xFFFF for word in words)
        if self._running and new_words != self.words:
            self._touch()
            self.words = new_words
            self._tick(self._now_ns)

    def advance(self, now_ns: int) -> None:
        """Advance to `now_ns`, which never decreases."""
        while True:
            due_ns = min(self.axis.next_change_ns(), self._tick_due_ns, self._stall_due_ns)
            if due_ns > now_ns:
                break
            self._process(due_ns)
        self.axis.advance(now_ns)
        self._now_ns = now_ns

    def inputs(self) -> tuple[int, ...]:
        """Return the ten input words, signed or unsigned, at the instant of the last call."""
        condition_bits = int(self._condition_bits)
        if self._now_ns // (NS_PER_MS * self.options.beat_ms) & 1:
            condition_bits |= HEARTBEAT
        if not self._running:
            condition_bits |= PLC_IN_PROGRAM_MODE
        return self.layer.report(condition_bits)

    # -- the machine, the driver, the link -------------------------------------------------------

    def operate(self, bit: InputBit, energized: bool | None) -> None:
        """Operate an input of the machine; see `Machine.operate`."""
        self.machine.operate(bit, energized, self._now_ns)
        self.look_again()

    def look_again(self) -> None:
        """Sample the inputs at the next tick, after an external change."""
        self._touch()
        self._tick_due_ns = self._tick_at_or_after(self._now_ns)

    def set_temperature(self, celsius: float) -> None:
        """Set the temperature of the driver."""
        self._set_condition(StatusBit.TEMPERATURE_90C, on=celsius > HOT_C)

    def set_driver_fault(self, faulty: bool) -> None:
        """Begin or end a driver fault, caused by overheating."""
        self._touch()
        self._hot = faulty
        self.layer.overheat(self._now_ns, faulty)
        self.look_again()

    def set_encoder_error(self, faulty: bool) -> None:
        """Set or clear the error of the multi-turn encoder."""
        self._set_condition(StatusBit.ENCODER_ERROR, on=faulty)

    def set_cable(self, connected: bool) -> None:
        """Connect or disconnect the network cable [17 p. 82, p. 84; interpretation R-22]."""
        if connected != self._cable:
            self._touch()
            self._cable = connected
            self.layer.fire(self._now_ns, "INP-05" if connected else "POS-05")

    def lose_connection(self) -> None:
        """Time out the controlling connection [interpretation R-22]."""
        self._touch()
        self.layer.lose_connection(self._now_ns)
        self._plan(self._now_ns)

    def stall(self) -> None:
        """Stall the motor; with stall detection, this stops a motion."""
        configuration = self.layer.state.configuration
        if configuration is not None and configuration.stall_detection:
            self._touch()
            self.layer.stall(self._now_ns)
            self._plan(self._now_ns)

    def _touch(self) -> None:
        """Prepare for an external change at the time of the last call: advance the axis, drop predictions."""
        self.before_change()
        self.axis.advance(self._now_ns)
        self._due_ns = 0

    def _set_condition(self, bit: StatusBit, *, on: bool) -> None:
        self._touch()
        self._condition_bits = self._condition_bits | bit if on else self._condition_bits & ~bit

    # -- time ---------------------------------------------------------------------------------

    def _process(self, due_ns: int) -> None:
        """Process the end of a motion, a check for a stall, or a tick."""
        has_ended = self.axis.advance(due_ns)
        if due_ns == self._stall_due_ns and self._lag_steps() >= self._stall_steps():
            self.layer.stall(due_ns)
        if has_ended:
            self.layer.settle(due_ns)
        if has_ended or due_ns >= self._tick_due_ns:
            self._tick(due_ns)
        else:
            self._plan(due_ns)

    def _tick(self, at_ns: int) -> None:
        self.layer.tick(at_ns, self.words, self._levels(at_ns))
        if self._hot and self.layer.enabled:  # a driver that the tick has enabled shows its fault at once
            self.layer.overheat(at_ns, True)
        self._plan(at_ns)

    def _levels(self, at_ns: int) -> int:
        """Return the levels of the drive's inputs; bit n is input n + 1."""
        levels = self.machine.levels(at_ns)
        return sum(1 << index for index, bit in enumerate(self.terminals) if levels & bit)

    def _plan(self, at_ns: int) -> None:
        """Compute the next tick after `at_ns`, and the next check of the shaft's lag."""
        due_ns, wake_ns = self.axis.next_input_ns(), self.layer.next_wake_ns(at_ns)
        if wake_ns is not None:
            due_ns = min(due_ns, wake_ns)
        due_ns = max(due_ns, at_ns + 1)
        self._tick_due_ns = NEVER if due_ns >= NEVER else self._tick_at_or_after(due_ns)
        self._stall_due_ns = self._next_stall(at_ns)

    # -- stall detection ------------------------------------------------------------------------

    def _stall_steps(self) -> int:
        """Return the lag of the shaft, in steps, at which a stall is detected."""
        configuration = self.layer.state.configuration
        assert configuration is not None
        return max(1, configuration.steps_per_turn * self.options.stall_angle // 360)

    def _lag_steps(self) -> int:
        """Return the number of steps that the shaft has lost during this motion."""
        return abs(self.axis.position - self.machine.shaft - self._lead_at_start)

    def _next_stall(self, at_ns: int) -> int:
        """Return the earliest instant at which the lag can reach the stall limit."""
        configuration, motion = self.layer.state.configuration, self.axis.motion
        if motion is None or configuration is None or not configuration.stall_detection:
            self._lead_at_start = self.axis.position - self.machine.shaft
            return NEVER
        steps_missing = self._stall_steps() - self._lag_steps()
        return self.axis.instant_after(self.machine.free_steps(motion.direction) + max(1, steps_missing))
