"""Replay of a solver's scenario on the compiled program; the program's memory decides the verdict."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from ..model.arithmetic import wrap
from ..model.errors import LadderFault
from ..run.edit import started_again
from ..run.engine import Engine
from .algebra.evaluation import Evaluator
from .algebra.terms import T, reach, variables
from .monitors import run_claims
from .system import (
    CLOCK,
    DT,
    FIRST_SCAN,
    OFF,
    RETAINED,
    TURNED,
    WRITTEN,
    Key,
    ProgramSystem,
    Runnable,
    System,
    ms_of,
)
from .system.transition import MS

Values = Mapping[str, Any]
"""Values of variables in a scan, by name."""

Broken = Callable[[Engine, "dict[str, Any]"], bool]
"""Returns whether a scan broke the property, given the engine after the scan and the variables before it."""


@dataclass(frozen=True, slots=True)
class ScanOf:
    """A scan of a scenario."""

    ms: float  # time since the previous scan
    inputs: dict[Key, Any]  # inputs that change before it
    turned: bool = False  # the key is turned to program and back before it
    again: bool = False  # it is the first scan of a run that begins with the tags of the previous run

    def do(self, engine: Engine) -> None:
        """Run the scan on an engine; may raise a LadderFault."""
        self.write_inputs(engine)
        if self.turned:
            engine.prescan()
        engine.step(self.ms)

    def write_inputs(self, engine: Engine) -> None:
        """Write the inputs that change; skip any that the program does not have."""
        for (path, index), value in self.inputs.items():
            leaf = engine.lowered.layout.find(path)
            if leaf is not None and index < leaf.size:
                engine.memory.write(leaf, index, value)


def done_by(program: Runnable, scans: Sequence[ScanOf]) -> tuple[Engine, LadderFault | None]:
    """Run scans on a compiled program; return its engine, and the major fault that stopped it, if any."""
    engine = program.compile()
    for scan in scans:
        if scan.again:
            engine = started_again(engine, program.compile())
        try:
            scan.do(engine)
        except LadderFault as fault:
            run_claims(engine)
            return engine, fault
    return engine, None


@dataclass(slots=True)
class ReplayedRun:
    """The result of replaying a scenario.

    Attributes:
        confirmed: whether the program breaks the property, as in the solver's model.
        fault: the major fault, if any, that ended the run in its last scan or earlier.
        computed: the values that instructions without a model computed, by scan and variable.
        scans_done: number of scans without a fault.
        differs: places where the relation and the program differ, which is a defect unless an unmodeled
            instruction decides them.
    """

    confirmed: bool = False
    fault: LadderFault | None = None
    computed: dict[tuple[int, str], Any] = field(default_factory=dict)
    differs: tuple[Key, ...] = ()
    scans_done: int = 0


class Run:
    """A run of the compiled program with given inputs."""

    def __init__(self, problem: ProgramSystem) -> None:
        self.problem, self.engine, self._started = problem, problem.program.compile(), False
        self.before: dict[str, Any] = {}  # values of all variables before the latest scan
        self._chosen: Values = {}  # in the latest scan
        self._chosen_before: Values = {}  # in the scan before it
        self.set_bits: dict[Key, int] = {}  # numbers that had bits written before the latest scan

    def scan(self, values: Values) -> dict[str, Any]:
        """Run a scan with a solver's values; return the values of all variables before it."""
        problem, memory = self.problem, self.engine.memory
        if is_again(self._chosen):
            self.engine = started_again(self.engine, problem.program.compile())
            memory = self.engine.memory
        for name, value in values.items():
            key = problem.key_of.get(name)
            if key is not None and problem.role(name) == "free":
                memory.write(problem.machine.leaves[key], key[1], value)
        self._write_bits()
        off, self._chosen_before = off_ticks(self._chosen, problem.tick_ns), self._chosen
        if is_turned(self._chosen) or is_again(self._chosen):
            self.engine.prescan()
        self._chosen = values
        ticks = values.get(DT, problem.least)
        self.before = self._before(off) if self._started else dict(problem.initial)
        self.before.update(values)
        self.before[DT] = ticks
        self._started = True
        self.engine.step(ms_of(ticks + off, problem.tick_ns))
        return self.before

    def _write_bits(self) -> None:
        """Write the bits that change from outside after the previous scan."""
        self.set_bits = {}
        for key, mask in self.problem.open.items():
            bits = self._chosen.get(f"{WRITTEN}{self.problem.machine.vars[key].val}")
            leaf = self.problem.machine.leaves[key]
            if bits is None:
                continue
            word = int(self.engine.memory.read(leaf, key[1]))
            after = wrap(word & ~mask | int(bits) & mask, leaf.type.wraps)
            if after != word:
                self.engine.memory.write(leaf, key[1], after)
                self.set_bits[key] = after

    def _before(self, off: int) -> dict[str, Any]:
        """Return the values of all variables before a scan; `off` is the time in program mode in ticks."""
        problem, engine = self.problem, self.engine
        values: dict[str, Any] = {}
        for key, variable in problem.machine.vars.items():
            value = engine.memory.read(problem.machine.leaves[key], key[1])
            if key[0].endswith(CLOCK):
                value = min(variable.hi, max(0, engine.now_ns - int(value)) // problem.tick_ns + off)
            elif key == FIRST_SCAN and problem.lowered.schedule is None:
                value = is_turned(self._chosen_before) or is_again(self._chosen_before)
            values[variable.val] = value
        return values

    def after(self, key: Key) -> Any:
        """Return the current value of a place."""
        return self.engine.memory.read(self.problem.machine.leaves[key], key[1])


def is_turned(values: Values) -> bool:
    """Return whether the key is turned to program and back after a scan."""
    return bool(values.get(TURNED, False))


def is_again(values: Values) -> bool:
    """Return whether the run ends after a scan and the next run starts with the same tags."""
    return bool(values.get(RETAINED, False))


def off_ticks(values: Values, tick_ns: int) -> int:
    """Return the number of ticks, at most one hour, in program mode after a scan."""
    is_off = is_turned(values) and not is_again(values)
    return min(int(values.get(OFF, 0)), MOST_OFF_MS * MS // tick_ns) if is_off else 0


MOST_OFF_MS = 3_600_000
"""Longest time in program mode in a scenario, in ms; the solver may choose a longer time."""


def replay(problem: ProgramSystem, scans: Sequence[Values], broken: Broken) -> ReplayedRun:
    """Run a scenario; return whether its last scan breaks the property, and the computed values."""
    run, result = Run(problem), ReplayedRun()
    before: dict[str, Any] = {}
    # states that are no places of the program, such as the values before the previous scan
    remembered = [name for name in problem.next if name not in problem.key_of]
    remember = Evaluator([problem.next[name] for name in remembered])
    for number, values in enumerate(scans):
        remembered_values = dict(zip(remembered, remember(before), strict=True)) if number else {}
        try:
            before = run.scan(values) | remembered_values
        except LadderFault as fault:
            result.fault = fault
            _learn_fault(problem, fault, number, result)
            if number + 1 == len(scans):
                run_claims(run.engine)
                result.confirmed = broken(run.engine, run.before | remembered_values)
            return result
        result.scans_done += 1
        result.computed |= {(number, name): False for name in problem.machine.may_fault}
        if problem.unmodeled:
            _learn(problem, run, number, before, result)
        _learn_written(problem, run, number, result)
        if not all(run.after(key) for key in problem.assume):
            return result
    result.confirmed = broken(run.engine, before)
    if not result.confirmed:
        computed_names = {name for scan, name in result.computed if scan == len(scans) - 1}
        result.differs = _differences(problem, run, before, problem.unmodeled.keys() - computed_names)
    return result


def _learn_fault(problem: ProgramSystem, fault: LadderFault, number: int, result: ReplayedRun) -> None:
    """Store the instruction without a model that faulted in a scan."""
    names = [name for name, site in problem.machine.may_fault.items() if site == fault.site]
    if len(names) == 1:
        result.computed[number, names[0]] = True


def _learn_written(problem: ProgramSystem, run: Run, number: int, result: ReplayedRun) -> None:
    """Store values that the processor itself wrote, such as its clocks in a status file."""
    for name, key in problem.key_of.items():
        variable = problem.machine.vars[key]
        if problem.is_written_beside(key[0]) and problem.machine.state[key] is variable:
            result.computed[number, name] = run.after(key)


def _learn(
    problem: ProgramSystem, run: Run, number: int, variable_values: dict[str, Any], result: ReplayedRun
) -> None:
    """Find the values that instructions without a model computed, if still visible after the scan."""
    for _ in range(3):  # one value can select the place that shows another
        values = _seen_havocs(problem, run, variable_values)
        if all(variable_values.get(name) == value for name, value in values.items()):
            break
        variable_values.update(values)
    for name, value in values.items():
        result.computed[number, name] = value


def _seen_havocs(problem: ProgramSystem, run: Run, variable_values: Values) -> dict[str, Any]:
    """Return the values of unmodeled variables that are visible in a place after a scan, by name."""
    keys = [key for key in problem.machine.written if problem.machine.state[key].op in ("ite", "var")]
    keys.sort()
    roots = [problem.machine.state[key] for key in keys]
    conditions = [node.args[0] for node in reach(roots) if node.op == "ite"]
    values = dict(
        zip([condition.id for condition in conditions], Evaluator(conditions)(variable_values), strict=True)
    )
    havocs: dict[str, Any] = {}
    for key, root in zip(keys, roots, strict=True):
        term = root
        while term.op == "ite":  # go to the value that the place has in this scan
            term = term.args[1] if values[term.args[0].id] else term.args[2]
        if term.op == "var" and term.val in problem.unmodeled:
            havocs[term.val] = run.after(key)
    return havocs


def _differences(
    problem: ProgramSystem, run: Run, before: Values, unknown: Collection[str]
) -> tuple[Key, ...]:
    """Return the places whose values after the scan differ between the program and the relation.

    Args:
        unknown: variables with unknown values; places that depend on them are skipped.
    """
    machine = problem.machine
    keys = sorted(key for key in machine.written if not key[0].endswith(CLOCK))[:2000]
    if unknown:
        keys = [
            key
            for key in keys
            if not any(variable.val in unknown for variable in variables([machine.state[key]]))
        ]
    expected_values = Evaluator([machine.state[key] for key in keys])(before)
    return tuple(key for key, value in zip(keys, expected_values, strict=True) if value != run.after(key))[:3]


def breaks(problem: ProgramSystem, bad: T, key: Key | None = None) -> Broken:
    """Return a function that checks a property, which is a bit after the scan or a term before it."""
    if key is not None:
        leaf = problem.leaf(key)
        return lambda engine, _before: bool(engine.memory.read(leaf, key[1]))
    evaluator = Evaluator([bad])
    return lambda _engine, before: bool(evaluator(before)[0])


def first_broken(problem: ProgramSystem, scans: Sequence[Values], key: Key) -> int | None:
    """Return the first scan, from 0, after which a bit is true; None if no such scan precedes a fault."""
    run = Run(problem)
    with suppress(LadderFault):
        for number, values in enumerate(scans):
            run.scan(values)
            if not all(run.after(assumption) for assumption in problem.assume):
                return None
            if run.after(key):
                return number
    return None


def scenario(system: System, scans: Sequence[Values]) -> tuple[ScanOf, ...]:
    """Return the scans that a solver chose, with their times and the inputs that change."""
    chosen, current = [], dict(system.initial)
    bits = _bits_of(system, scans)
    for number, values in enumerate(scans):
        inputs: dict[Key, Any] = {}
        for name, value in values.items():
            key = system.key_of.get(name)
            if key is not None and system.role(name) == "free" and current.get(name) != value:
                inputs[key] = current[name] = value
        inputs |= bits[number] if number < len(bits) else {}
        earlier = scans[number - 1] if number else {}
        repeats = is_again(earlier)
        ticks = (
            values.get(DT, system.least) + off_ticks(earlier, system.tick_ns) if number and not repeats else 0
        )
        chosen.append(
            ScanOf(ms_of(ticks, system.tick_ns), inputs, is_turned(earlier) and not repeats, repeats)
        )
    return tuple(chosen)


def _bits_of(system: System, scans: Sequence[Values]) -> list[dict[Key, int]]:
    """For each scan, return the numbers with bits written from outside before it, and their new values."""
    bits: list[dict[Key, int]] = []
    if isinstance(system, ProgramSystem) and system.open:
        run = Run(system)
        with suppress(LadderFault):
            for values in scans:
                run.scan(values)
                bits.append(run.set_bits)
    return bits
