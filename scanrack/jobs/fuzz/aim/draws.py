"""Draws parts of scenarios at random, in any scan or near the edges of a run.

    50 % of the events    near an edge of the varied run
    30 %                  soon after the previous event, on a logarithmic scale
    20 %                  anywhere

In addition, 15 % of the events begin at about the same time as another event, and 25 % of the durations end
near an edge. Some durations and distances are times from the program. Some buttons are pressed several times
in a rhythm.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from random import Random
from typing import Any

from scanrack.io_images.amci3601.firmware import KNOWN, Firmware
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.live.actions import Write
from scanrack.runtime.loop.incidents import FaultKind, InjectedFault
from scanrack.runtime.modules.record import Trait

from ..scenarios.kinds import Kind, card_signals, masters, possible_kinds, with_trait
from ..scenarios.panel import PanelTag
from ..scenarios.parts import Lasting, Timed, parts_of, scenario_of, timed_parts, with_part
from ..scenarios.scenario import (
    ContactPress,
    LostSteps,
    OperatorAction,
    Scenario,
    Signal,
    SwitchOffset,
    TornUpdate,
    Turn,
)
from ..scenarios.tearing import Rung
from .contacts import Contact, Contacts
from .edges import INPUTS, NEAR, NO_EDGES, Edges
from .times import MS

MOST = 7
"""Maximum number of parts of an entirely random scenario."""

MOST_JOINED = 4
"""Maximum number of events from another scenario."""

LASTING_MS = (2, 4, 10, 20, 40, 100, 500, 2000)
"""Durations of events, ms."""

STEPS = (1, -1, 10, -10, 200, -200, 3000, -3000)
"""Displacements of a machine, steps."""

MOVED = (0, 1, -1, 10, -10, 100, -100)
"""Time shifts of an event of the varied scenario, scans."""

TOGETHER = 0.15
"""Share of events that begin at about the same time as another event."""

AT_EDGES, SOON = 0.5, 0.8
"""Share of the other events near an edge; that share plus the share soon after an event."""

AGAIN = 0.4
"""Share of events that repeat an earlier press of their scenario."""

END_AT_EDGES, TO_THE_END = 0.25, 0.06
"""Share of durations that end near an edge; share of the others that last until the end of the run."""

BEFORE_INPUTS = 0.75
"""Share of tears just before a change in the inputs."""

RHYTHM = 0.12
"""Share of rhythms among the events."""

BY_TIMES = 0.3
"""Share of durations and distances that are times of the program."""

AFTER_END = 0.5
"""Share of events timed from the end of the previous event instead of its beginning."""

NARROW, FEW = 0.7, (1, 1, 2, 3)
"""Share of scenarios with few kinds of events or few contacts, and the possible numbers."""

AT_CHANGES = 0.8
"""Share of torn updates in scans that change several output words. Some of these words are late."""

BEATS = (2, 3, 3, 4, 4, 5, 6, 8)
"""Numbers of presses in a rhythm."""

BEAT_MS = (6, 10, 20, 40, 100, 200, 400)
"""Durations of presses and pauses in a rhythm, ms."""

AROUND = (-1, 0, 1, 1, 2, 3, 5, 10)
"""Numbers of scans to add to a time of the program."""

PARTS_OF_SPEED, WAYS = (1.0, 1.0, 0.5, 0.1, 0.01), (1, 1, 1, -1)
"""Speeds of a master encoder as fractions of its maximum, and its directions."""

LINKS = (FaultKind.LINK_LOST, FaultKind.REMOVED, FaultKind.FATAL_ERROR)
REPLIES = (FaultKind.REPLIES_LOST, FaultKind.REPLIES_DAMAGED)

MakePart = Callable[[int, Edges], Timed]
"""Makes a part that begins in a given scan."""


@dataclass(frozen=True, slots=True)
class _RackParts:
    """The slots and inputs that events can act on.

    Attributes:
        axes: slots with a machine; all slots if no slot has a machine.
        answering: slots that can stop answering.
        outputs: number of output words by slot.
        lines: slots with a serial line.
        slipping: slots that can lose steps.
        signals: slot, name and test value of each analog card input.
        masters: slot and maximum speed of each master encoder, counts/s.
    """

    axes: Sequence[int]
    answering: Sequence[int]
    outputs: Mapping[int, int]
    lines: Sequence[int]
    slipping: Sequence[int]
    signals: Sequence[tuple[int, str, float]]
    masters: Sequence[tuple[int, int]]

    @classmethod
    def of(cls, spec: RackSpec) -> _RackParts:
        """Return the parts of a rack."""
        axes = [slot.number for slot in spec.slot if slot.has(Trait.MACHINE)]
        return cls(
            axes=axes or [slot.number for slot in spec.slot],
            answering=with_trait(spec, Trait.STOPS_ANSWERING),
            outputs={slot.number: len(slot.words.outputs) for slot in spec.slot},
            lines=with_trait(spec, Trait.LINE),
            slipping=with_trait(spec, Trait.SLIPS),
            signals=card_signals(spec),
            masters=masters(spec),
        )


class Draws:
    """Draws scenarios for a rack.

    Args:
        scans: length of a run.
        kinds: kinds of random events. Impossible kinds are ignored.
        random: random generator. The same seed draws the same scenarios.
        rungs: rungs before which inputs can change within a scan, see `scenarios.tearing`.
        settings: tags that an operator writes, with values to try.

    Attributes:
        times: times of the program, ns.
    """

    def __init__(
        self,
        spec: RackSpec,
        scans: int,
        kinds: Collection[Kind],
        random: Random,
        rungs: Sequence[Rung] = (),
        settings: Sequence[PanelTag] = (),
    ) -> None:
        self.scans, self.scan_ns = scans, spec.scan_ns
        self.times: tuple[int, ...] = ()
        self._spec, self._rack = spec, _RackParts.of(spec)
        self._kinds = possible_kinds(spec).intersection(kinds)
        self.contacts = Contacts(spec, self._kinds)
        self._rungs, self._settings = rungs, settings
        self._random = random
        self._events = self._all_events  # kinds of events of the current scenario, see `narrow`

    @cached_property
    def _all_events(self) -> list[MakePart]:
        """Functions that draw the possible events, each repeated by its weight."""
        rack, has_rungs = self._rack, len(self._rungs) > 1
        # weight, kind, whether the rack has anything to act on (by its truth), and the function
        rows: tuple[tuple[int, Kind, object, MakePart], ...] = (
            (6, Kind.INPUTS, self.contacts, self._press),
            (2, Kind.INPUTS, rack.signals, self._signal),
            (3, Kind.INPUTS, self._settings, self._setting),
            (4, Kind.MACHINE, rack.masters, self._turn),
            (2, Kind.LINK, True, self._link),
            (1, Kind.POWER, True, self._power),
            (1, Kind.MODE, True, self._mode),
            (1, Kind.TORN, True, self._torn),
            (3, Kind.TORN, has_rungs, self._tear),
            (2, Kind.LINE, True, self._line),
        )
        possible = [(weight, make) for weight, kind, has_any, make in rows if has_any and kind in self._kinds]
        return [make for weight, make in possible for _ in range(weight)]

    @cached_property
    def _conditions(self) -> list[Callable[[Scenario], Scenario]]:
        """Functions that add the possible conditions of a whole run to a scenario."""
        possible: list[Callable[[Scenario], Scenario]] = []
        if Kind.FIRMWARE in self._kinds and (versions := self._firmware_versions()):
            possible.append(partial(self._with_firmware, versions))
        if Kind.MACHINE in self._kinds:
            possible.append(self._with_switch_offset)
        if Kind.MACHINE in self._kinds and self._rack.slipping:
            possible.append(self._with_lost_steps)
        return possible

    def scenario(self, edges: Edges = NO_EDGES, base: Scenario | None = None) -> Scenario:
        """Return a random scenario with up to seven parts, or a base scenario with up to seven more parts."""
        scenario = Scenario() if base is None else self._varied(base)
        self.narrow()
        from_scan = 0
        min_parts = 1 if base is None else 0
        max_parts = self._random.choice((2, 4, MOST))
        for _ in range(self._random.randint(min_parts, max_parts)):
            scenario, from_scan = self.with_one_more(scenario, edges, from_scan)
        return scenario

    @property
    def has_events(self) -> bool:
        """Whether timed events can be drawn for the rack."""
        return bool(self._all_events)

    def event(self, scan: int) -> Timed | None:
        """Return a random event in a scan; None if no timed event can be drawn."""
        return self._random.choice(self._all_events)(scan, NO_EDGES) if self._all_events else None

    def narrow(self) -> None:
        """Limit most scenarios to few kinds of events. Many kinds would hide the effect of a single one."""
        random, all_events = self._random, self._all_events
        self._events = all_events
        if all_events and random.random() < NARROW:
            self._events = random.choices(all_events, k=random.choice(FEW))
        self.contacts.narrow(random, random.choice(FEW) if random.random() < NARROW else 0)

    def with_one_more(self, scenario: Scenario, edges: Edges, from_scan: int = 0) -> tuple[Scenario, int]:
        """Return a scenario with one more part, and the preferred earliest scan of the next part.

        Args:
            from_scan: preferred earliest scan of this part.
        """
        random = self._random
        if self._conditions and (not self._events or random.random() < len(self._conditions) * 0.035):
            add_condition = random.choice(self._conditions)
            return add_condition(scenario), from_scan
        if not self._events:
            return scenario, from_scan
        scan = self._choose_scan(scenario, edges, from_scan)
        if self._press in self._events and random.random() < RHYTHM:
            return self._with_rhythm(scenario, scan)
        part = self._next_part(scenario, scan, edges)
        end_scan = scan + getattr(part, "for_ns", 0) // self.scan_ns
        after_end = end_scan < self.scans and random.random() < AFTER_END
        return with_part(scenario, part), end_scan if after_end else scan

    def _next_part(self, scenario: Scenario, scan: int, edges: Edges) -> Timed:
        """Return a new event in a scan, or an earlier press repeated in this scan."""
        presses: tuple[Contact, ...] = (*scenario.presses, *scenario.pushes)
        if presses and self._random.random() < AGAIN:
            return self._pressed_again(self._random.choice(presses), scan)
        make_part = self._random.choice(self._events)
        return make_part(scan, edges)

    def _pressed_again(self, press: Contact, scan: int) -> Contact:
        """Return the same press in a different scan, on a random axis."""
        at_ns = scan * self.scan_ns
        if isinstance(press, ContactPress):
            return replace(press, at_ns=at_ns)
        return replace(press, at_ns=at_ns, slot=self._random.choice(self._rack.axes))

    def _with_rhythm(self, scenario: Scenario, scan: int) -> tuple[Scenario, int]:
        """Return a scenario with equally spaced presses of one or two contacts, and the last press's scan."""
        random = self._random
        contacts = [self.contacts.draw(random) for _ in range(random.choice((1, 1, 2)))]
        for_ns, pause_ns = self._beat_ns(), self._beat_ns()
        at_ns = scan * self.scan_ns
        for number in range(random.choice(BEATS)):
            if at_ns < self.scans * self.scan_ns:
                press = replace(contacts[number % len(contacts)], at_ns=at_ns, for_ns=for_ns)
                scenario = with_part(scenario, press)
                scan = at_ns // self.scan_ns
                at_ns += for_ns + pause_ns
        return scenario, scan

    def _beat_ns(self) -> int:
        """Return a random duration of a press or pause in a rhythm, ns."""
        if self.times and self._random.random() < 0.5:
            return self._program_time_ns()
        return self._random.choice(BEAT_MS) * MS

    def _program_time_ns(self) -> int:
        """Return a random time of the program, up to 1 scan shorter or 10 scans longer, ns."""
        return self._random.choice(self.times) + self._random.choice(AROUND) * self.scan_ns

    def with_one_moved(self, scenario: Scenario, edges: Edges) -> Scenario:
        """Return a scenario with one event moved near an edge, or by a number of scans."""
        random = self._random

        def moved(part: Timed) -> Timed:
            """Return the part in another scan of the run."""
            if random.random() < 0.5:
                scan = self._random_scan(edges, 0)
            else:
                scan = part.at_ns // self.scan_ns + random.choice((*NEAR, *MOVED, 30, 300))
            return replace(part, at_ns=min(max(scan, 0), self.scans - 1) * self.scan_ns)

        return self._with_change(scenario, moved, edges)

    def with_one_longer(self, scenario: Scenario, edges: Edges) -> Scenario:
        """Return a scenario with a different duration for a random event, if the event has a duration."""
        random = self._random

        def longer(part: Timed) -> Timed:
            """Return the part with a random duration, or with two or four times its duration."""
            if not isinstance(part, Lasting) or not part.for_ns:
                return part
            for_ns = part.for_ns * random.choice((2, 4))
            if random.random() >= 0.4:
                for_ns = self._duration_ns(part.at_ns // self.scan_ns, edges)
            return replace(part, for_ns=min(for_ns, self.scans * self.scan_ns))

        return self._with_change(scenario, longer, edges)

    def with_one_less(self, scenario: Scenario) -> Scenario:
        """Return a scenario without one of its parts."""
        parts = parts_of(scenario)
        if parts:
            parts.pop(self._random.randrange(len(parts)))
        return scenario_of(parts)

    def joined(self, scenario: Scenario, other: Scenario) -> Scenario:
        """Return a scenario with the first events of another scenario added."""
        for part in timed_parts(other)[:MOST_JOINED]:
            scenario = with_part(scenario, part)
        return scenario

    def _with_change(self, scenario: Scenario, change: Callable[[Timed], Timed], edges: Edges) -> Scenario:
        """Return a scenario with one random event changed. If it has no events, add a part."""
        parts = parts_of(scenario)
        timed_indices = [index for index, (_, part) in enumerate(parts) if isinstance(part, Timed)]
        if not timed_indices:
            return self.with_one_more(scenario, edges)[0]
        index = self._random.choice(timed_indices)
        name, part = parts[index]
        parts[index] = name, change(part)
        return scenario_of(parts)

    def _varied(self, base: Scenario) -> Scenario:
        """Return a base scenario unchanged, or about half of its parts at about the same times."""
        random = self._random
        if random.random() < 0.5:
            return base
        return scenario_of(
            (field, self._shifted_in_time(part)) for field, part in parts_of(base) if random.random() < 0.5
        )

    def _shifted_in_time(self, part: Any) -> Any:
        if not isinstance(part, Timed):
            return part
        return replace(part, at_ns=max(0, part.at_ns + self._random.choice(MOVED) * self.scan_ns))

    def _choose_scan(self, scenario: Scenario, edges: Edges, from_scan: int) -> int:
        """Return a scan within the run for a new event."""
        random = self._random
        others = timed_parts(scenario)
        if others and random.random() < TOGETHER:
            scan = random.choice(others).at_ns // self.scan_ns + random.choice((0, 0, 0, 1, -1))
        else:
            scan = self._random_scan(edges, from_scan)
        return min(max(scan, 0), self.scans - 1)

    def _random_scan(self, edges: Edges, from_scan: int) -> int:
        """Return a random scan near an edge, soon after `from_scan` or anywhere, even outside the run."""
        random, scans = self._random, self.scans
        draw = random.random()
        if draw < AT_EDGES and (edge_scan := edges.near(random, from_scan)) is not None:
            return edge_scan
        if from_scan and draw < SOON:
            if self.times and random.random() < BY_TIMES:
                return from_scan + self._program_time_ns() // self.scan_ns
            return from_scan + int((scans - from_scan) ** random.random())
        return random.randint(0, scans - 1)

    def _duration_ns(self, scan: int, edges: Edges) -> int:
        """Return a random duration for an event that begins in a scan, ns."""
        random = self._random
        if random.random() < END_AT_EDGES:
            end_scan = edges.near(random, scan)
            if end_scan is not None and end_scan > scan:
                return (end_scan - scan) * self.scan_ns
        if random.random() < TO_THE_END:
            return (self.scans - scan) * self.scan_ns
        if self.times and random.random() < BY_TIMES:
            return self._program_time_ns()
        return random.choice(LASTING_MS) * MS

    def _press(self, scan: int, edges: Edges) -> Contact:
        contact = self.contacts.draw(self._random)
        return replace(contact, at_ns=scan * self.scan_ns, for_ns=self._duration_ns(scan, edges))

    def _signal(self, scan: int, edges: Edges) -> Signal:
        slot, name, value = self._random.choice(self._rack.signals)
        return Signal(slot, name, value, scan * self.scan_ns, self._duration_ns(scan, edges))

    def _setting(self, scan: int, _edges: Edges) -> OperatorAction:
        setting = self._random.choice(self._settings)
        return OperatorAction(scan * self.scan_ns, Write(setting.tag, self._random.choice(setting.values)))

    def _turn(self, scan: int, edges: Edges) -> Turn:
        """Return a movement of a master encoder at a fraction of its maximum speed, in either direction."""
        slot, speed = self._random.choice(self._rack.masters)
        for_ns = max(MS, self._duration_ns(scan, edges))
        counts = max(1, round(speed * self._random.choice(PARTS_OF_SPEED) * for_ns / 1e9))
        return Turn(slot, counts * self._random.choice(WAYS), scan * self.scan_ns, for_ns)

    def _link(self, scan: int, edges: Edges) -> InjectedFault:
        fault_kind, slot = self._random.choice(LINKS), self._random.choice(self._rack.answering)
        return InjectedFault(scan * self.scan_ns, fault_kind, slot, self._duration_ns(scan, edges))

    def _power(self, scan: int, _edges: Edges) -> InjectedFault:
        slot = self._random.choice([slot.number for slot in self._spec.slot])
        return InjectedFault(scan * self.scan_ns, FaultKind.POWER_CYCLE, slot)

    def _mode(self, scan: int, edges: Edges) -> InjectedFault:
        return InjectedFault(scan * self.scan_ns, FaultKind.PROGRAM_MODE, 0, self._duration_ns(scan, edges))

    def _torn(self, scan: int, edges: Edges) -> InjectedFault:
        """Return a torn update, mostly in a scan that changes several words; elsewhere it has no effect."""
        random = self._random
        slots = [slot.number for slot in self._spec.slot]
        if random.random() < AT_CHANGES and (output_change := edges.output(random)) is not None:
            slot_index, changed_words, change_scan = output_change
            slot = slots[slot_index]
            scan = min(max(change_scan + random.choice((0, 0, 0, 1, -1)), 0), self.scans - 1)
            late_words = random.sample(changed_words, random.randint(1, len(changed_words) - 1))
        else:
            slot = random.choice(slots)
            outputs = range(self._rack.outputs[slot])
            late_words = random.sample(outputs, random.randint(1, max(1, len(outputs) // 2)))
        return InjectedFault(scan * self.scan_ns, FaultKind.TORN_UPDATE, slot, 0, tuple(sorted(late_words)))

    def _tear(self, scan: int, edges: Edges) -> TornUpdate:
        """Return a tear, mostly in the scan before a change in the inputs."""
        random = self._random
        if random.random() < BEFORE_INPUTS and (input_scan := edges.one_of(random, INPUTS)):
            scan = input_scan - 1
        routine, rung = random.choice(self._rungs[1:])  # before the first rung, inputs are only late
        return TornUpdate(routine, rung, scan * self.scan_ns)

    def _line(self, scan: int, edges: Edges) -> InjectedFault:
        """Return one bad reply, an open line or bad replies for a time, or a controller's power failure."""
        random, at_ns, slot = self._random, scan * self.scan_ns, self._random.choice(self._rack.lines)
        choice = random.randint(0, 2)
        if choice == 0:
            return InjectedFault(at_ns, random.choice(REPLIES), slot)
        if choice == 1:
            fault_kind = random.choice((FaultKind.LINE_DOWN, *REPLIES))
            return InjectedFault(at_ns, fault_kind, slot, self._duration_ns(scan, edges))
        return InjectedFault(at_ns, FaultKind.CONTROLLER_POWER_CYCLE, slot)

    def _firmware_versions(self) -> list[str]:
        """Return the firmware versions that the program supports."""
        on_micrologix = self._spec.controller == "micrologix"
        needed = max(Firmware.parse(slot.needs_firmware) for slot in self._spec.slot)
        return [
            str(version)
            for version in KNOWN
            if version >= needed and (version.micrologix or not on_micrologix)
        ]

    def _with_firmware(self, versions: list[str], scenario: Scenario) -> Scenario:
        version = self._random.choice(versions)
        slots = with_trait(self._spec, Trait.FIRMWARE)
        return replace(scenario, firmware=tuple((slot, version) for slot in slots))

    def _with_switch_offset(self, scenario: Scenario) -> Scenario:
        shift = SwitchOffset(self._random.choice(self._rack.axes), self._random.choice(STEPS))
        return replace(scenario, shifts=(shift,))

    def _with_lost_steps(self, scenario: Scenario) -> Scenario:
        """Return a scenario where an axis loses steps, half of the time at a position near the start."""
        random = self._random
        begin, end = (-20_000, 20_000) if random.random() < 0.5 else (-2_000, 4_000)
        position = random.randint(begin, end)
        lost_steps: Any = LostSteps(random.choice(self._rack.slipping), position, random.choice((1, 5, 200)))
        return replace(scenario, lost=(lost_steps,))
