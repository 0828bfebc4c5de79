"""Extracts scenarios from recordings, with their rack and program."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from scanrack.io_images.amci3601.bits import InputBit
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.machine import MachineSpec
from scanrack.traces.files.portable import relative
from scanrack.traces.read.reader import Trace, open_trace
from scanrack.traces.replay import PackedTrace

from ..record.order_repeater import is_session, orders_of
from ..replay.input_levels import recorded_levels
from ..replay.replaying import recorded_stimuli
from ..run.playback import Stimulus
from ..trust.attachments import job_of
from .folder_lock import write_text
from .scenarios.ordered import with_orders
from .scenarios.rackdoc import bare_rack_text
from .scenarios.scenario import Press, Scenario

SCENARIO = "scenario.json"


class LearnedScenario(NamedTuple):
    """A scenario from a trace, and its rack."""

    rack: Path  # path of a rack file without timed events
    scenario: Scenario  # the timed events
    scans: int
    notes: list[str]  # sentences about defects of the trace


def _stimuli(recording: PackedTrace, spec: RackSpec) -> Iterator[Stimulus]:
    """Yield the input changes in time order. For real hardware, they are derived from status bits."""
    live = {slot.number for slot in spec.slot if slot.is_live}
    recorded = [stimulus for stimulus in recorded_stimuli(recording) if stimulus.slot not in live]
    derived = [stimulus for stimulus in recorded_levels(recording) if stimulus.slot in live]
    yield from sorted([*recorded, *derived], key=lambda stimulus: stimulus.at_ns)


def scenario_of(path: Path, spec: RackSpec) -> Scenario:
    """Return the stimuli of a recording or a `watch` session as a scenario for any rack.

    This does not use the files in the trace, so the trace does not have to be trusted. The scenario does not
    include the injected faults in the rack file.

    Raises:
        ValueError: the trace can't be read, or its events do not fit the rack.
        OSError: the trace can't be read.
    """
    bare = spec.model_copy(update={"incident": ()})
    with open_trace(path) as trace:
        scenario = _scenario_in(trace, PackedTrace.of(trace), bare)
    scenario.check(spec)
    return scenario


def _scenario_in(trace: Trace, recording: PackedTrace, spec: RackSpec) -> Scenario:
    """Return the stimuli of a trace and the orders of a session as a scenario for a rack."""
    orders = orders_of(trace.events()) if is_session(trace) else []
    end_ns = recording.times[-1] + spec.scan_ns
    return with_orders(recorded_scenario(_stimuli(recording, spec), spec, end_ns), orders, spec, end_ns)


def learn(path: Path, folder: Path, *, trust: bool) -> LearnedScenario:
    """Extract the rack file and program of a trace, and a scenario with its stimuli.

    A controller on a real port is replaced by a simulated one. Its inputs change when their recorded status
    bits change. The files of the trace, `NAME-recorded.toml` and `scenario.json` are written to the folder.

    Raises:
        ValueError: the trace can't be read, or has no TOML rack file.
        OSError: a file can't be written.
    """
    with open_trace(path) as trace:
        recording = PackedTrace.of(trace)
        job = job_of(trace, folder, trust=trust)
        program = folder / trace.head.metadata["program_file"]
        if job.rack_file.suffix != ".toml":
            raise ValueError(f"{path}: the rack file is {job.rack_file.name}; it must be a TOML file")
        scenario = _scenario_in(trace, recording, job.spec)
    rack = job.rack_file.with_name(f"{job.rack_file.stem}-recorded.toml")
    text = bare_rack_text(job.rack_file, relative(program, rack.parent))
    write_text(rack, text, {path: "the trace itself"})
    write_text(folder / SCENARIO, json.dumps(scenario.to_json(), indent=1) + "\n", {path: "the trace itself"})
    return LearnedScenario(rack, scenario, len(recording.scans), trace.notes)


def recorded_scenario(stimuli: Iterable[Stimulus], spec: RackSpec, end_ns: int) -> Scenario:
    """Return the scenario of a recording.

    Signals of stations are left out, since the machine produces them again. Injected faults are taken from
    the rack file, which has their exact values.
    """
    machines = {slot.number: slot.machine for slot in spec.slot}
    station_inputs = {(slot.number, station.input) for slot in spec.slot for station in slot.machine.stations}
    stimuli_by_input: dict[tuple[int, InputBit], list[Stimulus]] = defaultdict(list)
    for stimulus in stimuli:
        if stimulus.slot in machines and (stimulus.slot, stimulus.input) not in station_inputs:
            stimuli_by_input[stimulus.slot, stimulus.input].append(stimulus)
    presses: list[Press] = []
    for (slot, _), input_stimuli in stimuli_by_input.items():
        presses += _presses(input_stimuli, machines[slot], end_ns)
    presses.sort(key=lambda press: (press.at_ns, press.slot, press.input.value))
    return Scenario(presses=tuple(presses), incidents=spec.incidents)


def _presses(stimuli: Sequence[Stimulus], machine: MachineSpec, end_ns: int) -> Iterator[Press]:
    """Yield the presses of one input. Each level lasts until the next. A released button is not a press."""
    end_times_ns = [stimulus.at_ns for stimulus in stimuli[1:]] + [end_ns]
    for stimulus, until_ns in zip(stimuli, end_times_ns, strict=True):
        is_fed = machine.fed_inputs & stimulus.input.value
        is_press = stimulus.energized or (is_fed and stimulus.energized is False)
        if is_press and until_ns > stimulus.at_ns:
            for_ns = until_ns - stimulus.at_ns
            yield Press(stimulus.slot, stimulus.input, bool(stimulus.energized), stimulus.at_ns, for_ns)
