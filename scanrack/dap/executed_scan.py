"""An executed scan, with its rungs in execution order and the values before each rung.

    order     0      1      2      3      4      5           end
    rung      Main 0        AOI 0  AOI 1  Main 1
    writes           A             B             C
    before Main 1: the values at the end, without C

A scan is always finished, as in a controller. An editor steps through the finished scan, forward or backward
at the same cost.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property, partial
from itertools import chain

from scanrack.ladder.debug.cells import cells_of
from scanrack.ladder.debug.executed import Execution, LineRun, StepRun, TracedEngine
from scanrack.ladder.debug.replay import Replayer
from scanrack.ladder.model.operands import Calculation, Group, Place
from scanrack.ladder.model.tags import program_of
from scanrack.ladder.model.tree import Origin
from scanrack.ladder.model.types import HIDDEN
from scanrack.ladder.state.lowered import AddOnCall
from scanrack.ladder.state.snapshots import restore, snapshot

from .conditions import EngineValues
from .protocol import DebugError, Json
from .variables import parts_of, size_of, tags_in, tags_of, type_text
from .view import Node, Stop, Tree, View


class ExecutedScan(View):
    """A rerun of a ladder scan, compiled for its final values and interpreted for its instructions.

    Args:
        replayer: runs the scans; it must not be used for anything else until `leave`.

    Raises:
        DebugError: the scan can't be repeated.
    """

    def __init__(self, replayer: Replayer, scan: int) -> None:
        assert isinstance(replayer.engine, TracedEngine)
        self.scan, self.engine = scan, replayer.engine
        self._replayer = replayer
        self.tags, self.values = self.engine.tags, EngineValues(self.engine)
        if not replayer.show(scan):
            raise DebugError(f"scan {scan:,} can no longer be repeated")
        self._end = snapshot(self.engine.memory)

    @cached_property
    def execution(self) -> Execution:
        """The execution of the scan, which sets the memory to the values at the end of the scan."""
        self.engine.traced = True
        try:
            self._replayer.again(self.scan)
        finally:
            self.engine.traced = False
        execution = self.engine.execution
        return execution if execution is not None and execution.scan == self.scan else Execution(self.scan)

    @cached_property
    def stops(self) -> Sequence[Stop]:
        """The places before rungs and instructions, in the order of execution."""
        return sorted(self._stops(), key=lambda stop: (stop.order, stop.depth))

    def _stops(self) -> Iterator[Stop]:
        """Yield a stop before each rung, and before each of its later instructions.

        A stop's order is that of the last executed instruction. Instructions of a call, such as the copies of
        its parameters, have no stop.
        """
        for run in self.execution.runs.values():
            if run.line.number < 0:  # the line of a whole chart
                continue
            depth = len(list(callers(run)))
            yield Stop(run.order, run, None, depth)
            instructions = [step for step in run.steps.values() if step.parent is None]
            yield from (Stop(step.order - 1, run, step, depth) for step in instructions[1:])

    def show(self, order: int | None) -> None:
        """Set the engine's memory to the values after an instruction; with None, at the end of the scan."""
        self._replayer.at = None
        memory = self.engine.memory
        restore(memory, self._end)
        if order is not None:
            for write in reversed(self.execution.writes):
                if write.order <= order:
                    break
                memory.write(write.cell.leaf, write.cell.index, write.before)

    def set(self, tag: str, value: object) -> None:
        """Show a value that was set after the scan, until another place is shown."""
        self.engine.tags[tag] = value

    def leave(self) -> None:
        """Release the replayer."""
        restore(self.engine.memory, self._end)
        self._replayer.at = self.scan

    def last_write(self, tag: str) -> tuple[int, int | None] | None:
        """See `View`."""
        cells = cells_of(self.tags.where(tag), counts=True) if tag in self.tags else []
        writes = [write for write in self.execution.writes if any(map(write.changes, cells))]
        if not writes or writes[-1].writer is None:
            return None
        run, order = writes[-1].writer.run, writes[-1].order
        indices = [index for index, stop in enumerate(self.stops) if stop.run is run and stop.order < order]
        return (indices[-1], order) if indices else None

    # --- frames and scopes

    def frame(self, run: LineRun) -> str:
        """See `View`."""
        name = f"{self._spelled(run)}, {self.engine.lowered.routines[run.routine].unit} {run.line.number}"
        return f"{name} of {run.instance}" if run.instance else name

    def _spelled(self, run: LineRun) -> str:
        """Return the name of a routine as spelled in the program."""
        spelling: str = self.engine.lowered.routines[run.routine].name
        return spelling

    def program(self, run: LineRun | None) -> str:
        """Return the program of a rung; "" if there are no tasks, or outside of rungs."""
        return "" if run is None else program_of(self._spelled(run))

    def task(self, run: LineRun) -> str:
        """See `View`."""
        schedule = self.engine.lowered.schedule
        program = program_of(run.routine).upper()
        for task in () if schedule is None else schedule.tasks:
            if any(entry.name.upper() == program for entry in task.programs):
                return str(task.task.name)
        return ""

    def last_origin(self) -> Origin | None:
        """See `View`; this is the last rung of the main routine."""
        lowered = self.engine.lowered
        tasks = () if lowered.schedule is None else lowered.schedule.tasks
        mains = [lowered.main, *(program.main or "" for task in tasks for program in task.programs)]
        routine = next((lowered.routines[main] for main in mains if main in lowered.routines), None)
        return None if routine is None or not routine.lines else routine.lines[-1].origin

    def full_name(self, name: str, run: LineRun | None) -> str | None:
        """See `View`."""
        candidates = [f"{run.instance}.{name}"] if run is not None and run.instance else []
        if program := self.program(run):
            candidates.append(f"\\{program}.{name}")
        candidates.append(name)
        return next((candidate for candidate in candidates if candidate in self.tags), None)

    def names(self, run: LineRun | None) -> Sequence[tuple[str, str]]:
        """See `View`."""
        program = self.program(run)
        return [*(tags_of(self.engine, program) if program else []), *tags_of(self.engine, "")]

    def scopes(self, tree: Tree, run: LineRun | None) -> Iterator[tuple[str, Node]]:
        """See `View`."""
        engine, program = self.engine, self.program(run)
        if run is not None:
            yield "Rung", partial(tags_in, tree, self._named_in(run))
            if run.instance and run.instance in engine.tags:
                group = engine.tags.where(run.instance)
                assert isinstance(group, Group)
                yield "Locals", partial(parts_of, tree, run.instance, group, files=self._files)
        counter_tags = tags_of(engine, program, counted=True)
        counter_tags += tags_of(engine, "", counted=True) if program else []
        if counter_tags:
            yield "Timers", partial(tags_in, tree, counter_tags)
        if program and (program_tags := tags_of(engine, program)):
            yield f"Tags of {program}", partial(tags_in, tree, program_tags)
        yield "Tags", lambda: tags_in(tree, tags_of(engine, ""))

    def _named_in(self, run: LineRun) -> list[tuple[str, str]]:
        """Return the tags in a rung, as pairs of the name used in the rung and the full name."""
        program = self.program(run)
        operands = (operand for step in run.line.all_steps for operand in step.operands)
        full_names: dict[str, str] = {}
        for name in chain.from_iterable(map(_tag_names, operands)):
            scoped = f"\\{program}.{name}" if program else name
            full_name = scoped if scoped in self.tags else name
            if full_name in self.tags and HIDDEN not in name:
                full_names[name] = full_name
        return list(full_names.items())

    def value(self, tree: Tree, name: str, address: str) -> Json:
        """See `View`."""
        place = self.tags.where(address)
        fields: Json = {"name": name, "evaluateName": address, "type": type_text(place)}
        if isinstance(place, Place) or isinstance(self.tags[address], str):
            return {**fields, "value": tree.text(address, self.tags[address])}
        node = partial(parts_of, tree, address, place, files=self._files)
        return {**fields, "value": type_text(place), "node": node, **size_of(place)}

    @property
    def _files(self) -> bool:
        """Whether the program has data files."""
        return self.engine.lowered.layout.files

    def described(self, tag: str) -> Iterator[str]:
        """See `View`."""
        declared = self.engine.lowered.layout.declarations.get(tag.upper())
        if (target := getattr(declared, "target", None)) is not None:
            yield f"alias of {target}"
        yield getattr(declared, "comment", "")

    def own_word(self, slot: int, image: str, number: int) -> int | None:
        """See `View`."""
        memory = self.engine.memory
        for leaf in memory.layout.images:
            if leaf.slot == slot and leaf.output is (image == "O"):
                return int(memory.read(leaf, number)) if memory.has(leaf) else None
        return None


def _tag_names(operand: object) -> Iterator[str]:
    """Yield the tag names in an operand of an instruction."""
    if isinstance(operand, AddOnCall):
        yield operand.instance.text
        yield from (argument.text for argument in operand.handed.values())
    elif isinstance(operand, Place | Group):
        if not operand.frame:  # locals are their own scope
            yield operand.text
    elif isinstance(operand, Calculation):
        for inner in operand.operands:
            yield from _tag_names(inner)


def callers(run: LineRun) -> Iterator[StepRun]:
    """Yield the instructions that call the routine of a rung, innermost first."""
    step = run.caller
    while step is not None:
        yield step
        step = step.run.caller
