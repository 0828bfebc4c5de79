"""A recording as a scenario: the actions on its inputs, in parts that can be left out, moved and added to."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence

from ....io_images.amci3601.bits import InputBit
from ....runtime.config.rackspec import RackSpec
from ....runtime.machine import MachineSpec
from ...run.playback import Stimulus
from .scenario import Press, Scenario


def recorded_scenario(stimuli: Iterable[Stimulus], spec: RackSpec, end_ns: int) -> Scenario:
    """Return the scenario of a recording.

    Signals of stations are left out, since the machine makes them again. Incidents of modules and
    CPU come from the rack, which has them exactly.
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
    """Yield the actions on one input: each level lasts until the next; a released button is none."""
    ends = [each.at_ns for each in stimuli[1:]] + [end_ns]
    for each, until_ns in zip(stimuli, ends, strict=True):
        fed = machines[each.slot].fed_inputs & each.input.value
        if (each.energised or (fed and each.energised is False)) and until_ns > each.at_ns:
            yield Press(each.slot, each.input, each.energised, each.at_ns, until_ns - each.at_ns)
