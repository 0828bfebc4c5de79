"""Replays a recording into modules, a program, or a whole rack."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from types import MappingProxyType

from scanrack.io_images.amci3601 import InputBit
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.faults import CpuFault
from scanrack.runtime.loop.listeners import ScanListener
from scanrack.runtime.loop.scan import CpuMode, ScanLogic
from scanrack.traces.compare import Tolerance
from scanrack.traces.follower import Follower
from scanrack.traces.read.reader import TraceEvent
from scanrack.traces.replay import Image, PackedTrace

from ..load.building import build_rack
from ..load.recorded_scans import recorded_rack
from ..record.edits_and_forces import image_forces, is_edit
from ..record.link_losses import link_changes
from ..run.build import build_playback
from ..run.playback import RecordedInputs, ReplayPlan, Stimulus, recorded_outputs, stimulated
from ..run.running import Observer, unobserved
from .input_levels import recorded_levels
from .resumed_operation import ResumedOperation
from .tag_orders import TagOrders, first_few
from .targets import ReplayTarget, Stimuli


class Replay:
    """The replay of a recording into a receiver.

    Args:
        spec: the rack; its modules respond to the recorded outputs.
        logic: the program; None = send the recorded outputs.
        into: the receiver.
        slots: numbers of the slots whose images are compared.
        resumed: the modules that were already in operation; None = all have just been powered up.
        exact_inputs: whether the instants at which inputs change are known.

    Attributes:
        notes: sentences about assumptions and restrictions of the replay.
    """

    def __init__(
        self,
        recording: PackedTrace,
        spec: RackSpec,
        logic: ScanLogic | None,
        into: ReplayTarget,
        slots: Sequence[int],
        resumed: ResumedOperation | None = None,
        *,
        exact_inputs: bool = False,
    ) -> None:
        self._recording, self._slots = recording, slots
        self._resumed = resumed if resumed is not None and resumed.slots else None
        if self._resumed is not None:  # the images show its faults
            spec = spec.model_copy(update={"incidents": ()})
        self._spec = spec
        self._plan = plan_of(recording)
        if into is ReplayTarget.PROGRAM:
            self.rack = recorded_rack(recording.slots, spec, _recorded_inputs(recording))
        elif self._resumed is not None:
            self.rack = build_rack(spec, around=partial(self._resumed.around, exact_inputs=exact_inputs))
        else:
            self.rack = build_rack(spec)
        self._logic = logic or recorded_outputs(self._plan, recording.memory, recording.layout)
        directions = {  # the images that the receiver produces, and that are compared
            ReplayTarget.MODULE: ("in",),
            ReplayTarget.PROGRAM: ("out",),
            ReplayTarget.RACK: ("in", "out"),
        }[into]
        self._images: list[Image] = [(slot, direction) for slot in slots for direction in directions]
        self.notes = list(_assumptions(into, self._plan, resumed=self._resumed is not None))
        self._orders: TagOrders | None = None
        if into is not ReplayTarget.MODULE:
            self.notes += edit_notes(recording.events)
            self._orders = TagOrders(recording)
            self.notes += self._orders.notes

    def run(
        self,
        allowed: Tolerance,
        *,
        to_the_end: bool,
        observed: Observer = unobserved,
        recorders: Sequence[ScanListener] = (),
    ) -> Follower:
        """Replay to the first difference, or to the end; return the follower with the comparison.

        A program that hangs or raises an exception also ends the replay, with a note.

        Args:
            recorders: listeners that receive every replayed scan.

        Raises:
            KeyboardInterrupt: Ctrl-C stopped the replay; the comparison is incomplete.
            ValueError: the recording never shows the state of a module that was already in operation.
        """
        follower = Follower(self._recording, self.rack.memory, self._images, tolerance=allowed)
        logic = self._logic if self._orders is None else self._orders.program(self._logic)
        cpu = build_playback(self._spec, self._plan, logic, self.rack, listeners=[follower, *recorders])
        repeater = None if self._orders is None else self._orders.give(cpu, self.rack, logic)
        if not to_the_end:
            follower.stop = cpu.stop
        with cpu.stopping_on_ctrl_c(), cpu, observed(cpu, self._plan.numbers[-1]):
            try:
                cpu.play()
            except CpuFault as error:
                self.notes.append(f"the replay faulted in {error}")
        if cpu.stop_requested and not follower.stopped:
            raise KeyboardInterrupt
        if repeater is not None:
            self.notes += first_few(repeater.refused)
        if self._resumed is not None:
            self.notes += self._resumed.notes(self._slots)
        return follower


def _recorded_inputs(recording: PackedTrace) -> dict[int, RecordedInputs]:
    """Return a module for each slot, by number, that returns the recorded input images."""
    return {
        slot.number: RecordedInputs(
            recording.images((slot.number, "in")),
            recording.times,
            link_changes(recording.events, slot.number),
        )
        for slot in recording.slots
    }


def plan_of(recording: PackedTrace) -> ReplayPlan:
    """Return the numbers, times, modes and forces of the scans in a recording."""
    forces = {event.scan: image_forces(event) for event in recording.events if event.topic == "/forces"}
    return ReplayPlan(recording.numbers, recording.times, recording.flags, forces)


def edit_notes(events: Iterable[TraceEvent]) -> list[str]:
    """Return a note for each edit of the running program, for a command that runs only the first program."""
    return [
        f"the program was edited before scan {event.scan:,}: the first program continues here"
        for event in events
        if is_edit(event)
    ]


def lost_notes(scans: Iterable[int]) -> list[str]:
    """Return a note for each scan from `lost_edits`."""
    return [
        f"the program was edited before scan {scan:,}: the trace contains only the first program"
        for scan in scans
    ]


def forced_rows(plan: ReplayPlan) -> list[bool]:
    """Return whether forces were in effect in each row."""
    forced, rows = False, []
    for number in plan.numbers:
        forced = bool(plan.forces.get(number, forced))
        rows.append(forced)
    return rows


_FRESH = {
    ReplayTarget.MODULE: "the module is assumed to be just powered up",
    ReplayTarget.PROGRAM: "the program is assumed to have just started",
    ReplayTarget.RACK: "the rack is assumed to be just powered up",
}
"""Assumptions about the first scan of a trace that begins after scan 0."""


def _assumptions(into: ReplayTarget, plan: ReplayPlan, *, resumed: bool) -> Iterator[str]:
    """Yield notes about a late beginning, scans only in program mode, and missing scans."""
    first = plan.numbers[0]
    if first and not resumed:
        yield f"the trace begins with scan {first:,}: {_FRESH[into]} then"
    if all(plan.mode(row) is CpuMode.PROGRAM for row in range(len(plan.flags))):
        yield "all scans are in program mode, in which logic does not run and outputs are not sent"
    yield from first_few(list(_gaps(plan.numbers)))


def _gaps(numbers: Sequence[int]) -> Iterator[str]:
    for before, after in pairwise(numbers):
        if after != before + 1:
            missing = f"scans {before + 1} to {after - 1} are missing"
            yield f"{missing}: outputs and inputs are assumed to stay as in scan {before}"


def recorded_stimuli(recording: PackedTrace) -> Iterator[Stimulus]:
    """Yield the recorded stimuli of the machines' inputs; injected faults are in the rack itself.

    An input of a card can have the same name as an input of a machine, but a card has no machine.
    """
    steppers = {slot.number for slot in recording.slots if slot.is_stepper}
    for event in recording.events:
        name = str(event.fields.get("name")).upper()
        if event.topic == "/stimuli" and name in InputBit.__members__:
            slot, level = event.fields.get("slot"), event.fields.get("energized")
            if isinstance(slot, int) and slot in steppers:
                yield Stimulus(event.now_ns, slot, InputBit[name], None if level is None else bool(level))


def with_stimuli(
    spec: RackSpec, recording: PackedTrace, stimuli: Stimuli, high: Mapping[int, int] = MappingProxyType({})
) -> RackSpec:
    """Return a rack with the selected stimuli for its machines; for `high`, see `recorded_levels`."""
    if stimuli is Stimuli.MACHINE:
        return spec
    is_recorded = stimuli is Stimuli.RECORDED
    by_slot: dict[int, list[Stimulus]] = defaultdict(list)
    for stimulus in recorded_stimuli(recording) if is_recorded else recorded_levels(recording, high):
        by_slot[stimulus.slot].append(stimulus)
    slots = []
    for slot in spec.slot:
        machine = stimulated(slot.machine, by_slot[slot.number], switches=is_recorded)
        slots.append(slot.model_copy(update={"machine": machine}))
    return spec.model_copy(update={"slot": tuple(slots)})


def without_missing_slots(recording: PackedTrace, spec: RackSpec) -> tuple[RackSpec, list[str]]:
    """Return a rack without the slots that a recording lacks, and notes about these slots."""
    recorded = {slot.number for slot in recording.slots}
    missing = sorted({slot.number for slot in spec.slot} - recorded)
    slots = tuple(slot for slot in spec.slot if slot.number in recorded)
    if not missing or not slots:
        return spec, []
    note = f"the rack's {_slots(missing)} is not in the trace and is left out"
    return spec.model_copy(update={"slot": slots}), [note]


def check_slots(recording: PackedTrace, spec: RackSpec, only: int | None) -> list[int]:
    """Return the numbers of the slots whose images are compared.

    Raises:
        ValueError: trace and rack have different slots, or lack the requested slot.
    """
    recorded = sorted(slot.number for slot in recording.slots)
    rack_numbers = sorted(slot.number for slot in spec.slot)
    if recorded != rack_numbers:
        raise ValueError(
            f"the trace has {_slots(recorded)}, the rack {_slots(rack_numbers)}: they must be the same"
        )
    if only is None:
        return recorded
    if only not in recorded:
        raise ValueError(f"--slot {only}: the trace has {_slots(recorded)}")
    return [only]


def _slots(numbers: Iterable[int]) -> str:
    return f"slot {', '.join(map(str, numbers))}"
