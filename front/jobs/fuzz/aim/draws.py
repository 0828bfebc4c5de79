"""Parts of scenarios at random, at any scan or near the edges of a run.

    half of the times     near an edge of the run that is varied
    a third               soon after the event before, on a scale of decades
    the rest              anywhere

One event in seven begins with another one, and a quarter of the durations end near an edge.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from functools import partial
from random import Random
from typing import Any

from ....io_images.amci3601.firmware import KNOWN, Firmware
from ....io_images.image import WORDS
from ....runtime.config.rackspec import RackSpec
from ....runtime.loop.incidents import FaultKind, Incident
from ....runtime.modules.record import Trait
from ....runtime.modules.registry import has
from ..scenarios.kinds import (
    Kind,
    buttons,
    card_buttons,
    card_signals,
    possible_kinds,
    sensors,
    with_trait,
)
from ..scenarios.parts import Lasting, Timed, parts_of, scenario_of, timed_parts, with_part
from ..scenarios.scenario import LostSteps, Press, Push, Scenario, Shift, Signal, Tear
from ..scenarios.tearing import Rung
from .edges import INPUTS, NEAR, NO_EDGES, Edges

MOST = 7
"""Largest number of parts of a scenario that begins from nothing."""

MOST_JOINED = 4
"""Largest number of events that another scenario adds."""

LASTING_MS = (2, 4, 10, 20, 40, 100, 500, 2000)
"""Durations of events, ms."""

STEPS = (1, -1, 10, -10, 200, -200, 3000, -3000)
"""Displacements of a machine, steps."""

MOVED = (0, 1, -1, 10, -10, 100, -100)
"""Displacements of an event from the varied scenario, scans."""

AT_EDGES, SOON, TOGETHER, AGAIN, END_AT_EDGES, TO_THE_END = 0.5, 0.8, 0.15, 0.4, 0.25, 0.06
"""Shares of the draws: see the module; `SOON` includes `AT_EDGES`. `AGAIN` repeats an earlier press."""

BEFORE_INPUTS = 0.75
"""Share of the tears that fall before a change of the inputs."""

LINKS = (FaultKind.LINK_LOST, FaultKind.REMOVED, FaultKind.FATAL_ERROR)
REPLIES = (FaultKind.REPLIES_LOST, FaultKind.REPLIES_DAMAGED)

Make = Callable[[int, Edges], Timed]
"""Makes a part that begins in a scan."""


class Draws:
    """Draws scenarios for a rack.

    Args:
        scans: length of a run, with all events.
        kinds: random events, as far as they are possible.
        random: any generator; the same one draws the same scenarios.
        rungs: where inputs may change within a scan, see `scenarios.tearing`.
    """

    def __init__(
        self, spec: RackSpec, scans: int, kinds: Collection[Kind], random: Random, rungs: Sequence[Rung] = ()
    ) -> None:
        self._spec, self._scans, self._random = spec, scans, random
        self.scan_ns = spec.scan_ns
        self._kinds = possible_kinds(spec).intersection(kinds)
        machines = [slot for slot in spec.slot if has(slot.module, Trait.MACHINE)]
        self._numbers = [slot.number for slot in machines or spec.slot]
        self._inputs = {slot.number: (buttons(slot), sensors(slot)) for slot in machines}
        self._answering = with_trait(spec, Trait.STOPS_ANSWERING)
        self._lines = with_trait(spec, Trait.LINE)
        self._slipping = with_trait(spec, Trait.SLIPS)
        self._rungs = rungs
        self._pushed, self._signals = card_buttons(spec), card_signals(spec)
        self._events = [make for weight, make in self._makers() for _ in range(weight)]
        self._conditions = list(self._untimed())

    def scenario(self, edges: Edges = NO_EDGES, base: Scenario | None = None) -> Scenario:
        """Return a scenario of up to seven parts, or a variant of another one."""
        drawn, first = Scenario() if base is None else self._varied(base), 0
        for _ in range(self._random.randint(base is None, MOST)):
            drawn, first = self.with_one_more(drawn, edges, first)
        return drawn

    def with_one_more(self, scenario: Scenario, edges: Edges, first: int = 0) -> tuple[Scenario, int]:
        """Return a scenario with a further part, and the scan at which the last event begins.

        Args:
            first: scan from which on the part preferably begins.
        """
        random = self._random
        if self._conditions and (not self._events or random.random() < len(self._conditions) * 0.035):
            return random.choice(self._conditions)(scenario), first
        if not self._events:
            return scenario, first
        at = self._when(scenario, edges, first)
        pressed: tuple[Press | Push, ...] = (*scenario.presses, *scenario.pushes)
        if pressed and random.random() < AGAIN:
            part: Timed = self._pressed_again(random.choice(pressed), at)
        else:
            part = random.choice(self._events)(at, edges)
        return with_part(scenario, part), at

    def _pressed_again(self, part: Press | Push, at: int) -> Press | Push:
        """Return the same press in another scan, of any axis that has this input."""
        at_ns = at * self.scan_ns
        if isinstance(part, Push):
            return replace(part, at_ns=at_ns)
        return replace(part, at_ns=at_ns, slot=self._random.choice(list(self._inputs) or [part.slot]))

    def with_one_moved(self, scenario: Scenario, edges: Edges) -> Scenario:
        """Return a scenario with one event at another time: near an edge, or displaced."""
        random = self._random

        def moved(part: Timed) -> Timed:
            if random.random() < 0.5:
                scan = self._scan(edges, 0)
            else:
                scan = part.at_ns // self.scan_ns + random.choice((*NEAR, *MOVED, 30, 300))
            return replace(part, at_ns=min(max(scan, 0), self._scans - 1) * self.scan_ns)

        return self._with_one_changed(scenario, moved, edges)

    def with_one_longer(self, scenario: Scenario, edges: Edges) -> Scenario:
        """Return a scenario with one event of another duration, if there is one with a duration."""
        random = self._random

        def longer(part: Timed) -> Timed:
            if not isinstance(part, Lasting) or not part.for_ns:
                return part
            times = part.for_ns * random.choice((2, 4))
            for_ns = times if random.random() < 0.4 else self._lasting(part.at_ns // self.scan_ns, edges)
            return replace(part, for_ns=min(for_ns, self._scans * self.scan_ns))

        return self._with_one_changed(scenario, longer, edges)

    def with_one_less(self, scenario: Scenario) -> Scenario:
        """Return a scenario without one of its parts."""
        parts = parts_of(scenario)
        if parts:
            parts.pop(self._random.randrange(len(parts)))
        return scenario_of(parts)

    def joined(self, scenario: Scenario, other: Scenario) -> Scenario:
        """Return a scenario with the first events of another one."""
        for part in timed_parts(other)[:MOST_JOINED]:
            scenario = with_part(scenario, part)
        return scenario

    def _with_one_changed(
        self, scenario: Scenario, change: Callable[[Timed], Timed], edges: Edges
    ) -> Scenario:
        """Return a scenario with one event changed, with one more if it has none."""
        parts = parts_of(scenario)
        places = [place for place, (_, part) in enumerate(parts) if isinstance(part, Timed)]
        if not places:
            return self.with_one_more(scenario, edges)[0]
        place = self._random.choice(places)
        name, part = parts[place]
        parts[place] = name, change(part)
        return scenario_of(parts)

    def _varied(self, base: Scenario) -> Scenario:
        """Return another scenario unchanged, or some of its parts, at other times."""
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
        """Return the scan of a new event."""
        random = self._random
        others = timed_parts(scenario)
        if others and random.random() < TOGETHER:
            scan = random.choice(others).at_ns // self.scan_ns + random.choice((0, 0, 0, 1, -1))
        else:
            scan = self._scan(edges, first)
        return min(max(scan, 0), self._scans - 1)

    def _scan(self, edges: Edges, first: int) -> int:
        random, scans = self._random, self._scans
        where = random.random()
        if where < AT_EDGES and (near := edges.near(random, first)) is not None:
            return near
        if first and where < SOON:
            return first + int((scans - first) ** random.random())
        return random.randint(0, scans - 1)

    def _lasting(self, at: int, edges: Edges) -> int:
        """Return the duration of an event from a scan on, ns."""
        random = self._random
        if random.random() < END_AT_EDGES and (end := edges.near(random, at)) is not None and end > at:
            return (end - at) * self.scan_ns
        if random.random() < TO_THE_END:
            return (self._scans - at) * self.scan_ns
        return random.choice(LASTING_MS) * 1_000_000

    def _makers(self) -> Iterator[tuple[int, Make]]:
        """Yield the possible events with their weights."""
        kinds = self._kinds
        if Kind.INPUTS in kinds:
            if self._inputs:
                yield 5, self._press
            if self._pushed:
                yield 3, self._push
            if self._signals:
                yield 2, self._signal
        if Kind.LINK in kinds:
            yield 2, self._link
        if Kind.POWER in kinds:
            yield 1, self._power
        if Kind.MODE in kinds:
            yield 1, self._mode
        if Kind.TORN in kinds:
            yield 1, self._torn
            if len(self._rungs) > 1:
                yield 3, self._tear
        if Kind.LINE in kinds:
            yield 2, self._line

    def _press(self, at: int, edges: Edges) -> Press:
        random = self._random
        number = random.choice(list(self._inputs))
        pressed, wired = self._inputs[number]
        if wired and (not pressed or random.random() < 0.45):  # a sensor sticks, on or off
            which, energised = random.choice(wired), random.random() < 0.5
        else:  # releasing a button that is not pressed changes nothing
            which, energised = random.choice(pressed), True
        return Press(number, which, energised, at * self.scan_ns, self._lasting(at, edges))

    def _push(self, at: int, edges: Edges) -> Push:
        slot, name = self._random.choice(self._pushed)
        return Push(slot, name, at * self.scan_ns, self._lasting(at, edges))

    def _signal(self, at: int, edges: Edges) -> Signal:
        slot, name, value = self._random.choice(self._signals)
        return Signal(slot, name, value, at * self.scan_ns, self._lasting(at, edges))

    def _link(self, at: int, edges: Edges) -> Incident:
        what, slot = self._random.choice(LINKS), self._random.choice(self._answering)
        return Incident(at * self.scan_ns, what, slot, self._lasting(at, edges))

    def _power(self, at: int, _edges: Edges) -> Incident:
        slot = self._random.choice([slot.number for slot in self._spec.slot])
        return Incident(at * self.scan_ns, FaultKind.POWER_CYCLE, slot)

    def _mode(self, at: int, edges: Edges) -> Incident:
        return Incident(at * self.scan_ns, FaultKind.PROGRAM_MODE, 0, self._lasting(at, edges))

    def _torn(self, at: int, _edges: Edges) -> Incident:
        late = self._random.sample(range(WORDS), self._random.randint(1, WORDS // 2))
        slot = self._random.choice([slot.number for slot in self._spec.slot])
        return Incident(at * self.scan_ns, FaultKind.TORN_UPDATE, slot, 0, tuple(sorted(late)))

    def _tear(self, at: int, edges: Edges) -> Tear:
        """Return a tear, most often in the scan before one that sees another input."""
        random = self._random
        if random.random() < BEFORE_INPUTS and (seen := edges.one_of(random, INPUTS)):
            at = seen - 1
        routine, rung = random.choice(self._rungs[1:])  # before the first one they are only late
        return Tear(routine, rung, at * self.scan_ns)

    def _line(self, at: int, edges: Edges) -> Incident:
        """Return a lost or damaged reply, several in a row, an open line, or a controller without power."""
        random, at_ns, slot = self._random, at * self.scan_ns, self._random.choice(self._lines)
        case = random.randint(0, 2)
        if case == 0:
            return Incident(at_ns, random.choice(REPLIES), slot)
        if case == 1:
            return Incident(
                at_ns, random.choice((FaultKind.LINE_DOWN, *REPLIES)), slot, self._lasting(at, edges)
            )
        return Incident(at_ns, FaultKind.CONTROLLER_POWER_CYCLE, slot)

    def _untimed(self) -> Iterator[Callable[[Scenario], Scenario]]:
        """Yield the possible conditions of a whole run."""
        if Kind.FIRMWARE in self._kinds and (versions := self._versions()):
            yield partial(self._other_firmware, versions)
        if Kind.MACHINE in self._kinds:
            yield self._shifted
            if self._slipping:
                yield self._slipped

    def _versions(self) -> list[str]:
        """Return the versions of firmware, none older than the program needs."""
        behind_micrologix = self._spec.controller == "micrologix"
        needed = max(Firmware.parse(slot.needs_firmware) for slot in self._spec.slot)
        return [str(each) for each in KNOWN if each >= needed and (each.micrologix or not behind_micrologix)]

    def _other_firmware(self, versions: list[str], scenario: Scenario) -> Scenario:
        version = self._random.choice(versions)
        slots = with_trait(self._spec, Trait.FIRMWARE)
        return replace(scenario, firmware=tuple((slot, version) for slot in slots))

    def _shifted(self, scenario: Scenario) -> Scenario:
        shift = Shift(self._random.choice(self._numbers), self._random.choice(STEPS))
        return replace(scenario, shifts=(shift,))

    def _slipped(self, scenario: Scenario) -> Scenario:
        random = self._random
        where = random.randint(-20_000, 20_000) if random.random() < 0.5 else random.randint(-2_000, 4_000)
        lost: Any = LostSteps(random.choice(self._slipping), where, random.choice((1, 5, 200)))
        return replace(scenario, lost=(lost,))
