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

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from .addon import AddOn, specs_of
from .checks import ALLOWANCES, check_whole
from .compiler import Scanner, scanner_of, source_of
from .engine import STEP_MS, Engine
from .errors import BuildError, LadderError, MinorFault, Problem
from .expressions import parse_address
from .front import RungMaker
from .lowered import Lowered
from .lowering import Lowering
from .memory import Memory
from .tagref import TagRef
from .tags import Alias, Declaration, Layout, SlotAlias, Tag
from .tree import Routine
from .types import MAX_DIMENSIONS, DataType, count_of, size_of
from .view import Tags

MOST_BYTES = 1 << 25
"""Bytes of a single tag: 32 MiB, more memory than the largest controllers have for all of them."""


class Program:
    """Tags and routines; callable as the logic of a rack.

    It is built when it is first used: then one error lists all mistakes, and nothing can be
    added any more. Calling it runs it compiled, on memory that `tags` shows.

    Attributes:
        name: its name.
        main: the routine that a scan calls; the first one, unless named.
        declarations: tags and aliases, in order.
        routines: routines of rungs and of structured text, in order.
        functions: routines in Python, by name.
        add_ons: the add-on instructions that it uses, by name in capitals.
        allowed: what it is allowed, see `checks.ALLOWANCES`.

    Args:
        name: its name.
        main: the routine that a scan calls, if not the first.
        allow: what it is allowed.
    """

    def __init__(self, name: str, *, main: str | None = None, allow: Iterable[str] = ()) -> None:
        self.name, self.main = name, main
        self.declarations: list[Declaration] = []
        self.routines: list[Routine] = []
        self.functions: dict[str, Callable[..., Any]] = {}
        self.add_ons: dict[str, AddOn] = {}
        self.allowed = frozenset(allow)
        unknown = self.allowed.difference(ALLOWANCES)
        if unknown:
            raise LadderError(f"{min(unknown)!r} can't be allowed; what can is {', '.join(ALLOWANCES)}")
        self._names: set[str] = set()
        self._lowered: Lowered | None = None
        self._scanner: Scanner | None = None
        self._engine: Engine | None = None

    # --- declaring

    def declare(
        self,
        names: str,
        kind: DataType | AddOn,
        *dims: int,
        initial: object = None,
        comment: str = "",
    ) -> Any:
        """Declare one tag, or several of one type whose names stand between spaces.

        Args:
            names: names.
            kind: their type; for instances, the add-on instruction.
            dims: length per dimension, for arrays.
            initial: what they start with; None = zero.
            comment: their comment.

        Returns:
            The tag, or a tuple of them, for use in rungs.

        Raises:
            LadderError: a name is taken or not allowed, or the dimensions are not allowed.
        """
        if isinstance(kind, AddOn):
            self.use(kind)
            kind = kind.structure
        listed = names.replace(",", " ").split()
        for name in listed:
            self.add(Tag(name, kind, dims, initial, comment))
        refs = tuple(TagRef(parse_address(name)) for name in listed)
        return refs[0] if len(refs) == 1 else refs

    def alias(self, name: str, target: str) -> TagRef:
        """Give an address a second name."""
        self.add(Alias(name, parse_address(target)))
        return TagRef(parse_address(name))

    def slot(self, name: str, number: int) -> TagRef:
        """Name the module in a slot, whose bits then go by meaning: `axis.status.MOVE_COMPLETE`."""
        self.add(SlotAlias(name, number))
        return TagRef(parse_address(name))

    def add(self, declaration: Declaration) -> None:
        """Add a declaration.

        Raises:
            LadderError: its name is taken or not allowed, or its dimensions are not allowed.
        """
        self._refuse_if_built()
        name = declaration.name
        if not name.isidentifier() or not name.isascii():
            raise LadderError(f"{name!r} is not a tag name: letters, digits and _ are allowed")
        if name.upper() in self._names:
            raise LadderError(f"tag {name} is declared twice; names do not depend on case")
        dims = declaration.dims if isinstance(declaration, Tag) else ()
        if len(dims) > MAX_DIMENSIONS or any(length < 1 for length in dims):
            raise LadderError(f"tag {name} has dimensions {dims}; allowed are up to 3, each 1 or more")
        if isinstance(declaration, Tag) and size_of(declaration.type) * count_of(dims) > MOST_BYTES:
            raise LadderError(f"tag {name} takes more than {MOST_BYTES:,} bytes; make it shorter")
        self._names.add(name.upper())
        self.declarations.append(declaration)

    def use(self, *add_ons: AddOn) -> None:
        """Make add-on instructions known to the program.

        Raises:
            LadderError: there is another one of that name.
        """
        self._refuse_if_built()
        for each in add_ons:
            if self.add_ons.setdefault(each.name.upper(), each) != each:
                raise LadderError(f"there are two add-on instructions {each.name}")

    def routine(self, function: Callable[[RungMaker], None]) -> Callable[[RungMaker], None]:
        """Add a routine: the function is called once, now, with a `rung` that it calls per rung."""
        maker = RungMaker(specs_of(self.add_ons))
        function(maker)
        self.add_routine(Routine(function.__name__, tuple(maker.rungs), (function.__doc__ or "").strip()))
        return function

    def add_routine(self, routine: Routine) -> None:
        """Add a routine of rungs or of structured text.

        Raises:
            LadderError: there is one of that name.
        """
        self._refuse_if_built()
        self._refuse_name(routine.name)
        self.routines.append(routine)

    def statements(self, name: str, text: str) -> None:
        """Add a routine of structured text.

        Args:
            name: its name.
            text: its statements.

        Raises:
            RungTextError: it is not structured text; line, column and what was expected.
            LadderError: there is a routine of that name.
        """
        from .st import parse_statements  # lark takes time to import, and most programs have none

        block = parse_statements(text, specs=specs_of(self.add_ons))
        self.add_routine(Routine(name, (), statements=block))

    def function(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Add a routine in Python: `f(tags, *inputs)`, with a keyword `jsr` if it calls routines itself."""
        self._refuse_if_built()
        self._refuse_name(function.__name__)
        self.functions[function.__name__] = function
        return function

    def _refuse_name(self, name: str) -> None:
        if not name.isidentifier():
            raise LadderError(f"{name!r} is not a routine name: write a function with a name")
        taken = [each.name for each in self.routines] + list(self.functions)
        if name.upper() in map(str.upper, taken):
            raise LadderError(f"there are two routines {name}")

    def _refuse_if_built(self) -> None:
        if self._lowered is not None:
            raise LadderError(f"program {self.name} has been built: nothing can be added any more")

    # --- building

    def build(self) -> Lowered:
        """Check the program and make it ready to run.

        Raises:
            BuildError: what is wrong, with rungs and remedies.
        """
        if self._lowered is None:
            self._lowered = self._lower()
        return self._lowered

    def _lower(self) -> Lowered:
        names = [each.name for each in self.routines] + list(self.functions)
        main = self.main or (names[0] if names else "Main")
        lowering = Lowering(self.name, Layout(self.declarations), main, self.add_ons)
        lowering.lowered.functions = {name.upper(): function for name, function in self.functions.items()}
        for routine in self.routines:
            lowering.routine(routine)
        problems = lowering.problems + check_whole(lowering.lowered, self.allowed)
        if main.upper() not in map(str.upper, names):
            known = f"routines are {', '.join(names)}" if names else "add a routine"
            problems.append(Problem(f"program {self.name}", "", f"there is no routine {main}", known))
        problems += self._wrong_initials(lowering.lowered)
        if problems:
            raise BuildError(self.name, problems)
        return lowering.lowered

    def _wrong_initials(self, lowered: Lowered) -> list[Problem]:
        try:
            Memory(lowered.layout, lowered.presets, lowered.defaults)
        except ValueError as error:
            return [Problem("initial values", "", str(error), "correct the initial value")]
        return []

    def compile(self) -> Engine:
        """Return a new engine that runs the program compiled; compiling it is done once."""
        return Engine(self.build(), self.scanner)

    @property
    def scanner(self) -> Scanner:
        """The compiled program, which binds itself to an engine's memory."""
        if self._scanner is None:
            self._scanner = scanner_of(self.build())
        return self._scanner

    def interpret(self) -> Engine:
        """Return a new engine that runs the program in the interpreter."""
        return Engine(self.build())

    # --- running

    @property
    def engine(self) -> Engine:
        """The engine that calling the program runs."""
        if self._engine is None:
            self._engine = self.compile()
        return self._engine

    @property
    def tags(self) -> Tags:
        """The tags by name."""
        return self.engine.tags

    @property
    def minor_faults(self) -> Sequence[MinorFault]:
        """The latest minor faults."""
        return self.engine.minor_faults

    def __call__(self, scan: Any) -> None:
        """Do one scan of a rack, see `Engine`."""
        (self._engine or self.engine)(scan)

    def step(self, ms: float = STEP_MS) -> None:
        """Do one scan without a rack, see `Engine.step`."""
        self.engine.step(ms)

    # --- reading

    def source(self) -> str:
        """Return the Python that the program is compiled to."""
        return source_of(self.build())

    def text(self, routine: str) -> str:
        """Return the text of a routine.

        Raises:
            LadderError: that name is unknown.
        """
        for each in self.routines:
            if each.name.upper() == routine.upper():
                return each.text
        raise LadderError(f"there is no routine {routine} in program {self.name}")
