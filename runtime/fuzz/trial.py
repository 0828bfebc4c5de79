"""One run of a program in one scenario, under invariants."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..build import build_cpu, build_rack
from ..cpu import Cpu
from ..events import JsonValue
from ..faults import Cause, CpuFault
from ..listener import ScanListener
from ..rack import Rack
from ..rackspec import RackSpec
from ..scan import Logic
from .invariants import Invariant, Watch
from .moment import Moment
from .scenario import Scenario

NO_FAULT = "no-fault"
"""Name of the invariant that is always there: the program does not fault the CPU."""

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
        rules: sentences of the manual's rules that fired in that scan, with their ids.
    """

    invariant: str
    sentence: str
    scan: int
    now_ns: int
    why: str
    rules: tuple[str, ...] = ()

    def __str__(self) -> str:
        rules = "".join(f"\n  {rule}" for rule in self.rules)
        return (
            f"broken: {self.sentence.rstrip('.')} [{self.invariant}]: scan {self.scan}, "
            f"{self.now_ns / 1e9:g} s: {self.why}{rules}"
        )


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a run came to.

    Attributes:
        scans: number of scans run.
        rules: how often each rule of the manual fired, by id.
        broken: the first invariant that did not hold, or None.
    """

    scans: int
    rules: Mapping[str, int]
    broken: Broken | None = None


class _Watcher:
    """A listener that looks at every scan and stops the CPU when an invariant is broken."""

    def __init__(self, watches: Sequence[tuple[Invariant, Watch]]) -> None:
        self._watches = watches
        self.moment: Moment
        self.cpu: Cpu
        self.rules: Counter[str] = Counter()
        self.broken: Broken | None = None
        self._told: list[str] = []

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Note the rules that fire."""
        if fields.get("kind") == "rule":
            name = str(fields["name"])
            self.rules[name] += 1
            self._told.append(f"{fields['text']} [{name}]")

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Ask every invariant."""
        moment = self.moment
        moment.scan, moment.ns = scan, now_ns
        for invariant, watch in self._watches:
            why = watch(moment)
            if why is not None:
                self.broken = Broken(invariant.name, invariant.sentence, scan, now_ns, why, tuple(self._told))
                self.cpu.stop()
                return
        self._told.clear()

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
            without: names of invariants that are not asked.
            listeners: makes further listeners for the rack, a recorder for one.

        Raises:
            InvariantError: an invariant raised.
        """
        spec = scenario.laid_over(self.spec)
        rack = build_rack(spec)
        logic = self.fresh_logic()
        asked = [each for each in self.invariants if each.name not in set(without)]
        watcher = _Watcher([(each, each.start()) for each in asked])
        watcher.moment = Moment(rack, self.tags_of(logic))
        cpu = build_cpu(spec, logic, rack, listeners=[*listeners(spec, rack), watcher])
        watcher.cpu = cpu
        try:
            cpu.run(self.scans)
        except CpuFault as error:
            return self._faulted(error, watcher, without)
        cpu.close()
        return Verdict(cpu.scan, watcher.rules, watcher.broken)

    def _faulted(self, error: CpuFault, watcher: _Watcher, without: Iterable[str]) -> Verdict:
        fault = error.fault
        if fault.cause is Cause.LISTENER and error.__cause__ is not None:
            raise error.__cause__  # an invariant that raised, not the program
        broken = None
        if NO_FAULT not in without:
            says = "The program does not fault the CPU"
            broken = Broken(NO_FAULT, says, fault.scan, fault.now_ns, f"{fault.text} [{fault.where}]")
        return Verdict(fault.scan, watcher.rules, broken)
