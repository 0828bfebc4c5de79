"""A ladder program: declare tags, add routines, run it.

>>> from scanrack.ladder import BOOL, OTE, Program
>>> motor = Program("motor")
>>> start, stop, run = motor.declare("Start Stop Run", BOOL)
>>> @motor.routine
... def Main(rung):
...     rung([start, run], ~stop, OTE(run))
>>> motor.tags.Start = True
>>> motor.step()
>>> motor.tags.Run
True
>>> print(motor.text("Main"))
[XIC(Start),XIC(Run)]XIO(Stop)OTE(Run);
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, Self

from typing_extensions import override

from ..model.errors import LadderError, Problem
from ..model.routine import Routine
from ..model.schedule import ProgramRoutines, Task, TaskKind, schedule_of
from ..model.tags import scoped
from ..model.types import Structure
from ..st import parse_statements
from ..state.lowered import LoweredProgram
from .dialects import LOGIX
from .python_rungs import RungMaker
from .rungs import Lowering
from .runnable import LadderLogic


class Program(LadderLogic):
    """Tags and routines, either standalone or as part of a `Controller`.

    A fault routine runs on a major fault of an instruction and can clear it (`SSV`). The rest of the
    program's scan is then skipped. For running a program, see `LadderLogic`.

    Attributes:
        main: the routine that a scan calls; by default the first one.
        fault: the routine that a major fault calls, or None.

    Args:
        allow: suppressed warnings; see `checks.ALLOWANCES`.
        dialect: instruction set; see `instructions.dialects`.
    """

    kind = "program"

    def __init__(
        self,
        name: str,
        *,
        main: str | None = None,
        fault: str | None = None,
        allow: Iterable[str] = (),
        dialect: str = LOGIX,
    ) -> None:
        super().__init__(name, allow=allow, dialect=dialect)
        self.main, self.fault = main, fault
        self._controller: LadderLogic | None = None
        self._routines: list[Routine] = []
        self._functions: dict[str, Callable[..., Any]] = {}

    def join(self, controller: LadderLogic) -> None:
        """Become part of a controller and share its add-on instructions and stubs."""
        self.add_ons, self.stubs = controller.add_ons, controller.stubs
        self._controller = controller

    @override
    def _refuse_if_built(self) -> None:
        super()._refuse_if_built()
        if self._controller is not None:
            self._controller._refuse_if_built()

    @property
    @override
    def routines(self) -> list[Routine]:
        return self._routines

    @property
    @override
    def functions(self) -> dict[str, Callable[..., Any]]:
        return self._functions

    @override
    def structures(self) -> list[Structure]:
        shared = [] if self._controller is None else self._controller.structures()
        return [*shared, *super().structures()]

    @override
    def copied(self) -> Self:
        result = super().copied()
        result._routines, result._functions = [*self._routines], {**self._functions}
        return result

    @property
    def names(self) -> list[str]:
        """Names of all routines; Python routines come last."""
        return [routine.name for routine in self._routines] + list(self._functions)

    @property
    def first(self) -> str | None:
        """The main routine; None if there are no routines."""
        return self.main or next(iter(self.names), None)

    def routine(self, function: Callable[[RungMaker], None]) -> Callable[[RungMaker], None]:
        """Add a routine of rungs by calling a function, which calls its argument `rung` for each rung."""
        maker = RungMaker(self.specs)
        function(maker)
        self.add_routine(Routine(function.__name__, tuple(maker.rungs), (function.__doc__ or "").strip()))
        return function

    def add_routine(self, routine: Routine) -> None:
        """Add a routine of rungs or of structured text, or raise a LadderError if its name is taken."""
        self._refuse_if_built()
        self._refuse_name(routine.name)
        self._routines.append(routine)

    def statements(self, name: str, text: str) -> None:
        """Add a routine of structured text; raise a RungTextError, or a LadderError if its name is taken."""
        block = parse_statements(text, specs=self.specs)
        self.add_routine(Routine(name, (), statements=block))

    def function(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Add a Python routine `f(tags, *inputs)`, with a keyword `jsr` if it calls routines itself."""
        self._refuse_if_built()
        self._refuse_name(function.__name__)
        self._functions[function.__name__] = function
        return function

    def _refuse_name(self, name: str) -> None:
        if not name.isidentifier():
            raise LadderError(f"{name!r} is not a routine name; use a named function")
        if name.upper() in map(str.upper, self.names):
            raise LadderError(f"there are two routines {name}")

    # --- building

    def lower_into(self, lowering: Lowering, scope: str = "") -> list[Problem]:
        """Lower the routines, in the scope of a controller's program; return any further problems."""
        lowering.enter(scope)
        for name, function in self._functions.items():
            lowering.lowered.functions[scoped(scope, name).upper()] = function
        for routine in self._routines:
            lowering.routine(routine)
        remedy = f"routines are {', '.join(self.names)}" if self.names else "add a routine"
        names = set(map(str.upper, self.names))
        missing = [used for used in (self.main, self.fault) if used and used.upper() not in names]
        return [Problem(f"program {self.name}", "", f"no routine {name}", remedy) for name in missing]

    def roots(self, scope: str = "") -> ProgramRoutines:
        """Return the program's main and fault routines, by full names in capitals."""
        main, fault = (name and scoped(scope, name).upper() for name in (self.first, self.fault))
        return ProgramRoutines(self.name, main, fault)

    @override
    def _lower(self) -> tuple[LoweredProgram, list[Problem]]:
        """Lower the routines as a program without a controller; return it with its warnings."""
        self._declare_missing((self,))
        layout = self.layout_of(self.declarations)
        lowering = self.lowering(layout, self.first or "Main")
        if self.fault:  # a schedule names the fault routine
            task = Task(self.name, TaskKind.CONTINUOUS, (self.name,))
            lowering.lowered.schedule = schedule_of(layout, [task], [self.roots()])
        problems = self.lower_into(lowering)
        if not self.names and not self.main:
            problems.append(Problem(f"program {self.name}", "", "no routine Main", "add a routine"))
        return self._checked(lowering, problems)
