"""One run of a program in one scenario, under invariants."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..build import build_cpu, build_rack
from ..cpu import Cpu, ScanFlag
from ..events import JsonValue
from ..faults import Cause, CpuFault, Fault
from ..listener import ScanListener
from ..pace import wall_ns
from ..rack import Rack
from ..rackspec import RackSpec
from ..scan import Logic
from .invariants import Invariant, Watch
from .moment import Moment
from .scenario import Scenario

NO_FAULT = "no-fault"
"""Name of the invariant that is always there: the program does not fault the CPU."""

PROGRAM, RUNNING, ASKING, BUILDING = "the program", "modules and scan loop", "invariants", "making racks"
"""What the time of a run goes to."""

HANGS = "watchdog"
"""Cause of a fault where the logic has not come back in time: where it was then is chance."""

SENTENCES = ("rule", "refusal", "adapter")
"""Kinds of events that say why a bit is set."""

FAULT = ScanFlag.FAULT.value

NOTHING: Mapping[str, Any] = {}


@dataclass(frozen=True, slots=True)
class Broken:
    """An invariant that did not hold.

    Attributes:
        invariant: its name.
        sentence: what should have held.
        scan: number of the scan.
        now_ns: its virtual time, ns since power-up.
        why: in which way it did not.
        shows: what each slot shows at the end of that scan, in words.
        rules: sentences of the manual's rules that fired in that scan, and of an adapter's refusals,
            with their ids.
        cause: what tells it from other failures of the same invariant: of a fault, its place.
    """

    invariant: str
    sentence: str
    scan: int
    now_ns: int
    why: str
    shows: tuple[str, ...] = ()
    rules: tuple[str, ...] = ()
    cause: str = ""

    @property
    def key(self) -> str:
        """What one failure is known by: the invariant, and its cause if it has one."""
        return f"{self.invariant} {self.cause}".rstrip()

    def __str__(self) -> str:
        what = f"{self.sentence.rstrip('.')} [{self.invariant}]"
        return f"broken: {what}: scan {self.scan}, {self.now_ns / 1e9:g} s: {self.why}"


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a run came to.

    Attributes:
        scans: number of scans run.
        rules: how often each rule of the manual fired, by id.
        broken: the first invariant that did not hold, or None.
        spent: what the time went to, ns.
        applied: names of the invariants that had something to look at.
    """

    scans: int
    rules: Mapping[str, int]
    broken: Broken | None = None
    spent: Mapping[str, int] = field(default_factory=dict, compare=False)
    applied: frozenset[str] = frozenset()


class _Timed:
    """A logic whose time is taken."""

    def __init__(self, logic: Logic) -> None:
        self._logic = logic
        self.spent_ns = 0

    def __call__(self, scan: Any) -> None:
        start_ns = wall_ns()
        self._logic(scan)
        self.spent_ns += wall_ns() - start_ns


class _Watcher:
    """A listener that looks at every scan and stops the CPU when an invariant is broken."""

    def __init__(self, watches: Sequence[tuple[Invariant, Watch]]) -> None:
        self._watches = watches
        self.moment: Moment
        self.cpu: Cpu
        self.rules: Counter[str] = Counter()
        self.broken: Broken | None = None
        self.spent_ns = 0
        self._told: list[str] = []

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Note the rules that fire, and what an adapter says beside them."""
        if fields.get("kind") in SENTENCES:
            name = str(fields["name"])
            self._told.append(f"{fields['text']} [{name}]")
            if fields["kind"] == "rule":
                self.rules[name] += 1

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Ask every invariant, unless the scan was not finished."""
        if flags & FAULT:
            return
        start_ns = wall_ns()
        moment = self.moment
        moment.scan, moment.ns = scan, now_ns
        for invariant, watch in self._watches:
            why = watch(moment)
            if why is not None:
                self.broken = self.told(invariant.name, invariant.sentence, why)
                self.cpu.stop()
                return
        self._told.clear()
        self.spent_ns += wall_ns() - start_ns

    @property
    def applied(self) -> frozenset[str]:
        """Names of the invariants that have had something to look at."""
        return frozenset(each.name for each, watch in self._watches if getattr(watch, "applied", True))

    def told(self, name: str, sentence: str, why: str) -> Broken:
        """Return what is broken at this moment."""
        now = self.moment
        shows = tuple(f"slot {number}: {slot}" for number, slot in now.slot.items())
        return Broken(name, sentence, now.scan, now.ns, why, shows, tuple(self._told))

    def faulted(self, fault: Fault) -> Broken:
        """Return that the CPU has faulted."""
        self.moment.scan, self.moment.ns = fault.scan, fault.now_ns
        broken = self.told(NO_FAULT, "The program does not fault the CPU", f"{fault.text} [{fault.where}]")
        return replace(broken, cause=HANGS if fault.cause is Cause.WATCHDOG else Path(fault.where).name)

    def close(self) -> None:
        """See `ScanListener.close`."""


@dataclass(frozen=True, slots=True)
class Bench:
    """What does not change from trial to trial.

    Attributes:
        spec: the rack, as its file describes it.
        fresh_logic: makes the logic anew, with nothing remembered.
        invariants: what must hold.
        scans: how long a run is.
        tags_of: the tags of a logic by name.
    """

    spec: RackSpec
    fresh_logic: Callable[[], Logic]
    invariants: Sequence[Invariant]
    scans: int
    tags_of: Callable[[Logic], Any] = field(default=lambda _logic: NOTHING)

    @property
    def names(self) -> frozenset[str]:
        """Names of all that must hold, `NO_FAULT` among them."""
        return frozenset({NO_FAULT, *(each.name for each in self.invariants)})

    def run(
        self,
        scenario: Scenario,
        *,
        without: Iterable[str] = (),
        listeners: Callable[[RackSpec, Rack], Iterable[ScanListener]] = lambda _spec, _rack: (),
    ) -> Verdict:
        """Run the program in a scenario until an invariant is broken or the time is over.

        Args:
            scenario: what surrounds it.
            without: names of invariants that are not asked, and keys of faults that do not count.
            listeners: makes further listeners for the rack, a recorder for one.

        Raises:
            InvariantError: an invariant raised.
        """
        start_ns = wall_ns()
        spec = scenario.laid_over(self.spec)
        rack = build_rack(spec)
        logic = self.fresh_logic()
        timed = _Timed(logic)
        unasked = set(without)
        watcher = _Watcher([(each, each.start()) for each in self.invariants if each.name not in unasked])
        watcher.moment = Moment(rack, self.tags_of(logic))
        cpu = build_cpu(spec, timed, rack, listeners=[*listeners(spec, rack), watcher])
        watcher.cpu = cpu
        built_ns = wall_ns()
        try:
            cpu.run(self.scans)
            cpu.close()
        except CpuFault as error:
            if error.fault.cause is Cause.LISTENER and error.__cause__ is not None:
                raise error.__cause__ from None  # an invariant that raised, not the program
            broken = watcher.faulted(error.fault)
            watcher.broken = None if {NO_FAULT, broken.key} & unasked else broken
        spent = {
            BUILDING: built_ns - start_ns,
            PROGRAM: timed.spent_ns,
            ASKING: watcher.spent_ns,
            RUNNING: wall_ns() - built_ns - timed.spent_ns - watcher.spent_ns,
        }
        return Verdict(cpu.scan, watcher.rules, watcher.broken, spent, watcher.applied)
