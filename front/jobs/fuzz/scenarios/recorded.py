"""A recording as a scenario: what acted on the inputs, in parts to be left out, moved and added to."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence

from ....io_images.amci3601.bits import InputBit
from ....runtime.config.rackspec import RackSpec
from ....runtime.machine import MachineSpec
from ...run.playback import Stimulus
from .scenario import Press, Scenario


def recorded_scenario(stimuli: Iterable[Stimulus], spec: RackSpec, end_ns: int) -> Scenario:
    """Return the scenario that a recording shows.

    Signals of stations are left out, since the machine makes them again. What happened to modules and
    CPU is taken from the rack, which has it exactly.
    """
    machines = {slot.number: slot.machine for slot in spec.slot}
    made_again = {(slot.number, each.input) for slot in spec.slot for each in slot.machine.stations}
    by_input: dict[tuple[int, InputBit], list[Stimulus]] = defaultdict(list)
    for each in stimuli:
        if each.slot in machines and (each.slot, each.input) not in made_again:
            by_input[each.slot, each.input].append(each)
    presses = [press for found in by_input.values() for press in _presses(found, machines, end_ns)]
    presses.sort(key=lambda press: (press.at_ns, press.slot, press.input.value))
    return Scenario(presses=tuple(presses), incidents=spec.incidents)


def _presses(stimuli: Sequence[Stimulus], machines: dict[int, MachineSpec], end_ns: int) -> Iterator[Press]:
    """Yield what was done to one input: each level lasts until the next; a button that is out is nothing."""
    ends = [each.at_ns for each in stimuli[1:]] + [end_ns]
    for each, until_ns in zip(stimuli, ends, strict=True):
        fed = machines[each.slot].fed_inputs & each.input.value
        if (each.energised or (fed and each.energised is False)) and until_ns > each.at_ns:
            yield Press(each.slot, each.input, each.energised, each.at_ns, until_ns - each.at_ns)
