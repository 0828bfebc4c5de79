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
"""Name of the invariant that every search checks: the program does not fault the CPU."""

PROGRAM, RUNNING, JUDGING, BUILDING = "the program", "modules and scan loop", "invariants", "making racks"
"""Parts of a run's time."""

HANGS = "watchdog"
"""Cause of a watchdog fault. A watchdog fault has no place, since it can occur anywhere."""

SENTENCES = ("rule", "refusal", "adapter")
"""Kinds of events with a text that explains why a bit is set."""

FAULT = ScanFlag.FAULT.value


@dataclass(frozen=True, slots=True)
class BrokenInvariant:
    """A broken invariant.

    Attributes:
        scan: the scan of the failure.
        why: description of the violation.
        shows: sentences about each slot and each waiting sequence at the end of the scan.
        rules: sentences, with ids, of the manual's rules that fired in this scan, and of an adapter's
            refusals.
        cause: distinguishes the failure from others of the same invariant. For a fault, it is the place.
            Otherwise, it is the rule that refused a command in this scan, or in the scan that started the
            clock. Without such a rule, it is the line that last changed an output word, the waits of the
            program's sequences, or the commands in force.
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
    broken: BrokenInvariant | None = None  # the first broken invariant, or None
    spent: Mapping[str, int] = field(default_factory=dict, compare=False)  # time of each part, ns
    applied: frozenset[str] = frozenset()  # names of the invariants that had something to check
    printed: int = 0  # number of lines that the program printed
    greatest: Mapping[str, float] = field(default_factory=dict)  # of maximized numbers, by name

    @property
    def is_unplaced(self) -> bool:
        """Whether the cause of its failure is still unknown."""
        return self.broken is not None and self.broken.cause == UNPLACED


TIMED = 16
"""Only one scan in this many is timed, since reading a clock takes time."""


class _TimedLogic(LogicWrapper):
    """Measures the time that the logic takes."""

    def __init__(self, logic: ScanLogic) -> None:
        super().__init__(logic)
        self.spent_ns = 0
        self._calls = 0

    def __call__(self, scan: Any) -> None:
        """Call the logic. One call in `TIMED` is measured, and represents the others."""
        self._calls += 1
        if self._calls % TIMED:
            self._logic(scan)
            return
        start_ns = wall_ns()
        self._logic(scan)
        self.spent_ns += (wall_ns() - start_ns) * TIMED


class _LineCounter(TextIOBase):
    """Replaces the program's standard output and counts the lines."""

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
    broken: bool = False  # whether it was broken in the previous scan, since a failure counts once


@dataclass(eq=False)
class _Watcher(QuietListener):
    """A listener that checks every scan, and stops the CPU when an invariant is broken.

    Attributes:
        known: keys of failures to ignore. They do not end the run.
        place: returns the cause of a failure if no rule has fired.
        sequences: the sequences of the program.
        rules: number of times each rule has fired so far.
        broken: the failure that stopped the CPU.
        spent_ns: estimated time of the checks so far, ns.
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
    _explanations: list[str] = field(default_factory=list)  # sentences of this scan's events
    _fired: dict[int, list[str]] = field(default_factory=dict)  # ids of fired rules, by scan

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Record a rule that fires, or a message of an adapter."""
        if fields.get("kind") in SENTENCES:
            name = str(fields["name"])
            self._explanations.append(f"{fields['text']} [{name}]")
            if fields["kind"] == "rule":
                self.rules[name] += 1
                self._fired.setdefault(scan, []).append(name)

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Check every invariant if the scan was completed."""
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
        """Return whether a failure is new. Record a new failure."""
        broken = self._broken_invariant(watched.invariant.name, watched.invariant.sentence, why)
        origin_scan = getattr(watched.watch, "origin_scan", broken.scan)
        broken = replace(broken, cause=self._refusing_rule(origin_scan) or self.place())
        if broken.key in self.known:
            return False
        self.broken = broken
        return True

    def _refusing_rule(self, scan: int) -> str:
        """Return the first rule by which a module refused a command in a scan; empty if there is none."""
        refusals = [profile_of(slot.words).refusals for slot in self.cpu.rack.slots.values()]
        for rule in self._fired.get(scan, ()):
            if any(rule in slot_refusals for slot_refusals in refusals):
                return rule
        return ""

    def has_running_clock(self) -> bool:
        """Return whether the clock of any invariant is running."""
        return any(getattr(watched.watch, "waiting", False) for watched in self.watched)

    def same_until_ns(self, counting: bool) -> int:
        """Return the instant before which no invariant's result changes, see `Watch`; 0 if unknown."""
        methods = [getattr(watched.watch, "same_until_ns", None) for watched in self.watched]
        return min((0 if method is None else method(counting) for method in methods), default=FOREVER_NS)

    def note_goals(self, note: Callable[[str, Hashable, int], None]) -> None:
        """Make the goals call `note` when they are reached."""
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

    def _broken_invariant(self, name: str, sentence: str, why: str) -> BrokenInvariant:
        """Return the record of an invariant that is broken in this scan, still without a cause."""
        snapshot = self.snapshot
        shows = tuple(f"slot {number}: {slot}" for number, slot in snapshot.slot.items())
        shows += self._waits_at_fault or self._wait_sentences(snapshot.scan)
        rules = tuple(self._explanations)
        return BrokenInvariant(name, sentence, snapshot.scan, snapshot.ns, why, shows=shows, rules=rules)

    def _wait_sentences(self, scan: int) -> tuple[str, ...]:
        """Return a sentence for each wait of the program's sequences."""
        return tuple(str(wait_of(sequence, scan)) for sequence in self.sequences)

    def failure_of(self, fault: Fault) -> BrokenInvariant:
        """Return the failure for a fault of the CPU."""
        self.snapshot.scan, self.snapshot.ns = fault.scan, fault.now_ns
        why = f"{fault.text} [{fault.where}]"
        broken = self._broken_invariant(NO_FAULT, "The program does not fault the CPU", why)
        return replace(broken, cause=HANGS if fault.cause is Cause.WATCHDOG else Path(fault.where).name)


Listeners = Callable[[RackSpec, Rack, ScanLogic], Iterable[ScanListener]]
"""Returns additional listeners of a run for its rack and logic."""


def _no_listeners(_spec: RackSpec, _rack: Rack, _logic: ScanLogic) -> Iterable[ScanListener]:
    return ()


def _state_of(logic: ScanLogic) -> ProgramState:
    program = unwrapped(logic)
    if isinstance(program, Engine):
        return ProgramState()
    return ProgramState(getattr(program, "__dict__", {}), namespace_of(program))


UNPLACED = "?"
"""Cause of a failure that needs a line. The run is repeated with traced lines to find it."""

TRACED_BEFORE = 20
"""Number of traced scans before a failure. If no output changes in them, more scans are traced."""


@dataclass(frozen=True, slots=True)
class TrialBench:
    """Runs scenarios on the same rack, program and invariants."""

    spec: RackSpec
    fresh_logic: Callable[[], ScanLogic]  # creates the logic of a run
    invariants: Sequence[Invariant]
    scans: int  # length of a run
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
            listeners: returns additional listeners.
            probe: records the changes in the run.
            explored: states of other runs. A run with a probe can end in one of them.
            aloud: whether to show the program's output.
            every_scan: False = skip scans that repeat the previous scan; only without `listeners`.

        Raises:
            InvariantError: an invariant raised.
        """
        start_ns = wall_ns()
        ignored = frozenset(without)
        stop = None if explored is None else explored.begin(scenario, self.spec)
        run = _Run(self, scenario, ignored, every_scan=every_scan, probe=probe, explored_stop=stop)
        verdict = run.go(listeners, aloud=aloud)
        if verdict.broken is not None and verdict.is_unplaced:
            verdict = self._run_traced(scenario, ignored, verdict.broken.scan, every_scan=every_scan)
        building_ns = wall_ns() - start_ns - sum(verdict.spent.values())
        return replace(verdict, spent={**verdict.spent, BUILDING: building_ns})

    def _run_traced(
        self, scenario: Scenario, ignored: frozenset[str], scan: int, *, every_scan: bool
    ) -> Verdict:
        """Repeat a run that fails in a scan, to find the last line that changed an output before."""

        def run_traced(since: int) -> tuple[_Run, Verdict]:
            run = _Run(self, scenario, ignored, traced_since=since, every_scan=every_scan)
            return run, run.go(_no_listeners, aloud=False)

        run, verdict = run_traced(max(0, scan - TRACED_BEFORE))
        if verdict.is_unplaced:
            run, verdict = run_traced(run.last_output_change)
        if verdict.is_unplaced:
            _, verdict = run_traced(0)
        return verdict


@dataclass(frozen=True, slots=True)
class _OrderDesk:
    """Applies a scenario's orders to the tags of a program."""

    tags: Any

    def force(self, tag: str, value: object) -> None:
        """Refuse to force a tag."""
        raise ValueError(f"{tag}: a scenario can write a tag, but it can force only image bits and words")

    def unforce(self, tag: str | None = None) -> None:
        """Do nothing, since no tag is forced."""


class _Run:
    """One run with a new rack, a new logic, and new watches.

    Args:
        without: names of invariants to skip, and keys of failures to ignore.
        traced_since: first scan with traced lines, see `OutputLine`; None = trace no scan.
        every_scan: False = skip scans that repeat the previous scan, see `repeated_scans`.
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
        """Create the rack, the logic and the watches. The probe prepares the logic before it is wrapped."""
        self._scans, self._scenario = bench.scans, scenario
        self._every_scan, self._explored_stop = every_scan, explored_stop
        self._without = without
        self._printed = _LineCounter()
        self._spec = scenario.laid_over(bench.spec)
        self._rack = build_rack(self._spec)
        with self._redirected_output(aloud=False):
            logic = self._logic = bench.fresh_logic()
        self._probe = probe
        if probe is not None:
            logic = probe.prepared(logic)
            probe.watch(logic, self._rack)
        self._wrap_logic(logic, traced_since)
        invariants = [invariant for invariant in bench.invariants if invariant.name not in without]
        watches = [_WatchedInvariant(invariant, invariant.start()) for invariant in invariants]
        self._watcher = _Watcher(watches, known=without, place=self._cause)
        tags = getattr(unwrapped(logic), "tags", {})
        self._watcher.snapshot = Snapshot(self._rack, tags, axes_in(logic, tags), _state_of(logic))
        self._watcher.sequences = sequences_in(logic)
        if probe is not None:
            self._watcher.note_goals(probe.edges.add)

    def _wrap_logic(self, logic: ScanLogic, traced_since: int | None) -> None:
        """Wrap the logic in tears, tracing and time measurement, from the inside out."""
        scenario = self._scenario
        self._torn = TornScans(logic, scenario.tears, self._spec.scan_ns) if scenario.tears else None
        torn_logic: ScanLogic = self._torn or logic
        self._output_line: OutputLine | None = None
        if traced_since is not None:
            self._output_line = OutputLine(torn_logic, self._rack, traced_since)
        self._timed = _TimedLogic(self._output_line or torn_logic)

    def go(self, listeners: Listeners, *, aloud: bool) -> Verdict:
        """Run the scenario and return the verdict.

        Raises:
            InvariantError: an invariant raised.
            ValueError: an order in the scenario can't be applied.
        """
        watcher = self._watcher
        probes = [] if self._probe is None else [self._probe]
        all_listeners = [*listeners(self._spec, self._rack, self._logic), *probes, watcher]
        watcher.cpu = cpu = build_cpu(self._spec, self._timed, self._rack, listeners=all_listeners)
        if self._torn is not None:
            self._torn.cpu = cpu
        if not self._every_scan:
            self._pass_over_repeats(cpu)
        repeater = self._order_repeater(cpu)
        start_ns = wall_ns()
        try:
            with self._redirected_output(aloud=aloud):
                self._run_scans(cpu)
                cpu.close()
        except CpuFault as error:
            if error.fault.cause is Cause.LISTENER and error.__cause__ is not None:
                raise error.__cause__ from None  # an invariant raised it, not the program
            broken = watcher.failure_of(error.fault)
            watcher.broken = None if {NO_FAULT, broken.key} & self._without else broken
        if repeater is not None and repeater.refused:
            raise ValueError(f"scenario: {repeater.refused[0]}")
        spent = {PROGRAM: self._timed.spent_ns, JUDGING: watcher.spent_ns}
        spent[RUNNING] = wall_ns() - start_ns - sum(spent.values())
        return Verdict(
            scans=cpu.scan,
            rules=watcher.rules,
            broken=watcher.broken,
            spent=spent,
            applied=watcher.applied,
            printed=self._printed.lines,
            greatest=watcher.greatest,
        )

    def _pass_over_repeats(self, cpu: Cpu) -> None:
        """Make the CPU skip scans that repeat the previous scan, if it runs a ladder program."""
        engine, spec = unwrapped(self._timed), self._spec
        if not isinstance(engine, Engine) or spec.scan_ns % NS_PER_MS:
            return
        clocks = clocks_of(engine.lowered)
        if clocks is None:
            return
        stops = stops_of(self._instants_ns(), spec.scan_ns)
        if self._explored_stop is not None:
            self._explored_stop.calm = RARELY
        cpu.pass_over_repeats(RepeatedScans(engine, clocks, spec.scan_ns, stops, self._watcher.same_until_ns))

    def _instants_ns(self) -> Iterator[int]:
        """Yield the instants at which an event of this run begins or ends."""
        for part in (*timed_parts(self._scenario), *self._spec.incidents):
            yield part.at_ns
            yield end_ns(part)

    def _run_scans(self, cpu: Cpu) -> None:
        """Run the scans.

        With a probe, end in an explored state, and learn the states of a run without failure.
        """
        if self._explored_stop is None or self._probe is None:
            cpu.run(self._scans)
            return
        self._explored_stop.run(cpu, self._probe, self._scans, self._watcher.has_running_clock)
        if self._watcher.broken is None:
            self._explored_stop.learn()

    def _order_repeater(self, cpu: Cpu) -> OrderRepeater | None:
        """Return a listener that applies the scenario's orders; None without orders."""
        orders, scan_ns = self._scenario.orders, self._spec.scan_ns
        if not orders:
            return None
        actions = [AppliedAction(order.at_ns // scan_ns, order.order) for order in orders]
        desk = _OrderDesk(self._watcher.snapshot.tags)
        repeater = OrderRepeater(cpu, OperatorActions(cpu, self._rack, desk), actions)
        cpu.add_listener(repeater)
        repeater.begin()
        return repeater

    @property
    def last_output_change(self) -> int:
        """The last untraced scan that changed outputs; 0 if there is none."""
        return 0 if self._output_line is None else self._output_line.changed_in

    def _cause(self) -> str:
        """Return the line that last changed an output word; `UNPLACED` if it was not traced.

        If no line changed the word, return the waits of the sequences. If none waits, return the commands in
        force.
        """
        if self._output_line is None or not self._output_line.is_complete:
            return UNPLACED
        return self._output_line.last or self._waits() or self._commands()

    def _waits(self) -> str:
        """Return the waiting sequences of the program with their lines; empty if none waits."""
        return " ".join(
            f"{sequence.name} at {Path(sequence.file or '').name}:{sequence.line}"
            for sequence in self._watcher.sequences
            if not sequence.over
        )

    def _commands(self) -> str:
        """Return the commands in force."""
        slots = self._watcher.snapshot.slot.values()
        return " ".join(name for slot in slots for name in slot.commands)

    @contextmanager
    def _redirected_output(self, *, aloud: bool) -> Iterator[None]:
        """Count the lines of the program's output instead of showing them, unless `aloud`."""
        if aloud:
            yield
        else:
            with redirect_stdout(self._printed), redirect_stderr(self._printed):
                yield
