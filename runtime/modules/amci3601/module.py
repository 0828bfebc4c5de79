"""The simulated 3601 in its slot: time, the 250 µs scan, and the input image.

The module's firmware reads its words and inputs every 250 µs. The model skips ticks
at which nothing can change; two kinds of instants remain:

* ticks: multiples of the module's scan at which the output words differ from the
  last processed ones, or an input's level has changed since the previous tick;
* exact instants: the end of a motion, of each of its ramps, and of a scan whose
  encoder counts the operation uses.

Between them only the position moves, by a formula. The images therefore do not
depend on how often `update` is called, and a call costs as much after ten
milliseconds as after a quarter of one.

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
from .report import report, take_shown
from .step_generator import NEVER, StepGenerator, SteppedModule
from .trouble import ANSWERS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Amci3601(SteppedModule):
    """A simulated AMCI 3601 with its simulated machine; satisfies `runtime.loop.module.Module`.

    Attributes:
        trouble: the present fault without answers to the PLC, if any; see `inject`.
        linked: whether the PLC reaches the module; one with a fatal error answers with MODULE_OK clear.
            A plain field, since logic reads it in every scan.
        events: in order of time; the caller empties it.
        before_change: called before any access to the module or its machine except `update`.

    Args:
        firmware: "2.0", "2.1", "2.2", "3.1" or "4.1", or a `Firmware`.
        machine: by default one without switches.
        options: options of the model by name, see `Amci3601Options`.
        diagnostic_wiring: the step outputs are wired to the encoder inputs.
        profile: the module of the family; by default a 3601.

    Raises:
        ValueError: an unknown firmware or option.
    """

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
        self.machine.before_change = self._tell_before_change
        self._tick_ns = 1000 * self.options.input_scan_us
        self._diagnostic_wiring = diagnostic_wiring
        self._now_ns = 0
        self._plc_running = True
        self._image = Image()
        self._counting = False
        self._segment: Segment | None = None
        self._steps = -1  # steps of the motion, as last reported
        self.trouble: ModuleFault | None = None
        self.linked = True
        self.indicators = UNPOWERED
        self._power_up()

    def _power_up(self) -> None:
        self.axis = self._axis_of(self.machine, diagnostic_wiring=self._diagnostic_wiring)
        self.axis.advance(self._now_ns)
        self.layer = self._layer_of(
            self.axis, self.firmware, self.options, self.events, self._now_ns, self.profile
        )
        self.layer.state.running = self._plc_running
        self._acted_on: bytes | None = None  # the output words that the layer has processed
        self._tick_due_ns = self._counts_due_ns = NEVER
        self._due_ns = self._now_ns  # only position and count change before this instant
        self._publish()

    # -- the contract -------------------------------------------------------------------------

    def update(self, now_ns: int, outputs: Image) -> Image:
        """Advance to `now_ns` with `outputs` in force since the last call; return the input image then."""
        if now_ns >= self._due_ns or outputs.raw.tobytes() != self._acted_on:
            self._work(now_ns, outputs)
        elif self._counting:
            self._report_counts(now_ns)
        elif self._segment is not None:
            self._report_travel(now_ns, self._segment)
        self._now_ns = now_ns
        return self._image

    def plc_run(self, running: bool) -> None:
        """Set whether the PLC is in run mode, effective at the last `update`."""
        if running != self._plc_running:
            self.before_change()
            self._plc_running = running
            self.look_again()

    def power_cycle(self) -> None:
        """Remove and restore power; shaft and clock continue."""
        self.before_change()
        self._fall_silent()
        self.trouble, self.linked = None, True
        self._power_up()

    def take_state(
        self, now_ns: int, outputs: Image, shown: Sequence[int], configuration: Configuration | None
    ) -> None:
        """Adopt at `now_ns` the state that an input image shows at rest in command mode.

        State that no image shows is as after power-up: there is no stored blend profile, and the minimum
        registration distance follows from `MIN_REG_NONZERO`, 1 step or none.

        Args:
            outputs: the words in force; their bits are no edges.
            shown: the input words, unsigned.
        """
        self.before_change()
        self._now_ns = now_ns
        noted = len(self.events)
        self._power_up()
        del self.events[noted:]
        take_shown(self.layer, shown, configuration)
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
            raise ValueError("trouble None: a fatal error ends with a power cycle only")
        self.before_change()
        if self.trouble is ModuleFault.REMOVED:
            self.power_cycle()
        self.trouble = trouble
        self.linked = trouble is None or ANSWERS[trouble].linked
        if trouble in (ModuleFault.REMOVED, ModuleFault.FATAL_ERROR):
            self._fall_silent()
        self.look_again()

    def _tell_before_change(self) -> None:
        """Announce a change from outside to the machine; then check the counts at the next tick."""
        self.before_change()
        if self._counts_due_ns == NEVER and self.layer.counts_from_ns(self._now_ns, self._now_ns) is not None:
            self._counts_due_ns = self._now_ns // self._tick_ns * self._tick_ns + self._tick_ns
            self._due_ns = 0

    def _fall_silent(self) -> None:
        """End the step output at the last `update`."""
        self.axis.advance(self._now_ns)
        self.axis.cut(self._now_ns)
        self.layer.operation = None

    def operate(self, bit: InputBit, energized: bool | None) -> None:
        """Operate an input of the machine at the last `update`, see `Machine.operate`."""
        self.before_change()
        self.machine.operate(bit, energized, self._now_ns)
        self.look_again()

    def look_again(self) -> None:
        """Sample inputs and mode at the next tick, after a change from outside."""
        self.before_change()
        self._tick_due_ns = self._tick_at_or_after(self._now_ns)
        self._due_ns = 0

    # -- prediction ---------------------------------------------------------------------------

    @override
    def _split_all(self, values: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        return split_reported_all(values)

    # -- time ---------------------------------------------------------------------------------

    def _work(self, now_ns: int, outputs: Image) -> None:
        if self.trouble in (ModuleFault.REMOVED, ModuleFault.FATAL_ERROR):
            self.axis.advance(now_ns)
        else:
            self._go_through(now_ns, outputs)
        self._publish()
        self._foresee()

    def _go_through(self, now_ns: int, outputs: Image) -> None:
        """Process every instant up to `now_ns` at which something happens.

        A tick at `now_ns` itself belongs to the next call, whose words it sees; the end of a
        motion or scan at `now_ns` belongs to this one.
        """
        words_due = NEVER
        if outputs.raw.tobytes() != self._acted_on:
            words_due = self._tick_at_or_after(self._now_ns)
        while True:
            change = self.axis.next_change_ns()
            tick = min(self._tick_due_ns, words_due)
            counts = self._counts_due_ns
            if change <= now_ns and change <= min(tick, counts):
                self._pass_change(change)
            elif counts <= now_ns and counts <= tick:
                self._pass_counts(counts)
            elif tick < now_ns:
                self._tick(tick, outputs)
                words_due = NEVER
            else:
                break
        self.axis.advance(now_ns)

    def _tick(self, tick_ns: int, outputs: Image) -> None:
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

    def _pass_change(self, now_ns: int) -> None:
        """End a ramp or a motion here; a tick follows the end of a motion, which permits other actions."""
        if self.axis.advance(now_ns):
            self.layer.settle(now_ns)
            self._tick_due_ns = self._tick_at_or_after(now_ns)

    def _pass_counts(self, now_ns: int) -> None:
        """Process the encoder counts of a scan that ends here; a new course expects other inputs."""
        self.axis.advance(now_ns)
        course = self.axis.motion, self.axis.position
        self.layer.counted(now_ns)
        if course != (self.axis.motion, self.axis.position):
            self._tick_due_ns = now_ns
        self._counts_due_ns = self._next_counts(now_ns)

    def _next_counts(self, now_ns: int) -> int:
        """Return the end of the next scan whose counts the operation uses."""
        first_ns = self.layer.counts_from_ns(now_ns, self.machine.turns_ns(now_ns))
        if first_ns is None:
            return NEVER
        return max(now_ns, first_ns // self._tick_ns * self._tick_ns) + self._tick_ns

    def _next_tick(self, tick_ns: int) -> int:
        """Return the next tick with changed inputs or a request of an operation."""
        instant, wake = self.axis.next_input_ns(), self.layer.next_wake_ns(tick_ns)
        if wake is not None:
            instant = min(instant, wake)
        return NEVER if instant == NEVER else max(self._tick_at_or_after(instant), tick_ns + self._tick_ns)

    def _foresee(self) -> None:
        """Compute until when only the position can change."""
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
        """Write the whole input image, as far as the PLC still sees the module, and set the lights."""
        if self.trouble is None:
            self._report()
        else:
            for word, kept_bits in enumerate(ANSWERS[self.trouble].kept):
                self._image[word] &= kept_bits
        self._set_lights()

    def _set_lights(self) -> None:
        layer, trouble = self.layer, self.trouble
        lights = None if trouble is None else ANSWERS[trouble].lights
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
        self._steps = -1

    def _report_travel(self, now_ns: int, segment: Segment) -> None:
        """Report the step count of the present segment; nothing else can have changed."""
        steps = segment.steps_at(now_ns)
        if steps != self._steps:
            self._steps = steps
            words, motion = self._image.words, self.axis.motion
            assert motion is not None
            words[2], words[3] = split_reported(motion.origin + motion.direction * steps)

    def _report_counts(self, now_ns: int) -> None:
        """Report position and encoder count; nothing else can have changed."""
        self.axis.advance(now_ns)
        words = self._image.words
        words[2], words[3] = split_reported(self.axis.position)
        words[4], words[5] = split_reported(self.axis.encoder)
