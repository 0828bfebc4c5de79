"""Input levels that change with time: the timeline, the stations, and inputs held by the bench.

    rest                 depart                 (another motion)
     |<---- work_ns ---->|                       work canceled: no pulse
     |<---- work_ns ---->|<-- pulse_ns -->|      a pulse that has begun is completed

An input is *held* once a timeline entry or the bench has set its level. Other inputs follow switches and
stations.
"""

from __future__ import annotations

from scanrack.io_images.amci3601.bits import InputBit

from ..loop.events import Event
from .shaft import FAR
from .spec import MachineSpec, Station, TimelineEntry

_LEVEL = {True: "energized", False: "de-energized"}

_INPUT_TITLES = {
    InputBit.CAPTURE: "capture",
    InputBit.EXTERNAL: "external",
    InputBit.HOME: "home",
    InputBit.ESTOP: "emergency stop",
    InputBit.CW_LIMIT: "CW limit",
    InputBit.CCW_LIMIT: "CCW limit",
}


class _Work:
    """A station's work in progress.

    Attributes:
        due_ns: start of its pulse, or FAR while it is not working.
        until_ns: end of its pulse, or FAR if there is no pulse.
    """

    __slots__ = ("due_ns", "station", "until_ns")

    def __init__(self, station: Station) -> None:
        self.station = station
        self.due_ns = FAR
        self.until_ns = FAR


class Stimuli:
    """Input changes made by the timeline, stations and bench; calls must be in chronological order.

    Attributes:
        held_mask: mask of the held inputs.
        held: mask of the held inputs that are energized.
        pulses: mask of the inputs that a station pulses.
        events: past actions, in chronological order; the reader empties the list.
        next_ns: instant of the next action, or FAR.
    """

    __slots__ = ("_entries", "_fed", "_index", "_works", "events", "held", "held_mask", "next_ns", "pulses")

    def __init__(self, spec: MachineSpec) -> None:
        self._entries = sorted(spec.timeline, key=lambda entry: entry.at_ns)
        self._index = 0  # of the next entry
        self._works = [_Work(station) for station in spec.stations]
        self._fed = spec.fed_inputs
        self.held_mask = 0
        self.held = 0
        self.pulses = 0
        self.events: list[Event] = []
        self.next_ns = self._soonest_ns()

    def _soonest_ns(self) -> int:
        """Return the instant of the next timeline entry, pulse start or pulse end; FAR if none is due."""
        soonest = self._entries[self._index].at_ns if self._index < len(self._entries) else FAR
        for station_work in self._works:
            soonest = min(soonest, station_work.due_ns, station_work.until_ns)
        return soonest

    def advance(self, now_ns: int) -> None:
        """Carry out all actions up to `now_ns`."""
        while self.next_ns <= now_ns:
            self._act_at(self.next_ns)
            self.next_ns = self._soonest_ns()

    def _act_at(self, at_ns: int) -> None:
        """Carry out the timeline entries that are due at an instant; begin and end pulses."""
        while self._index < len(self._entries) and self._entries[self._index].at_ns == at_ns:
            self._act(self._entries[self._index])
            self._index += 1
        for station_work in self._works:
            if station_work.due_ns == at_ns:
                self._begin_pulse(station_work)
            elif station_work.until_ns == at_ns:
                self._end_pulse(station_work)
        self.pulses = 0
        for station_work in self._works:
            if station_work.until_ns != FAR:
                self.pulses |= station_work.station.input.value

    def _act(self, entry: TimelineEntry) -> None:
        """Hold or release an input, and add the event."""
        self.hold(entry.input, entry.energized)
        self._report(entry.at_ns, entry.input, self._sentence(entry), entry.energized)

    def operate(self, bit: InputBit, energized: bool | None, now_ns: int) -> None:
        """Act on an input as a timeline entry does.

        A released input without a switch or a station is de-energized.
        """
        self.advance(now_ns)
        if energized is None and not self._fed & bit.value:
            energized = False
        self._act(TimelineEntry(now_ns, bit, energized))

    def _sentence(self, entry: TimelineEntry) -> str:
        """Return the text of the event for an entry."""
        name = _INPUT_TITLES[entry.input]
        if entry.energized is None:
            return f"The {name} input follows the machine again."
        if self._fed & entry.input.value:
            return f"The {name} input stays {_LEVEL[entry.energized]}, whatever the machine does."
        return f"The {name} input is {_LEVEL[entry.energized]}."

    def hold(self, bit: InputBit, energized: bool | None) -> None:
        """Hold an input at a level, or release it (None)."""
        mask = bit.value
        self.held_mask = self.held_mask & ~mask if energized is None else self.held_mask | mask
        self.held = self.held | mask if energized else self.held & ~mask

    def _begin_pulse(self, work: _Work) -> None:
        at_ns, station = work.due_ns, work.station
        work.due_ns, work.until_ns = FAR, work.due_ns + station.pulse_ns
        self._report(at_ns, station.input, f"The station at {station.position} is done and signals it.", True)

    def _end_pulse(self, work: _Work) -> None:
        at_ns, station = work.until_ns, work.station
        work.until_ns = FAR
        self._report(at_ns, station.input, f"The station at {station.position} ends its signal.", False)

    def _report(self, at_ns: int, bit: InputBit, text: str, energized: bool | None) -> None:
        self.events.append(Event(at_ns, "stimulus", str(bit.name).lower(), text, {"energized": energized}))

    def rest(self, now_ns: int, shaft: int) -> None:
        """Begin the work of the stations at a shaft position after a motion."""
        self.advance(now_ns)
        for station_work in self._works:
            if station_work.station.position == shaft:
                station_work.due_ns = now_ns + station_work.station.work_ns
        self.next_ns = self._soonest_ns()

    def depart(self, now_ns: int) -> None:
        """Stop the work of all stations before a motion."""
        self.advance(now_ns)
        for station_work in self._works:
            station_work.due_ns = FAR
        self.next_ns = self._soonest_ns()
