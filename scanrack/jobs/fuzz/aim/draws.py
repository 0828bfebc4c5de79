"""Draws parts of scenarios at random, in any scan or near the edges of a run.

    half of the times     near an edge of the varied run
    a third               soon after the previous event, on a logarithmic scale
    the rest              anywhere

One event in seven begins at the same time as another one, and a quarter of the durations end near an edge.
Some durations and distances are times from the program. Buttons are also pressed several times in a rhythm.
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
"""Largest number of parts of a scenario that begins from nothing."""

MOST_JOINED = 4
"""Largest number of events taken from another scenario."""

LASTING_MS = (2, 4, 10, 20, 40, 100, 500, 2000)
"""Durations of events, ms."""

STEPS = (1, -1, 10, -10, 200, -200, 3000, -3000)
"""Displacements of a machine, steps."""

MOVED = (0, 1, -1, 10, -10, 100, -100)
"""Time shifts of an event of the varied scenario, scans."""

AT_EDGES, SOON, TOGETHER, AGAIN, END_AT_EDGES, TO_THE_END = 0.5, 0.8, 0.15, 0.4, 0.25, 0.06
"""Shares of the draws: see the module; `SOON` includes `AT_EDGES`. `AGAIN` repeats an earlier press."""

BEFORE_INPUTS = 0.75
"""Share of the tears that fall before a change of the inputs."""

RHYTHM, BY_TIMES, AFTER_END = 0.12, 0.3, 0.5
"""Shares of rhythms among events, of the program's times among durations and distances, and of events that
begin after the end of the previous one."""

NARROW, FEW = 0.7, (1, 1, 2, 3)
"""Share of the scenarios with few kinds of events or few contacts, and how many they have."""

AT_CHANGES = 0.8
"""Share of the torn updates in scans where several output words change: some of these words come late."""

BEATS = (2, 3, 3, 4, 4, 5, 6, 8)
"""Numbers of presses in a rhythm."""

BEAT_MS = (6, 10, 20, 40, 100, 200, 400)
"""Durations and distances of the presses of a rhythm, ms."""

AROUND = (-1, 0, 1, 1, 2, 3, 5, 10)
"""Scans that are added to a time of the program."""

PARTS_OF_SPEED, WAYS = (1.0, 1.0, 0.5, 0.1, 0.01), (1, 1, 1, -1)
"""Speeds of a master encoder, as fractions of its maximum, and its directions."""

LINKS = (FaultKind.LINK_LOST, FaultKind.REMOVED, FaultKind.FATAL_ERROR)
REPLIES = (FaultKind.REPLIES_LOST, FaultKind.REPLIES_DAMAGED)

Make = Callable[[int, Edges], Timed]
"""Makes a part that begins in a scan."""


@dataclass(frozen=True, slots=True)
class _RackParts:
    """The slots and inputs that events can act on.

    Attributes:
        axes: slots with a machine, all slots if none has one.
        answering: slots that can stop answering.
        outputs: number of output words by slot.
        lines: slots with a serial line.
        slipping: slots that can lose steps.
        signals: slot, name and test value of card inputs.
        masters: slot and maximum speed of master encoders.
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
        scans: length of a run, including all events.
        kinds: kinds of random events; impossible ones are ignored.
        random: random generator; the same seed draws the same scenarios.
        rungs: rungs before which inputs may change within a scan, see `scenarios.tearing`.
        settings: tags that an operator writes, with values to try.
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
        self.times: tuple[int, ...] = ()  # times from the program, ns
        self._spec, self._rack = spec, _RackParts.of(spec)
        self._kinds = possible_kinds(spec).intersection(kinds)
        self.contacts = Contacts(spec, self._kinds)
        self._rungs, self._settings = rungs, settings
        self._random = random
        self._events = self._all_events  # kinds of events of the current scenario, see `narrow`

    @cached_property
    def _all_events(self) -> list[Make]:
        """The possible events, each repeated as many times as its weight."""
        rack, has_rungs = self._rack, len(self._rungs) > 1
        rows: tuple[tuple[int, Kind, object, Make], ...] = (
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
        """The possible conditions of a whole run, as functions that add one to a scenario."""
        possible: list[Callable[[Scenario], Scenario]] = []
        if Kind.FIRMWARE in self._kinds and (versions := self._versions()):
            possible.append(partial(self._other_firmware, versions))
        if Kind.MACHINE in self._kinds:
            possible.append(self._shifted)
        if Kind.MACHINE in self._kinds and self._rack.slipping:
            possible.append(self._slipped)
        return possible

    def scenario(self, edges: Edges = NO_EDGES, base: Scenario | None = None) -> Scenario:
        """Return a scenario of up to seven parts, or a variant of another one."""
        drawn, first = Scenario() if base is None else self._varied(base), 0
        self.narrow()
        least = 1 if base is None else 0
        most = self._random.choice((2, 4, MOST))
        for _ in range(self._random.randint(least, most)):
            drawn, first = self.with_one_more(drawn, edges, first)
        return drawn

    @property
    def has_events(self) -> bool:
        """Whether the rack has timed events to draw."""
        return bool(self._all_events)

    def event(self, at: int) -> Timed | None:
        """Return an event that begins in a scan; None if no timed event can be drawn."""
        return self._random.choice(self._all_events)(at, NO_EDGES) if self._all_events else None

    def narrow(self) -> None:
        """Limit most scenarios to few kinds of events: many kinds hide the effect of a single one."""
        random, all_events = self._random, self._all_events
        self._events = all_events
        if all_events and random.random() < NARROW:
            self._events = random.choices(all_events, k=random.choice(FEW))
        self.contacts.narrow(random, random.choice(FEW) if random.random() < NARROW else 0)

    def with_one_more(self, scenario: Scenario, edges: Edges, first: int = 0) -> tuple[Scenario, int]:
        """Return a scenario with one more part, and a scan in which the next part may begin.

        Args:
            first: preferred earliest scan of the part.
        """
        random = self._random
        if self._conditions and (not self._events or random.random() < len(self._conditions) * 0.035):
            return random.choice(self._conditions)(scenario), first
        if not self._events:
            return scenario, first
        scan = self._when(scenario, edges, first)
        if self._press in self._events and random.random() < RHYTHM:
            return self._with_rhythm(scenario, scan)
        part = self._next_part(scenario, scan, edges)
        end = scan + getattr(part, "for_ns", 0) // self.scan_ns
        after_end = end < self.scans and random.random() < AFTER_END
        return with_part(scenario, part), end if after_end else scan

    def _next_part(self, scenario: Scenario, at: int, edges: Edges) -> Timed:
        """Return a new event that begins in a scan, or repeat an earlier press there."""
        pressed: tuple[Contact, ...] = (*scenario.presses, *scenario.pushes)
        if pressed and self._random.random() < AGAIN:
            return self._pressed_again(self._random.choice(pressed), at)
        return self._random.choice(self._events)(at, edges)

    def _pressed_again(self, part: Contact, at: int) -> Contact:
        """Return the same press in another scan, on any axis that has this input."""
        at_ns = at * self.scan_ns
        if isinstance(part, ContactPress):
            return replace(part, at_ns=at_ns)
        return replace(part, at_ns=at_ns, slot=self._random.choice(self._rack.axes))

    def _with_rhythm(self, scenario: Scenario, at: int) -> tuple[Scenario, int]:
        """Return a scenario with a rhythm: equal presses, equally spaced, of one button or two in turn."""
        random = self._random
        turns = [self.contacts.draw(random) for _ in range(random.choice((1, 1, 2)))]
        for_ns, pause_ns = self._beat(), self._beat()
        at_ns = at * self.scan_ns
        for number in range(random.choice(BEATS)):
            if at_ns < self.scans * self.scan_ns:
                scenario = with_part(
                    scenario, replace(turns[number % len(turns)], at_ns=at_ns, for_ns=for_ns)
                )
                at = at_ns // self.scan_ns
                at_ns += for_ns + pause_ns
        return scenario, at

    def _beat(self) -> int:
        if self.times and self._random.random() < 0.5:
            return self._own_time()
        return self._random.choice(BEAT_MS) * MS

    def _own_time(self) -> int:
        """Return a time from the program, or a little more, ns."""
        return self._random.choice(self.times) + self._random.choice(AROUND) * self.scan_ns

    def with_one_moved(self, scenario: Scenario, edges: Edges) -> Scenario:
        """Return a scenario with one event moved: near an edge, or by a few scans."""
        random = self._random

        def moved(part: Timed) -> Timed:
            if random.random() < 0.5:
                scan = self._scan(edges, 0)
            else:
                scan = part.at_ns // self.scan_ns + random.choice((*NEAR, *MOVED, 30, 300))
            return replace(part, at_ns=min(max(scan, 0), self.scans - 1) * self.scan_ns)

        return self._with_one_changed(scenario, moved, edges)

    def with_one_longer(self, scenario: Scenario, edges: Edges) -> Scenario:
        """Return a scenario with the duration of one event changed, if an event has a duration."""
        random = self._random

        def longer(part: Timed) -> Timed:
            if not isinstance(part, Lasting) or not part.for_ns:
                return part
            times = part.for_ns * random.choice((2, 4))
            for_ns = times if random.random() < 0.4 else self._lasting(part.at_ns // self.scan_ns, edges)
            return replace(part, for_ns=min(for_ns, self.scans * self.scan_ns))

        return self._with_one_changed(scenario, longer, edges)

    def with_one_less(self, scenario: Scenario) -> Scenario:
        """Return a scenario without one of its parts."""
        parts = parts_of(scenario)
        if parts:
            parts.pop(self._random.randrange(len(parts)))
        return scenario_of(parts)

    def joined(self, scenario: Scenario, other: Scenario) -> Scenario:
        """Return a scenario with the first events of another one added."""
        for part in timed_parts(other)[:MOST_JOINED]:
            scenario = with_part(scenario, part)
        return scenario

    def _with_one_changed(
        self, scenario: Scenario, change: Callable[[Timed], Timed], edges: Edges
    ) -> Scenario:
        """Return a scenario with one event changed, or with a new event if it has none."""
        parts = parts_of(scenario)
        places = [place for place, (_, part) in enumerate(parts) if isinstance(part, Timed)]
        if not places:
            return self.with_one_more(scenario, edges)[0]
        place = self._random.choice(places)
        name, part = parts[place]
        parts[place] = name, change(part)
        return scenario_of(parts)

    def _varied(self, base: Scenario) -> Scenario:
        """Return a scenario unchanged, or with some of its parts at other times."""
        random = self._random
        if random.random() < 0.5:
            return base
        return scenario_of(
            (field, self._moved(part)) for field, part in parts_of(base) if random.random() < 0.5
        )

    def _moved(self, part: Any) -> Any:
        if not isinstance(part, Timed):
            return part
        return replace(part, at_ns=max(0, part.at_ns + self._random.choice(MOVED) * self.scan_ns))

    def _when(self, scenario: Scenario, edges: Edges, first: int) -> int:
        """Return a scan for a new event."""
        random = self._random
        others = timed_parts(scenario)
        if others and random.random() < TOGETHER:
            scan = random.choice(others).at_ns // self.scan_ns + random.choice((0, 0, 0, 1, -1))
        else:
            scan = self._scan(edges, first)
        return min(max(scan, 0), self.scans - 1)

    def _scan(self, edges: Edges, first: int) -> int:
        random, scans = self._random, self.scans
        where = random.random()
        if where < AT_EDGES and (edge_scan := edges.near(random, first)) is not None:
            return edge_scan
        if first and where < SOON:
            if self.times and random.random() < BY_TIMES:
                return first + self._own_time() // self.scan_ns
            return first + int((scans - first) ** random.random())
        return random.randint(0, scans - 1)

    def _lasting(self, at: int, edges: Edges) -> int:
        """Return a duration for an event that begins in a scan, ns."""
        random = self._random
        if random.random() < END_AT_EDGES and (end := edges.near(random, at)) is not None and end > at:
            return (end - at) * self.scan_ns
        if random.random() < TO_THE_END:
            return (self.scans - at) * self.scan_ns
        if self.times and random.random() < BY_TIMES:
            return self._own_time()
        return random.choice(LASTING_MS) * MS

    def _press(self, at: int, edges: Edges) -> Contact:
        contact = self.contacts.draw(self._random)
        return replace(contact, at_ns=at * self.scan_ns, for_ns=self._lasting(at, edges))

    def _signal(self, at: int, edges: Edges) -> Signal:
        slot, name, value = self._random.choice(self._rack.signals)
        return Signal(slot, name, value, at * self.scan_ns, self._lasting(at, edges))

    def _setting(self, at: int, _edges: Edges) -> OperatorAction:
        setting = self._random.choice(self._settings)
        return OperatorAction(at * self.scan_ns, Write(setting.tag, self._random.choice(setting.values)))

    def _turn(self, at: int, edges: Edges) -> Turn:
        """Return a movement of a master encoder at a fraction of its maximum speed, in either direction."""
        slot, speed = self._random.choice(self._rack.masters)
        for_ns = max(MS, self._lasting(at, edges))
        counts = max(1, round(speed * self._random.choice(PARTS_OF_SPEED) * for_ns / 1e9))
        return Turn(slot, counts * self._random.choice(WAYS), at * self.scan_ns, for_ns)

    def _link(self, at: int, edges: Edges) -> InjectedFault:
        trouble, slot = self._random.choice(LINKS), self._random.choice(self._rack.answering)
        return InjectedFault(at * self.scan_ns, trouble, slot, self._lasting(at, edges))

    def _power(self, at: int, _edges: Edges) -> InjectedFault:
        slot = self._random.choice([slot.number for slot in self._spec.slot])
        return InjectedFault(at * self.scan_ns, FaultKind.POWER_CYCLE, slot)

    def _mode(self, at: int, edges: Edges) -> InjectedFault:
        return InjectedFault(at * self.scan_ns, FaultKind.PROGRAM_MODE, 0, self._lasting(at, edges))

    def _torn(self, at: int, edges: Edges) -> InjectedFault:
        """Return a torn update, mostly where several words change: elsewhere it has no effect."""
        random = self._random
        slots = [slot.number for slot in self._spec.slot]
        if random.random() < AT_CHANGES and (output_change := edges.output(random)) is not None:
            place, words, scan = output_change
            slot, at = slots[place], min(max(scan + random.choice((0, 0, 0, 1, -1)), 0), self.scans - 1)
            late = random.sample(words, random.randint(1, len(words) - 1))
        else:
            slot = random.choice(slots)
            outputs = range(self._rack.outputs[slot])
            late = random.sample(outputs, random.randint(1, max(1, len(outputs) // 2)))
        return InjectedFault(at * self.scan_ns, FaultKind.TORN_UPDATE, slot, 0, tuple(sorted(late)))

    def _tear(self, at: int, edges: Edges) -> TornUpdate:
        """Return a tear, mostly in the scan before a change of the inputs."""
        random = self._random
        if random.random() < BEFORE_INPUTS and (input_scan := edges.one_of(random, INPUTS)):
            at = input_scan - 1
        routine, rung = random.choice(self._rungs[1:])  # before the first rung, inputs are only late
        return TornUpdate(routine, rung, at * self.scan_ns)

    def _line(self, at: int, edges: Edges) -> InjectedFault:
        """Return a lost or damaged reply, several in a row, an open line, or a controller without power."""
        random, at_ns, slot = self._random, at * self.scan_ns, self._random.choice(self._rack.lines)
        case = random.randint(0, 2)
        if case == 0:
            return InjectedFault(at_ns, random.choice(REPLIES), slot)
        if case == 1:
            return InjectedFault(
                at_ns, random.choice((FaultKind.LINE_DOWN, *REPLIES)), slot, self._lasting(at, edges)
            )
        return InjectedFault(at_ns, FaultKind.CONTROLLER_POWER_CYCLE, slot)

    def _versions(self) -> list[str]:
        """Return the firmware versions that the program supports."""
        on_micrologix = self._spec.controller == "micrologix"
        needed = max(Firmware.parse(slot.needs_firmware) for slot in self._spec.slot)
        return [
            str(version)
            for version in KNOWN
            if version >= needed and (version.micrologix or not on_micrologix)
        ]

    def _other_firmware(self, versions: list[str], scenario: Scenario) -> Scenario:
        version = self._random.choice(versions)
        slots = with_trait(self._spec, Trait.FIRMWARE)
        return replace(scenario, firmware=tuple((slot, version) for slot in slots))

    def _shifted(self, scenario: Scenario) -> Scenario:
        shift = SwitchOffset(self._random.choice(self._rack.axes), self._random.choice(STEPS))
        return replace(scenario, shifts=(shift,))

    def _slipped(self, scenario: Scenario) -> Scenario:
        random = self._random
        where = random.randint(-20_000, 20_000) if random.random() < 0.5 else random.randint(-2_000, 4_000)
        lost_steps: Any = LostSteps(random.choice(self._rack.slipping), where, random.choice((1, 5, 200)))
        return replace(scenario, lost=(lost_steps,))
