r"""A controller: shared tags, programs with their own tags and routines, and tasks.

>>> from scanrack.ladder import ADD, BOOL, Controller, DINT, OTE, XIC
>>> plant = Controller("plant")
>>> run = plant.declare("Run", BOOL)
>>> main, fast = plant.program("Main"), plant.program("Fast")
>>> lamp = main.declare("Lamp", BOOL)
>>> count = fast.declare("Count", DINT)
>>> @main.routine
... def Step(rung):
...     rung(run, OTE(lamp))
>>> @fast.routine
... def Step(rung):
...     rung(ADD(count, 1, count))
>>> plant.task("Cycle", "Main")
>>> plant.task("Every20", "Fast", rate_ms=20)
>>> plant.tags.Run = True
>>> for _ in range(5):
...     plant.step(10)
>>> plant.tags[r"\Main.Lamp"], plant.tags[r"\Fast.Count"]
(True, 3)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Self

from scanrack.io_images.times import exact_ns
from typing_extensions import override

from ..model.errors import LadderError, Problem
from ..model.routine import Routine
from ..model.schedule import Task, TaskKind, schedule_of
from ..model.tags import Declaration, scoped
from ..state.lowered import LoweredProgram
from .program import Program
from .runnable import LadderLogic

IMPLICIT_TASK = "MainTask"
"""Name of the default continuous task, which runs all programs in order."""


class Controller(LadderLogic):
    r"""Shared tags, programs and tasks.

    Names in a program refer to its own tags first, then to the controller's; `\Main.Run` is the tag Run of
    program Main, in any program. Full names of routines are `\Main.Step`; their name in the program is
    `Step`.
    """

    kind = "controller"

    def __init__(self, name: str, *, allow: tuple[str, ...] = ()) -> None:
        super().__init__(name, allow=allow)
        self.programs: list[Program] = []
        self.tasks: list[Task] = []

    # --- declaring

    def program(self, name: str, *, main: str | None = None, fault: str | None = None) -> Program:
        """Add and return an empty program; `main` (by default, the first) and `fault` name its routines."""
        self._refuse_if_built()
        if not name.isidentifier() or not name.isascii():
            raise LadderError(f"{name!r} is not a program name; use letters, digits and _")
        if name.upper() in (existing.name.upper() for existing in self.programs):
            raise LadderError(f"there are two programs {name}")
        program = Program(name, main=main, fault=fault)
        program.join(self)
        self.programs.append(program)
        return program

    def task(
        self,
        name: str,
        *programs: str,
        rate_ms: float | None = None,
        event: bool = False,
        priority: int = 10,
        preempt: bool = False,
        comment: str = "",
    ) -> None:
        """Add a task: periodic with `rate_ms`, an event task with `event`, otherwise continuous.

        Args:
            programs: names of its programs, in order of execution.
            rate_ms: period, ms.
            priority: 1 to 15; 1 runs first.
            preempt: whether it can also run after any rung of the continuous task.

        Raises:
            LadderError: see `Task`; or both `rate_ms` and `event` are given.
        """
        if event and rate_ms is not None:
            raise LadderError(f"task {name} has both a rate and event=True; use one")
        kind = TaskKind.EVENT if event else TaskKind.CONTINUOUS if rate_ms is None else TaskKind.PERIODIC
        try:
            rate_ns = exact_ns(rate_ms or 0, "ms", f"task {name}: rate")
        except ValueError as error:
            raise LadderError(str(error)) from None
        self.add_task(
            Task(name, kind, programs, rate_ns, priority=priority, preempt=preempt, comment=comment)
        )

    def add_task(self, task: Task) -> None:
        """Add a task with a new name, or raise a LadderError."""
        self._refuse_if_built()
        if task.name.upper() in (existing.name.upper() for existing in self.tasks):
            raise LadderError(f"there are two tasks {task.name}")
        self.tasks.append(task)

    @override
    def copied(self) -> Self:
        result = super().copied()
        result.programs = [original.copied() for original in self.programs]
        for program in result.programs:
            program.join(result)
        return result

    # --- reading

    @property
    @override
    def routines(self) -> list[Routine]:
        return [
            replace(routine, name=scoped(program.name, routine.name))
            for program in self.programs
            for routine in program.routines
        ]

    @property
    @override
    def functions(self) -> Mapping[str, Callable[..., Any]]:
        return {
            scoped(program.name, name): function
            for program in self.programs
            for name, function in program.functions.items()
        }

    @property
    def overlaps(self) -> dict[str, int]:
        """Overlaps by task name: the number of times that the task was due again before it had run."""
        schedule = self.build().schedule
        tasks = schedule.tasks if schedule else ()
        return {task.task.name: int(self.engine.memory.read(task.overlaps)) for task in tasks}

    # --- building

    @override
    def _lower(self) -> tuple[LoweredProgram, list[Problem]]:
        """Lower the tasks, by default one for all programs, and the programs; return warnings too."""
        self._declare_missing(self.programs)
        layout = self.layout_of(self._all_declarations())
        lowering = self.lowering(layout, "")
        problems = list(self._task_problems())
        tasks = self.tasks or [Task(IMPLICIT_TASK, TaskKind.CONTINUOUS, tuple(self._program_names()))]
        if not problems:
            roots = [scope.roots(scope.name) for scope in self.programs]
            lowering.lowered.schedule = schedule_of(layout, tasks, roots)
        for program in self.programs:
            problems += program.lower_into(lowering, program.name)
        lowered, warnings = self._checked(lowering, problems)
        return lowered, [*warnings, *self._idle_program_warnings(tasks)]

    def _all_declarations(self) -> Iterator[Declaration]:
        yield from self.declarations
        for program in self.programs:
            for declaration in program.declarations:
                yield replace(declaration, name=scoped(program.name, declaration.name))

    def _program_names(self) -> list[str]:
        return [program.name for program in self.programs]

    def _task_problems(self) -> Iterator[Problem]:
        """Yield problems with the tasks, and with the programs assigned to them."""
        controller_place = f"controller {self.name}"
        if not self.programs:
            yield Problem(controller_place, "", "no program", "add a program")
        program_names = {program.upper() for program in self._program_names()}
        scheduled: dict[str, str] = {}
        continuous = [existing.name for existing in self.tasks if existing.kind is TaskKind.CONTINUOUS]
        if len(continuous) > 1:
            names = " and ".join(continuous)
            yield Problem(controller_place, "", f"tasks {names} are continuous", "add a rate to all but one")
        for task in self.tasks:
            for name in task.programs:
                if name.upper() not in program_names:
                    programs = f"programs are {', '.join(self._program_names())}"
                    yield Problem(f"task {task.name}", "", f"no program {name}", programs)
                elif name.upper() in scheduled:
                    text = f"program {name} is in task {scheduled[name.upper()]} already"
                    yield Problem(f"task {task.name}", "", text, "a program is in one task")
                scheduled[name.upper()] = task.name

    def _idle_program_warnings(self, tasks: list[Task]) -> Iterator[Problem]:
        """Yield a warning for each program that no task runs."""
        scheduled = {name.upper() for task in tasks for name in task.programs}
        for name in self._program_names():
            if name.upper() not in scheduled:
                yield Problem(
                    f"program {name}", "", "no task runs it", "name it in a task", rule="unreachable"
                )
