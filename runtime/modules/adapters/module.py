"""An adapter in a slot: the 3601's command layer, and a device at the end of a line.

    changed words act at the next 250 µs; inputs act when they have been read
    |  tick  |        |        |        |
    words --^    line: request, reply, request, reply ... published --^ tick

Without a successful exchange, MODULE_OK is clear, the words keep their values, and commands are ignored. A
new configuration is shown once the device has accepted it. STOPPED, MOVE_COMPLETE, AT_HOME and HOLD_STATE are
shown once a read finds the device at rest. Words that arrive during a hard stop or a configuration wait for
its end, in their order:

    words  STOP  0  PRESET  0                         outputs, one image after the other
    obeyed STOP ........................ 0 PRESET 0   a tick each, so no edge is lost
    line        stop, status, position |
    image  MOVING                      | STOPPED
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Generic

from scanrack.io_images.amci3601 import CommandLsw, Firmware, InputBit, StatusMsw
from scanrack.io_images.image import Image, signed_word

from ...line.clients.link import Link
from ...line.wire import LineFormat
from ...loop.events import Event
from ...loop.incidents import FaultKind
from ...machine import Machine
from ..amci3601 import Amci3601Options, CommandLayer, Refusal
from ..amci3601.latches import COMPLETION
from ..amci3601.report import report
from ..record import Options
from .capabilities import RowCapabilities
from .driver import Driver
from .exchanges import ControllerState
from .findings import Finding, FindingKind
from .linked_axis import LinkedAxis
from .plant import LinkedController, SimulatedController
from .task import Drive

Words = tuple[int, ...]
"""The eight output words of an image."""

TICK_NS = 250_000
NEVER = 1 << 62
MODULE_OK = StatusMsw.MODULE_OK.value
MODE_CONFIG = StatusMsw.MODE_CONFIG.value
CONFIG_ERROR = StatusMsw.CONFIG_ERROR.value
COMMAND_ERROR = StatusMsw.COMMAND_ERROR.value
POSITION_INVALID = StatusMsw.POSITION_INVALID.value
INVALID_PROFILE = StatusMsw.INVALID_PROFILE.value
STOPPED = StatusMsw.STOPPED.value
CLEARED_BY_RETURN = MODE_CONFIG - 1 & ~(MODULE_OK | CONFIG_ERROR)
"""Bits of input word 0 that are cleared when the link is back: not mode, MODULE_OK or CONFIG_ERROR."""
COMMAND_BITS = 0x7FFF
"""Command bits of output word 0; bit 15 selects configuration mode."""
COMMANDS_OF_LSW = (
    CommandLsw.ENC_FOLLOWER | CommandLsw.BLEND_PROGRAM | CommandLsw.BLEND_TRANSMIT | CommandLsw.STORE_MIN_REG
).value
WAITING_MAX = 1000
"""Maximum number of images that wait for a stop or a configuration to end."""
ENDLESS = 1 << 62
"""Number of replies affected by a disturbance that lasts indefinitely."""


@dataclass(frozen=True, slots=True)
class AdapterKind(Generic[Drive]):
    """The parts of an adapter that differ by device.

    Attributes:
        driver: makes a driver from options and an address.
        axis: makes an axis, not yet configured, from a driver and options.
        plant: makes a simulated device at address 1 from its machine and options.
        capabilities: reasons to refuse configurations and commands.
        network: opens a port that is not a serial line, by its name; None for a serial line.
    """

    options: type[Any]
    line_format: LineFormat
    driver: Callable[[Any, int], Driver[Drive]]
    axis: Callable[[Any, Any], LinkedAxis[Drive]]
    plant: Callable[[Machine, Any], SimulatedController]
    capabilities: type[RowCapabilities[Any]]
    network: Callable[[str], Link] | None = None

    def simulated(
        self, machine: Machine | None = None, options: Options | None = None
    ) -> SimulatedAdapter[Drive]:
        """Return an adapter with a simulated device and line.

        Args:
            machine: machine of the simulated device; by default without switches.
            options: options of the adapter, by name.

        Raises:
            ValueError: an unknown option, an invalid value, or a machine that slips or jams.
        """
        chosen_options = self.options.of(options)
        plant = self.plant(Machine() if machine is None else machine, chosen_options)
        return SimulatedAdapter(plant, self, chosen_options)


class Adapter(Generic[Drive]):
    """A device that acts as a 3601; satisfies `runtime.loop.module.Module`.

    Attributes:
        machine: machine of the simulated device.
        controller: the device at the far end of the line.
        events: events in order of time; the caller empties the list.
        axis: the device as an axis of the command layer.
        layer: the 3601's rules.
    """

    def __init__(
        self, controller: LinkedController, kind: AdapterKind[Drive], options: object, address: int = 1
    ) -> None:
        self.machine = controller.machine
        self._kind = kind
        self._options = options
        self._address = address
        self.controller: LinkedController = controller
        self.events: list[Event] = []
        self._now_ns = 0
        self._plc_running = True
        self._asks_for_configuration = False  # the PLC has requested configuration mode
        self._image = Image()
        self._power_up()

    @property
    def under_way(self) -> str | None:
        """The kind of the running motion, or None."""
        return self.layer.under_way

    def _power_up(self) -> None:
        """Start with a new driver and the state of a 3601 at power-up."""
        self.driver = self._kind.driver(self._options, self._address)
        self.driver.master.now_ns = self._now_ns
        self._locked_out = False  # commands are refused until all command bits have been low
        self._reset_layer()
        self._image.clear()
        self._publish()

    def _reset_layer(self) -> None:
        """Start with a new axis and new 3601 rules; commands and configuration are lost."""
        self.axis = self._kind.axis(self.driver, self._options)
        self.layer = CommandLayer(
            self.axis, Firmware.parse("4.1"), Amci3601Options(), self.events, self._now_ns
        )
        self.layer.state.running = self._plc_running
        self._acted_on: bytes | None = None  # output words at the last tick
        self._tick_due_ns = NEVER
        self._waiting: deque[Words] = deque()  # words that have not been obeyed yet, in their order
        self._missed = False  # a waiting command was dropped, and its refusal is not shown yet
        self._was_settled = True  # whether the axis was settled at the last tick

    # -- the contract -------------------------------------------------------------------------

    def update(self, now_ns: int, outputs: Image) -> Image:
        """Advance to `now_ns` with `outputs` in force since the last call; return the input image."""
        words_due_ns = NEVER
        if outputs.raw.tobytes() != self._acted_on:
            words_due_ns = self._words_due_ns()
        while True:
            line_ns, tick_ns = self._wire_due_ns(), min(self._tick_due_ns, words_due_ns)
            if tick_ns < now_ns and tick_ns <= line_ns:
                self._now_ns = tick_ns
                self._tick_due_ns = words_due_ns = NEVER
                self._tick(tick_ns, outputs)
            elif line_ns <= now_ns:
                self._now_ns = line_ns
                self._advance_line(line_ns, outputs)
            else:
                break
        self._now_ns = now_ns
        self.controller.run_until(now_ns)
        self.events += self.machine.events
        self.machine.events.clear()
        self._asks_for_configuration = not self._plc_running or outputs[0] < 0
        self._publish()
        return self._image

    def plc_run(self, running: bool) -> None:
        """Set whether the PLC is in run mode, from the last `update` on."""
        if running != self._plc_running:
            self._plc_running = running
            self._tick_due_ns = _tick_at_or_after(self._now_ns)

    def power_cycle(self) -> None:
        """Cycle the power of adapter and device."""
        self.controller.power_cycle(self._now_ns)
        self._power_up()

    def cycle_device(self) -> None:
        """Cycle the power of the device, but not of the adapter."""
        self.controller.power_cycle(self._now_ns)

    def machine_at(self, now_ns: int) -> Machine:
        """Return the machine at `now_ns`, the instant of the last `update`."""
        return self.machine

    def figures(self) -> tuple[int, int, int]:
        """Return shaft position, encoder counts and the mask of energized inputs at the last `update`."""
        machine = self.machine
        return machine.shaft, machine.encoder_counts(self._now_ns), machine.shown

    def operate(self, bit: InputBit, energized: bool | None) -> None:
        """Operate an input of the machine; see `Machine.operate`."""
        self.machine.operate(bit, energized, self._now_ns)
        self.look_again()

    def look_again(self) -> None:
        """Read the machine's inputs again after an external change."""
        self.controller.sense(self._now_ns)

    # -- time ---------------------------------------------------------------------------------

    def _words_due_ns(self) -> int:
        """Return the instant at which changed words act."""
        return _tick_at_or_after(self._now_ns)

    def _wire_due_ns(self) -> int:
        """Return the instant of the next event of the driver or of the device."""
        wake_ns = self.driver.master.next_wake_ns
        event_ns = self.controller.next_event_ns(self._now_ns)
        return max(self._now_ns, wake_ns if event_ns is None else min(wake_ns, event_ns))

    def _advance_line(self, now_ns: int, outputs: Image) -> None:
        """Advance the line to its next event at `now_ns`; tick if the driver has published a read."""
        master, line = self.driver.master, self.controller.line
        self.controller.run_until(now_ns)
        master.receive(now_ns, line.take())
        data = master.advance(now_ns)
        if data:
            line.send(data, master.line_format)
        if master.published:
            master.published = False
            self._tick(now_ns, outputs)

    def _tick(self, now_ns: int, outputs: Image) -> None:
        """Carry out one tick: findings of the driver, output words, refusals; set the next tick.

        While the device is absent, words are not obeyed.
        """
        self._acted_on = outputs.raw.tobytes()
        words_now = tuple(outputs)
        findings = self.driver.findings.take()
        self._process_findings(now_ns, findings, words_now)
        if self.driver.state is ControllerState.ABSENT:
            self._ignore_words(now_ns, words_now)
            return
        if self.layer.state.running != self._plc_running:
            self._change_mode(now_ns)
        words = self._next_words(words_now)
        if self._locked_out:
            self._stay_locked_out(now_ns, words)
        self.layer.tick(now_ns, words, self.axis.levels)
        self.driver.wake_for_requests()
        self._show_short_stop(now_ns, findings)
        self._refuse_missed(now_ns)
        self._report_substitutions(now_ns)
        self._tick_due_ns = self._next_tick(now_ns)
        if self.layer.state.configuration is not None:
            self.controller.rewire(now_ns, self.layer.state.configuration)

    def _next_tick(self, now_ns: int) -> int:
        """Return the instant of the next tick if no words change and no reply arrives."""
        wake_ns = self.layer.next_wake_ns(now_ns)
        if self._waiting and self.axis.settled:
            wake_ns = now_ns + 1
        return NEVER if wake_ns is None else max(_tick_at_or_after(wake_ns), now_ns + 1)

    # -- output words -------------------------------------------------------------------------

    def _next_words(self, words: Words) -> Words:
        """Return the words to obey now: the words of this scan, or earlier words that wait.

        The tick at which a wait ends obeys no new words: a motion must end before the next one begins.
        """
        waiting, obeyed_words = self._waiting, self.layer.state.command.words
        is_ready, self._was_settled = self._was_settled and self.axis.settled, self.axis.settled
        if not self._plc_running:
            return obeyed_words
        if words != (waiting[-1] if waiting else obeyed_words):
            waiting.append(words)
        if len(waiting) > WAITING_MAX:
            self._drop_waiting()
            waiting.append(words)
        return waiting.popleft() if waiting and is_ready else obeyed_words

    def _drop_waiting(self) -> None:
        """Drop waiting words, and note whether a command was among them."""
        images = (self.layer.state.command.words, *self._waiting)
        self._missed = self._missed or any(
            _command_rises(previous, following) for previous, following in pairwise(images)
        )
        self._waiting.clear()

    def _refuse_missed(self, now_ns: int) -> None:
        """Refuse dropped commands as soon as an error bit can be shown."""
        if self._missed and self.axis.settled and not self.layer.state.in_configuration_mode:
            self._missed = False
            self._refuse(now_ns, "missed", "a command waited too long for a stop or a configuration")

    def _stay_locked_out(self, now_ns: int, words: Words) -> None:
        """After a loss of the link, refuse commands until all command bits have been low."""
        self._locked_out = bool(words[0] & COMMAND_BITS) and words[0] >= 0
        if self._locked_out:
            if _command_rises(self.layer.state.command.words, words):
                text = "after a loss of the link, all command bits must be low once before a command"
                self._refuse(now_ns, "locked out", text)
            self.layer.overlook(words)

    def _ignore_words(self, now_ns: int, words: Words) -> None:
        """End a motion while the device is absent; bits that are set now do not cause an edge later."""
        self.layer.abandon(now_ns)
        self._waiting.clear()
        self._missed = False
        if self.layer.state.configuration is not None:
            self.layer.state.held = None
            self._overlook(words)

    def _overlook(self, words: Words) -> None:
        """Record words without obeying them, to prevent an edge; a configuration is obeyed later."""
        if words[0] >= 0:
            self.layer.overlook(words)

    def _refuse(self, now_ns: int, name: str, text: str) -> None:
        self.layer.refuse(now_ns, Refusal(name, COMMAND_ERROR, text))

    def _change_mode(self, now_ns: int) -> None:
        """Follow the PLC into or out of run mode."""
        if self.layer.state.running:
            self._drop_waiting()
            self.layer.leave_run_mode(now_ns)
        else:
            self.layer.enter_run_mode()

    # -- findings of the driver ---------------------------------------------------------------

    def _process_findings(self, now_ns: int, findings: Iterable[Finding], words: Words) -> None:
        """Convert findings about the device to the 3601's bits."""
        for finding in findings:
            match finding.kind:
                case FindingKind.POWER_LOST:
                    self._lose_power(now_ns)
                case FindingKind.COMPLAINT:
                    self._show(now_ns, "controller error", finding.bits, finding.text)
                case FindingKind.RETURNED:
                    self._show_return(now_ns, words)
                case FindingKind.STRAYED:
                    self._show_stray_motion(now_ns)
                case FindingKind.OUT_OF_RANGE:
                    self._show_end_of_range(now_ns)

    def _lose_power(self, now_ns: int) -> None:
        """Note that the device has lost power; a 3601 then also loses its configuration."""
        self._note(now_ns, "power lost", "the device has lost its power and its configuration")
        self._reset_layer()
        self._image.clear()

    def _show_stray_motion(self, now_ns: int) -> None:
        """Show that the axis has moved without a command, and clear the bits that show it at rest."""
        self.layer.state.latches.clear(COMPLETION)
        self.layer.state.held = None
        self._show(now_ns, "strayed", POSITION_INVALID, "the axis has moved without a command")

    def _show_return(self, now_ns: int, words: Words) -> None:
        """Show that the link is back and the position is invalid; refuse commands until all bits are off.

        Command bits that are already on in `words` cause no edge.
        """
        self.layer.state.latches.clear(CLEARED_BY_RETURN)
        text = "the device answers again; it may have moved without the link"
        self._show(now_ns, "link restored", POSITION_INVALID | STOPPED, text)
        self._overlook(words)
        self._locked_out = True

    def _show_end_of_range(self, now_ns: int) -> None:
        """Refuse to continue at the end of the counter's range."""
        reason = "the device's counter has reached the end of its range"
        self.layer.refuse(now_ns, Refusal("counter range", INVALID_PROFILE | COMMAND_ERROR, reason))
        if self.layer.operation is not None:
            self.layer.operation.on_many_bits(now_ns)

    def _show_short_stop(self, now_ns: int, findings: Iterable[Finding]) -> None:
        """End a move that has stopped before its target although no limit is active."""
        if any(finding.kind is FindingKind.STOPPED_SHORT for finding in findings):
            self._show(now_ns, "stopped short", POSITION_INVALID, "the device has stopped before the target")
            if self.layer.cuttable:
                self.layer.cut(now_ns)

    def _report_substitutions(self, now_ns: int) -> None:
        substitutions = self.axis.substitutions
        self.events += [Event(now_ns, "substitution", row.name, row.how) for row in substitutions]
        substitutions.clear()

    def _show(self, now_ns: int, name: str, bits: int, text: str) -> None:
        self.layer.state.latches.show(now_ns, "adapter", name, bits, text)

    def _note(self, now_ns: int, name: str, text: str) -> None:
        self.events.append(Event(now_ns, "adapter", name, text))

    # -- the input image ----------------------------------------------------------------------

    def _publish(self) -> None:
        """Write the input image; an absent device, or one being configured, has fixed bits."""
        layer, words = self.layer, self._image.words
        if self.driver.state is ControllerState.ABSENT:
            mode_bit = layer.state.latches.bits & MODE_CONFIG if self._asks_for_configuration else 0
            words[0] = signed_word(POSITION_INVALID | mode_bit)
            words[1] = 0
        elif layer.state.in_configuration_mode and self.driver.setup:
            words[0] = signed_word(MODE_CONFIG | MODULE_OK | CONFIG_ERROR)
        else:
            report(layer, words)
        if self.driver.unfit:
            words[0] = signed_word(words[0] & 0xFFFF & ~(MODULE_OK | COMPLETION))


class SimulatedAdapter(Adapter[Drive]):
    """An adapter with a simulated device and line; both can be disturbed."""

    controller: SimulatedController

    def disturb(self, fault: FaultKind, *, begins: bool, lasts: bool) -> None:
        """Begin or end a disturbance of the line or the device at the last `update`.

        Args:
            fault: one of `incidents.ON_THE_LINE`.
            lasts: whether it lasts until a call with `begins` false; otherwise it affects one reply.
        """
        line = self.controller.line
        replies = 0
        if begins:
            replies = ENDLESS if lasts else 1
        if fault is FaultKind.CONTROLLER_POWER_CYCLE:
            self.cycle_device()
        elif fault is FaultKind.REPLIES_LOST:
            line.faults.drop_next = replies
        elif fault is FaultKind.REPLIES_DAMAGED:
            line.faults.corrupt_next = replies
        elif begins:
            line.take_down()
        else:
            line.put_up()


def _command_rises(previous: Words, words: Words) -> bool:
    """Return whether a command bit rises from one image to the next; configuration words have none."""
    if words[0] < 0:
        return False
    lsw_before = previous[1] if previous[0] >= 0 else 0
    return bool(words[0] & ~previous[0] & COMMAND_BITS or words[1] & ~lsw_before & COMMANDS_OF_LSW)


def _tick_at_or_after(instant_ns: int) -> int:
    return -(-instant_ns // TICK_NS) * TICK_NS
