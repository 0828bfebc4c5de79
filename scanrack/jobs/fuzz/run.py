"""Runs a program in a scenario and checks invariants."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field, replace
from io import TextIOBase
from pathlib import Path
from typing import Any

from scanrack.io_images.amci3601.words import profile_of
from scanrack.io_images.times import seconds
from scanrack.ladder import Engine
from scanrack.ladder.python.sequences import Sequence as LogicSequence
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.live.operator_actions import AppliedAction, OperatorActions
from scanrack.runtime.loop.cpu import Cpu, ScanFlag
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.loop.faults import Cause, CpuFault, Fault
from scanrack.runtime.loop.listeners import QuietListener, ScanListener
from scanrack.runtime.loop.pace import wall_ns
from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.loop.scan import ScanLogic
from typing_extensions import override

from ..load.building import build_cpu, build_rack
from ..record.logic_wrapper import LogicWrapper, unwrapped
from ..record.order_repeater import OrderRepeater
from ..record.sequence_watch import sequences_in, wait_of
from .aim.explored_states import RARELY, ExploredStates, ExploredStateStop
from .aim.probe import Probe
from .aim.python_state import namespace_of
from .invariants.busy import axes_in
from .invariants.goals import MaximumGoal, Sometimes
from .invariants.invariants import FOREVER_NS, Invariant, Watch
from .invariants.output_line import OutputLine
from .invariants.scan_view import ProgramState, Snapshot
from .program_clocks import clocks_of
from .repeated_scans import NS_PER_MS, RepeatedScans, stops_of
from .scenarios.panel import PanelTag
from .scenarios.parts import end_ns, timed_parts
from .scenarios.scenario import Scenario
from .scenarios.tearing import Rung, TornScans

NO_FAULT = "no-fault"
"""Name of the invariant that is always checked: the program does not fault the CPU."""

PROGRAM, RUNNING, JUDGING, BUILDING = "the program", "modules and scan loop", "invariants", "making racks"
"""Parts of a run's time."""

HANGS = "watchdog"
"""Cause of a watchdog fault, which occurs at a random place."""

SENTENCES = ("rule", "refusal", "adapter")
"""Kinds of events whose text explains why a bit is set."""

FAULT = ScanFlag.FAULT.value


@dataclass(frozen=True, slots=True)
class BrokenInvariant:
    """An invariant that was violated.

    Attributes:
        why: description of the violation.
        shows: sentences about the state of each slot at the end of that scan, and the waits of the program's
            sequences.
        rules: sentences, with ids, of the manual's rules that fired in that scan and of an adapter's
            refusals.
        cause: distinguishes the failure from others of the same invariant. For a fault it is the place.
            Otherwise it is the rule that refused a command in that scan, or in the scan that started a clock.
            Without such a rule it is the line that last changed an output word, the waits of the program's
            sequences, or, for a ladder program, the commands in force.
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
        """Identity of a failure: the invariant and, if known, its cause."""
        return f"{self.invariant} {self.cause}".rstrip()

    def __str__(self) -> str:
        violation = f"{self.sentence.rstrip('.')} [{self.invariant}]"
        return f"broken: {violation}: scan {self.scan}, {seconds(self.now_ns)} s: {self.why}"


@dataclass(frozen=True, slots=True)
class Verdict:
    """The result of a run."""

    scans: int
    rules: Mapping[str, int]  # number of firings of each rule of the manual, by id
    broken: BrokenInvariant | None = None  # the first violated invariant, or None
    spent: Mapping[str, int] = field(default_factory=dict, compare=False)  # parts of its time, ns
    applied: frozenset[str] = frozenset()  # names of the invariants that had something to check
    printed: int = 0  # number of lines that the program printed; they are not shown
    greatest: Mapping[str, float] = field(
        default_factory=dict
    )  # greatest values of maximized numbers, by name

    @property
    def is_unplaced(self) -> bool:
        """Whether the place of its failure is still unknown."""
        return self.broken is not None and self.broken.cause == UNPLACED


TIMED = 16
"""The time of one in this many scans is measured, since reading a clock also takes time."""


class _TimedLogic(LogicWrapper):
    """Measures the time that a logic takes."""

    def __init__(self, logic: ScanLogic) -> None:
        super().__init__(logic)
        self.spent_ns = 0
        self._calls = 0

    def __call__(self, scan: Any) -> None:
        self._calls += 1
        if self._calls % TIMED:
            self._logic(scan)
            return
        start_ns = wall_ns()
        self._logic(scan)
        self.spent_ns += (wall_ns() - start_ns) * TIMED


class _LineCounter(TextIOBase):
    """Replaces the program's standard output and only counts lines."""

    def __init__(self) -> None:
        super().__init__()
        self.lines = 0

    @override
    def writable(self) -> bool:
        return True

    def write(self, text: str, /) -> int:
        """Count the lines in a text."""
        self.lines += text.count("\n")
        return len(text)


@dataclass(slots=True)
class _WatchedInvariant:
    """The state of an invariant in one run."""

    invariant: Invariant
    watch: Watch
    broken: bool = False  # whether it was broken in the previous scan: failures count once


@dataclass(eq=False)
class _Watcher(QuietListener):
    """A listener that checks every scan and stops the CPU when an invariant is broken.

    Attributes:
        known: keys of failures that are ignored: the run continues.
        place: returns the cause of a failure for which no rule has fired.
        sequences: the sequences of the program.
        rules: number of firings of each rule so far.
        broken: the failure that stopped the CPU.
    """

    watched: Sequence[_WatchedInvariant]
    known: Collection[str]
    place: Callable[[], str]
    snapshot: Snapshot = field(init=False)
    cpu: Cpu = field(init=False)
    sequences: tuple[LogicSequence, ...] = ()
    rules: Counter[str] = field(default_factory=Counter)
    broken: BrokenInvariant | None = None
    spent_ns: int = 0
    _waits_at_fault: tuple[str, ...] = ()
    _explanations: list[str] = field(default_factory=list)
    _fired: dict[int, list[str]] = field(default_factory=dict)

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Record the rules that fire, and an adapter's messages."""
        if fields.get("kind") in SENTENCES:
            name = str(fields["name"])
            self._explanations.append(f"{fields['text']} [{name}]")
            if fields["kind"] == "rule":
                self.rules[name] += 1
                self._fired.setdefault(scan, []).append(name)

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Check every invariant, unless the scan was not finished."""
        if flags & FAULT:
            self._waits_at_fault = self._wait_sentences(scan)  # before the CPU closes the sequences
            return
        start_ns = 0 if scan % TIMED else wall_ns()
        snapshot = self.snapshot
        snapshot.move_on(scan, now_ns, flags)
        snapshot.rules = self._fired.get(scan, ())
        for watched in self.watched:
            why = watched.watch(snapshot)
            if why is None:
                watched.broken = False
            elif not watched.broken:
                watched.broken = True
                if self._is_new(watched, why):
                    self.cpu.stop()
                    return
        self._explanations.clear()
        if start_ns:
            self.spent_ns += (wall_ns() - start_ns) * TIMED

    def _is_new(self, watched: _WatchedInvariant, why: str) -> bool:
        """Record a failure if it is new; return whether it is."""
        broken = self._broken(watched.invariant.name, watched.invariant.sentence, why)
        origin = getattr(watched.watch, "origin_scan", broken.scan)
        refusals = [profile_of(slot.words).refusals for slot in self.cpu.rack.slots.values()]
        fired = self._fired.get(origin, ())
        refused = next((rule for rule in fired if any(rule in refusal for refusal in refusals)), "")
        broken = replace(broken, cause=refused or self.place())
        if broken.key in self.known:
            return False
        self.broken = broken
        return True

    def has_running_clock(self) -> bool:
        """Return whether the clock of any invariant is running."""
        return any(getattr(watched.watch, "waiting", False) for watched in self.watched)

    def same_until_ns(self, counting: bool) -> int:
        """Return the instant until which every invariant keeps its answer, see `Watch`; 0 if unknown."""
        methods = [getattr(watched.watch, "same_until_ns", None) for watched in self.watched]
        return min((0 if method is None else method(counting) for method in methods), default=FOREVER_NS)

    def note_goals(self, note: Callable[[str, Hashable, int], None]) -> None:
        """Let goals call `note` when they are reached."""
        for watched in self.watched:
            if isinstance(watched.watch, Sometimes | MaximumGoal):
                watched.watch.note = note

    @property
    def greatest(self) -> dict[str, float]:
        """The greatest value of each maximized number, by name."""
        watches = [(watched.invariant.name, watched.watch) for watched in self.watched]
        return {
            name: watch.greatest
            for name, watch in watches
            if isinstance(watch, MaximumGoal) and watch.greatest is not None
        }

    @property
    def applied(self) -> frozenset[str]:
        """Names of the invariants that have had something to check."""
        return frozenset(
            watched.invariant.name for watched in self.watched if getattr(watched.watch, "applied", True)
        )

    def _broken(self, name: str, sentence: str, why: str) -> BrokenInvariant:
        """Return the record of an invariant that is broken in this scan."""
        now = self.snapshot
        shows = tuple(f"slot {number}: {slot}" for number, slot in now.slot.items())
        shows += self._waits_at_fault or self._wait_sentences(now.scan)
        return BrokenInvariant(name, sentence, now.scan, now.ns, why, shows, tuple(self._explanations))

    def _wait_sentences(self, scan: int) -> tuple[str, ...]:
        """Return a sentence for each wait of the program's sequences."""
        return tuple(str(wait_of(sequence, scan)) for sequence in self.sequences)

    def faulted(self, fault: Fault) -> BrokenInvariant:
        """Return the failure for a fault of the CPU."""
        self.snapshot.scan, self.snapshot.ns = fault.scan, fault.now_ns
        broken = self._broken(NO_FAULT, "The program does not fault the CPU", f"{fault.text} [{fault.where}]")
        return replace(broken, cause=HANGS if fault.cause is Cause.WATCHDOG else Path(fault.where).name)


Listeners = Callable[[RackSpec, Rack, ScanLogic], Iterable[ScanListener]]
"""Returns further listeners of a run, for its rack and its logic."""


def _no_listeners(_spec: RackSpec, _rack: Rack, _logic: ScanLogic) -> Iterable[ScanListener]:
    return ()


def _state_of(logic: ScanLogic) -> ProgramState:
    program = unwrapped(logic)
    if isinstance(program, Engine):
        return ProgramState()
    return ProgramState(getattr(program, "__dict__", {}), namespace_of(program))


UNPLACED = "?"
"""Cause of a failure whose place is still unknown: the run is repeated with its lines traced."""

TRACED_BEFORE = 20
"""Number of scans traced before a failure, at first; more if no output changes in them."""


@dataclass(frozen=True, slots=True)
class TrialBench:
    """Everything that stays the same in all trials."""

    spec: RackSpec
    fresh_logic: Callable[[], ScanLogic]
    invariants: Sequence[Invariant]
    scans: int
    rungs: tuple[Rung, ...] = ()  # rungs where a tear has an effect, see `scenarios.tearing`
    settings: tuple[PanelTag, ...] = ()  # tags that an operator writes

    @property
    def names(self) -> frozenset[str]:
        """Names of the invariants, including `NO_FAULT`."""
        return frozenset(
            {NO_FAULT, *(invariant.name for invariant in self.invariants if not invariant.is_goal)}
        )

    @property
    def goals(self) -> tuple[Invariant, ...]:
        """The goals of the search."""
        return tuple(invariant for invariant in self.invariants if invariant.is_goal)

    def run(
        self,
        scenario: Scenario,
        *,
        without: Iterable[str] = (),
        listeners: Listeners = _no_listeners,
        probe: Probe | None = None,
        explored: ExploredStates | None = None,
        aloud: bool = False,
        every_scan: bool = True,
    ) -> Verdict:
        """Run the program in a scenario until an invariant is broken or the run ends.

        Args:
            without: names of invariants to skip, and keys of failures to ignore.
            probe: records what changes.
            explored: states of other runs; a run with a probe may end in one of them.
            every_scan: False = skip scans that repeat the previous one, if there are no `listeners`.

        Raises:
            InvariantError: an invariant raised.
        """
        start_ns = wall_ns()
        ignored = frozenset(without)
        stop = None if explored is None else explored.begin(scenario, self.spec)
        run = _Run(self, scenario, ignored, every_scan=every_scan, probe=probe, explored_stop=stop)
        verdict = run.go(listeners, aloud=aloud)
        if verdict.broken is not None and verdict.is_unplaced:
            verdict = self._placed(scenario, ignored, verdict.broken.scan, every_scan=every_scan)
        spent = {**verdict.spent, BUILDING: 0}
        return replace(verdict, spent={**spent, BUILDING: wall_ns() - start_ns - sum(spent.values())})

    def _placed(self, scenario: Scenario, ignored: frozenset[str], scan: int, *, every_scan: bool) -> Verdict:
        """Repeat a run to find the line that last changed an output before it failed."""

        def traced(since: int) -> tuple[_Run, Verdict]:
            run = _Run(self, scenario, ignored, traced_since=since, every_scan=every_scan)
            return run, run.go(_no_listeners, aloud=False)

        run, verdict = traced(max(0, scan - TRACED_BEFORE))
        if verdict.is_unplaced:
            run, verdict = traced(run.last_output_change)
        return traced(0)[1] if verdict.is_unplaced else verdict


@dataclass(frozen=True, slots=True)
class _OrderDesk:
    """Lets a scenario's orders write the tags of a program."""

    tags: Any

    def force(self, tag: str, value: object) -> None:
        """Refuse to force a tag."""
        raise ValueError(f"{tag} is a tag: a scenario writes tags, and forces images")

    def unforce(self, tag: str | None = None) -> None:
        """Do nothing: no tag is forced."""


class _Run:
    """One run: a new rack, a new logic, fresh watches.

    Args:
        traced_since: first scan in which the lines that write outputs are traced, see `OutputLine`; None =
            trace no scan.
        every_scan: whether to run also scans that repeat the previous one, see `repeated_scans`.
        explored_stop: ends a run with a probe in an explored state; None = run all scans.
    """

    def __init__(
        self,
        bench: TrialBench,
        scenario: Scenario,
        without: frozenset[str],
        *,
        traced_since: int | None = None,
        every_scan: bool = True,
        probe: Probe | None = None,
        explored_stop: ExploredStateStop | None = None,
    ) -> None:
        self._scans, self._scenario = bench.scans, scenario
        self._every_scan, self._explored_stop = every_scan, explored_stop
        self._without = without
        self._printed = _LineCounter()
        self._spec, self._orders = scenario.laid_over(bench.spec), scenario.orders
        self._rack = build_rack(self._spec)
        with self._kept_quiet(aloud=False):
            logic = self._logic = bench.fresh_logic()
        self._probe = probe
        if probe is not None:
            logic = probe.prepared(logic)
            probe.watch(logic, self._rack)
        self._torn = TornScans(logic, scenario.tears, self._spec.scan_ns) if scenario.tears else None
        logic_called: ScanLogic = self._torn or logic
        self._output_line = (
            None if traced_since is None else OutputLine(logic_called, self._rack, traced_since)
        )
        self._timed = _TimedLogic(self._output_line or logic_called)
        invariants = [invariant for invariant in bench.invariants if invariant.name not in without]
        watches = [_WatchedInvariant(invariant, invariant.start()) for invariant in invariants]
        self._watcher = _Watcher(watches, without, self._place)
        tags = getattr(unwrapped(logic), "tags", {})
        self._watcher.snapshot = Snapshot(self._rack, tags, axes_in(logic, tags), _state_of(logic))
        self._watcher.sequences = sequences_in(logic)
        if probe is not None:
            self._watcher.note_goals(probe.edges.add)

    def go(self, listeners: Listeners, *, aloud: bool) -> Verdict:
        """Run the scenario and return the verdict.

        Raises:
            InvariantError: an invariant raised.
            ValueError: an order in the scenario can't be carried out.
        """
        watcher = self._watcher
        probes = [] if self._probe is None else [self._probe]
        listening = [*listeners(self._spec, self._rack, self._logic), *probes, watcher]
        watcher.cpu = cpu = build_cpu(self._spec, self._timed, self._rack, listeners=listening)
        if self._torn is not None:
            self._torn.cpu = cpu
        if not self._every_scan:
            self._pass_over_repeats(cpu)
        repeated = self._operator(cpu)
        start_ns = wall_ns()
        try:
            with self._kept_quiet(aloud=aloud):
                self._run_scans(cpu)
                cpu.close()
        except CpuFault as error:
            if error.fault.cause is Cause.LISTENER and error.__cause__ is not None:
                raise error.__cause__ from None  # an invariant raised it, not the program
            broken = watcher.faulted(error.fault)
            watcher.broken = None if {NO_FAULT, broken.key} & self._without else broken
        if repeated is not None and repeated.refused:
            raise ValueError(f"scenario: {repeated.refused[0]}")
        spent = {PROGRAM: self._timed.spent_ns, JUDGING: watcher.spent_ns}
        spent[RUNNING] = wall_ns() - start_ns - sum(spent.values())
        return Verdict(
            cpu.scan,
            watcher.rules,
            watcher.broken,
            spent,
            watcher.applied,
            self._printed.lines,
            watcher.greatest,
        )

    def _pass_over_repeats(self, cpu: Cpu) -> None:
        """Make the CPU skip scans that repeat the previous one, if it runs a ladder program."""
        engine, spec = unwrapped(self._timed), self._spec
        if not isinstance(engine, Engine) or spec.scan_ns % NS_PER_MS:
            return
        clocks = clocks_of(engine.lowered)
        if clocks is None:
            return
        stops = stops_of(self._instants_ns(), spec.scan_ns)
        until_ns = self._watcher.same_until_ns
        if self._explored_stop is not None:
            self._explored_stop.calm = RARELY
        cpu.pass_over_repeats(RepeatedScans(engine, clocks, spec.scan_ns, stops, until_ns))

    def _instants_ns(self) -> Iterator[int]:
        """Yield the instants at which an event of this run begins or ends."""
        for part in (*timed_parts(self._scenario), *self._spec.incidents):
            yield part.at_ns
            yield end_ns(part)

    def _run_scans(self, cpu: Cpu) -> None:
        if self._explored_stop is None or self._probe is None:
            cpu.run(self._scans)
            return
        self._explored_stop.run(cpu, self._probe, self._scans, self._watcher.has_running_clock)
        if self._watcher.broken is None:
            self._explored_stop.learn()

    def _operator(self, cpu: Cpu) -> OrderRepeater | None:
        """Return an object that applies the scenario's orders; None if it has none."""
        if not self._orders:
            return None
        applied = [AppliedAction(order.at_ns // self._spec.scan_ns, order.order) for order in self._orders]
        repeated = OrderRepeater(
            cpu, OperatorActions(cpu, self._rack, _OrderDesk(self._watcher.snapshot.tags)), applied
        )
        cpu.add_listener(repeated)
        repeated.begin()
        return repeated

    @property
    def last_output_change(self) -> int:
        """The last scan known to have changed outputs, if the run was not traced from early enough."""
        return 0 if self._output_line is None else self._output_line.changed_in

    def _place(self) -> str:
        """Return the line that last changed an output word, or `UNPLACED`.

        If an axis of the program writes them, return the waits of the sequences; else the commands in force.
        """
        if self._output_line is None or not self._output_line.is_complete:
            return UNPLACED
        return self._output_line.last or self._waits() or self._commands()

    def _waits(self) -> str:
        """Return the sequences of the program with the lines at which they wait; empty if none waits."""
        waiting_sequences = [sequence for sequence in self._watcher.sequences if not sequence.over]
        return " ".join(
            f"{sequence.name} at {Path(sequence.file or '').name}:{sequence.line}"
            for sequence in waiting_sequences
        )

    def _commands(self) -> str:
        """Return the commands in force."""
        slots = self._watcher.snapshot.slot.values()
        return " ".join(name for slot in slots for name in slot.commands)

    @contextmanager
    def _kept_quiet(self, *, aloud: bool) -> Iterator[None]:
        """Hide the program's output from the terminal and count its lines, unless `aloud`."""
        if aloud:
            yield
        else:
            with redirect_stdout(self._printed), redirect_stderr(self._printed):
                yield
