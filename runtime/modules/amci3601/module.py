"""The simulated 3601 in a slot: its time, its 250 µs scan and its input image.

The module's firmware reads its words and inputs every 250 µs. The model skips ticks at which nothing has
changed. It processes two kinds of instants:

* ticks: multiples of the module's scan at which output words or inputs have changed;
* exact instants: the end of a motion, of a ramp, and of a scan with encoder counts that the operation uses.

Between these instants, only the position changes, and a formula computes it. The images therefore do not
depend on the number of calls of `update`, and a call for 10 ms is as fast as a call for 0.25 ms.

    outputs in force  |<---- A ---->|<-------- B -------->|
    update() at       0             t1                    t2
    ticks             |  |  |  |  | |  |  |  |  |  |  |  ||
                                     ^ first tick that sees B; its effect shows at t2
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from scanrack.io_images.amci3601 import Configuration, Firmware, InputBit
from scanrack.io_images.amci3601.words import WORDS_3601, Profile
from scanrack.io_images.image import Image
from scanrack.io_images.thousands import split_reported, split_reported_all
from typing_extensions import override

from ...kinematics import Segment
from ...loop.events import Event, JsonValue
from ...loop.module import unnoticed
from ...loop.module_fault import ModuleFault
from ...machine import Machine
from .amci3601_options import Amci3601Options
from .command_layer import CommandLayer
from .indicators import UNPOWERED, indicators
from .report import adopt_image, report
from .step_generator import NEVER, StepGenerator, SteppedModule
from .trouble import FAULT_IMAGES

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Amci3601(SteppedModule):
    """A simulated AMCI 3601 with its simulated machine; satisfies `runtime.loop.module.Module`.

    Attributes:
        trouble: the present fault, or None; see `inject`.
        linked: whether the PLC can reach the module. It can still do so after a fatal error, but MODULE_OK is
            clear. This is a plain field, since logic reads it in every scan.
        indicators: the lights of the front panel.
        events: events in order of time; the caller empties the list.
        before_change: function called before any access to the module or its machine other than `update`.

    Args:
        firmware: "2.0", "2.1", "2.2", "3.1" or "4.1", or a `Firmware`.
        machine: by default a machine without switches.
        options: options of the model by name; see `Amci3601Options`.
        diagnostic_wiring: the step outputs are wired to the encoder inputs.
        profile: the module of the family; by default a 3601.

    Raises:
        ValueError: an unknown firmware or option.
    """

    # the classes of the parts, which another module of the family replaces
    _layer_of: Callable[..., CommandLayer] = CommandLayer
    _axis_of: Callable[..., StepGenerator] = StepGenerator

    def __init__(
        self,
        firmware: str | Firmware = "4.1",
        machine: Machine | None = None,
        options: Mapping[str, JsonValue] | None = None,
        *,
        diagnostic_wiring: bool = False,
        profile: Profile = WORDS_3601,
    ) -> None:
        self.profile = profile
        self.firmware = Firmware.parse(firmware) if isinstance(firmware, str) else firmware
        self.machine = Machine() if machine is None else machine
        self.options = Amci3601Options.of(options)
        self.events: list[Event] = []
        self.before_change: Callable[[], None] = unnoticed
        self.machine.before_change = self._on_machine_change
        self._tick_ns = 1000 * self.options.input_scan_us
        self._diagnostic_wiring = diagnostic_wiring
        self._now_ns = 0
        self._plc_running = True
        self._image = Image()
        self._counting = False
        self._segment: Segment | None = None
        self._reported_steps = -1  # steps of the motion in the image, -1 if the image must be updated
        self.trouble: ModuleFault | None = None
        self.linked = True
        self.indicators = UNPOWERED
        self._power_up()

    def _power_up(self) -> None:
        """Make a new axis and command layer, and show their first image; shaft and clock continue."""
        self.axis = self._axis_of(self.machine, diagnostic_wiring=self._diagnostic_wiring)
        self.axis.advance(self._now_ns)
        self.layer = self._layer_of(
            self.axis, self.firmware, self.options, self.events, self._now_ns, self.profile
        )
        self.layer.state.running = self._plc_running
        self._acted_on: bytes | None = None  # the output words at the last tick
        self._tick_due_ns = self._counts_due_ns = NEVER  # the next tick, and the end of the next counted scan
        self._due_ns = self._now_ns  # until this instant only position and count change
        self._publish()

    # -- the contract -------------------------------------------------------------------------

    def update(self, now_ns: int, outputs: Image) -> Image:
        """Advance to `now_ns` with `outputs` in force since the last call, and return the input image."""
        if now_ns >= self._due_ns or outputs.raw.tobytes() != self._acted_on:
            self._work(now_ns, outputs)
        elif self._counting:
            self._report_counts(now_ns)
        elif self._segment is not None:
            self._report_travel(now_ns, self._segment)
        self._now_ns = now_ns
        return self._image

    def plc_run(self, running: bool) -> None:
        """Set whether the PLC is in run mode, effective from the last `update`."""
        if running != self._plc_running:
            self.before_change()
            self._plc_running = running
            self.look_again()

    def power_cycle(self) -> None:
        """Cycle the power; the shaft and the clock keep their state."""
        self.before_change()
        self._end_step_output()
        self.trouble, self.linked = None, True
        self._power_up()

    def take_state(
        self, now_ns: int, outputs: Image, shown: Sequence[int], configuration: Configuration | None
    ) -> None:
        """Adopt at `now_ns` the state that an input image shows at rest in command mode.

        All other state is as after power-up, without a stored blend profile. The minimum registration
        distance is 1 step with `MIN_REG_NONZERO`, otherwise 0.

        Args:
            outputs: the words in force; their bits do not cause an edge.
            shown: the input words, unsigned.
        """
        self.before_change()
        self._now_ns = now_ns
        events_before = len(self.events)
        self._power_up()
        del self.events[events_before:]
        adopt_image(self.layer, shown, configuration)
        self.layer.overlook(tuple(outputs))
        self._acted_on = outputs.raw.tobytes()
        self._publish()
        self._foresee()
        self.look_again()

    @property
    def under_way(self) -> str | None:
        """The kind of the running motion, or None."""
        return self.layer.under_way

    def inject(self, trouble: ModuleFault | None) -> None:
        """Inject a fault at the last `update`; None ends it.

        Raises:
            ValueError: None after a fatal error, which only `power_cycle` ends.
        """
        if trouble is None and self.trouble is ModuleFault.FATAL_ERROR:
            raise ValueError("trouble None: only a power cycle ends a fatal error")
        self.before_change()
        if self.trouble is ModuleFault.REMOVED:
            self.power_cycle()
        self.trouble = trouble
        self.linked = trouble is None or FAULT_IMAGES[trouble].linked
        if trouble in (ModuleFault.REMOVED, ModuleFault.FATAL_ERROR):
            self._end_step_output()
        self.look_again()

    def _on_machine_change(self) -> None:
        """Announce an external change of the machine, and check the counts at the next tick."""
        self.before_change()
        if self._counts_due_ns == NEVER and self.layer.counts_from_ns(self._now_ns, self._now_ns) is not None:
            self._counts_due_ns = self._now_ns // self._tick_ns * self._tick_ns + self._tick_ns
            self._due_ns = 0

    def _end_step_output(self) -> None:
        """End the step output at the last `update`."""
        self.axis.advance(self._now_ns)
        self.axis.cut(self._now_ns)
        self.layer.operation = None

    def operate(self, bit: InputBit, energized: bool | None) -> None:
        """Operate an input of the machine; see `Machine.operate`."""
        self.before_change()
        self.machine.operate(bit, energized, self._now_ns)
        self.look_again()

    def look_again(self) -> None:
        """Sample inputs and mode at the next tick, after an external change."""
        self.before_change()
        self._tick_due_ns = self._tick_at_or_after(self._now_ns)
        self._due_ns = 0

    # -- prediction ---------------------------------------------------------------------------

    @override
    def _split_all(self, values: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        return split_reported_all(values)

    # -- time ---------------------------------------------------------------------------------

    def _work(self, now_ns: int, outputs: Image) -> None:
        """Process all events up to `now_ns`, write the input image, and find the next event.

        In a module that is removed or has a fatal error, only the time advances.
        """
        if self.trouble in (ModuleFault.REMOVED, ModuleFault.FATAL_ERROR):
            self.axis.advance(now_ns)
        else:
            self._process_events(now_ns, outputs)
        self._publish()
        self._foresee()

    def _process_events(self, now_ns: int, outputs: Image) -> None:
        """Process all ticks and exact instants up to `now_ns`.

        A tick at `now_ns` itself belongs to the next call and its words; the end of a motion or scan at
        `now_ns` belongs to this call.
        """
        words_due_ns = NEVER
        if outputs.raw.tobytes() != self._acted_on:
            words_due_ns = self._tick_at_or_after(self._now_ns)
        while True:
            change_ns = self.axis.next_change_ns()
            tick_ns = min(self._tick_due_ns, words_due_ns)
            counts_ns = self._counts_due_ns
            if change_ns <= now_ns and change_ns <= min(tick_ns, counts_ns):
                self._process_change(change_ns)
            elif counts_ns <= now_ns and counts_ns <= tick_ns:
                self._process_counts(counts_ns)
            elif tick_ns < now_ns:
                self._tick(tick_ns, outputs)
                words_due_ns = NEVER
            else:
                break
        self.axis.advance(now_ns)

    def _tick(self, tick_ns: int, outputs: Image) -> None:
        """Let the layer obey mode, output words and inputs at a tick; plan the next tick and count."""
        self.axis.advance(tick_ns)
        if self.layer.state.running != (self._plc_running and self.trouble is None):
            self._change_mode(tick_ns)
        self.layer.tick(tick_ns, tuple(outputs), self.machine.levels(tick_ns))
        self._acted_on = outputs.raw.tobytes()
        self._tick_due_ns = self._next_tick(tick_ns)
        self._counts_due_ns = self._next_counts(tick_ns)

    def _change_mode(self, now_ns: int) -> None:
        if self.layer.state.running:
            self.layer.leave_run_mode(now_ns)
        else:
            self.layer.enter_run_mode()

    def _process_change(self, now_ns: int) -> None:
        """End a ramp, or end a motion and let a tick follow, because the end may allow other actions."""
        if self.axis.advance(now_ns):
            self.layer.settle(now_ns)
            self._tick_due_ns = self._tick_at_or_after(now_ns)

    def _process_counts(self, now_ns: int) -> None:
        """Process the encoder counts of a scan that ends now; if the motion changes, a tick follows."""
        self.axis.advance(now_ns)
        motion_before = self.axis.motion, self.axis.position
        self.layer.counted(now_ns)
        if motion_before != (self.axis.motion, self.axis.position):
            self._tick_due_ns = now_ns
        self._counts_due_ns = self._next_counts(now_ns)

    def _next_counts(self, now_ns: int) -> int:
        """Return the end of the next scan with counts that the operation uses."""
        first_ns = self.layer.counts_from_ns(now_ns, self.machine.turns_ns(now_ns))
        if first_ns is None:
            return NEVER
        return max(now_ns, first_ns // self._tick_ns * self._tick_ns) + self._tick_ns

    def _next_tick(self, tick_ns: int) -> int:
        """Return the next tick at which inputs change or the operation requests a tick."""
        due_ns, wake_ns = self.axis.next_input_ns(), self.layer.next_wake_ns(tick_ns)
        if wake_ns is not None:
            due_ns = min(due_ns, wake_ns)
        return NEVER if due_ns == NEVER else max(self._tick_at_or_after(due_ns), tick_ns + self._tick_ns)

    def _foresee(self) -> None:
        """Compute the next instant at which anything other than the position can change."""
        due_ns = min(self._tick_due_ns + 1, self._counts_due_ns, self.axis.next_change_ns())
        self._due_ns = due_ns if self.trouble is None else 0
        is_live = not self.layer.state.in_configuration_mode
        self._counting = is_live and self.axis.counting
        self._segment = self.axis.segment if is_live else None
        if self.machine.events:
            self.events.extend(self.machine.events)
            self.machine.events.clear()

    # -- the input image ----------------------------------------------------------------------

    def _publish(self) -> None:
        """Write the input image as the PLC sees it, and set the lights."""
        if self.trouble is None:
            self._report()
        else:
            for word, kept_bits in enumerate(FAULT_IMAGES[self.trouble].kept):
                self._image[word] &= kept_bits
        self._set_lights()

    def _set_lights(self) -> None:
        """Set the lights from the fault or from the status bits; report changed lights as an event."""
        layer, trouble = self.layer, self.trouble
        lights = None if trouble is None else FAULT_IMAGES[trouble].lights
        if lights is None:
            is_moving = layer.operation is not None
            lights = indicators(layer.state.latches.bits, moving=is_moving, linked=trouble is None)
        if lights != self.indicators:
            self.indicators = lights
            fields: dict[str, JsonValue] = {
                "module": lights.module.value,
                "axis_ok": lights.axis_ok.value,
                "axis_error": lights.axis_error.value,
            }
            text = f"Axis OK {lights.axis_ok.value}, Axis Err {lights.axis_error.value}"
            self.events.append(Event(self.axis.now_ns, "indicator", "lights", text, fields))

    def _report(self) -> None:
        report(self.layer, self._image.words)
        self._reported_steps = -1

    def _report_travel(self, now_ns: int, segment: Segment) -> None:
        """Update the step count in the input image; nothing else can have changed."""
        steps = segment.steps_at(now_ns)
        if steps != self._reported_steps:
            self._reported_steps = steps
            words, motion = self._image.words, self.axis.motion
            assert motion is not None
            words[2], words[3] = split_reported(motion.origin + motion.direction * steps)

    def _report_counts(self, now_ns: int) -> None:
        """Update the position and encoder count in the input image; nothing else can have changed."""
        self.axis.advance(now_ns)
        words = self._image.words
        words[2], words[3] = split_reported(self.axis.position)
        words[4], words[5] = split_reported(self.axis.encoder)
