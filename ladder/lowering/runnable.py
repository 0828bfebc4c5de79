"""Common base of programs and controllers: declarations, building, running."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from copy import copy
from typing import Any, Self

from scanrack.io_images.module_words import ModuleWords

from ..compiler import Scanner, scanner_of, source_of
from ..instructions.motion.axes import MotionData
from ..instructions.slc.status import STATUS, WORDS
from ..instructions.system.messages import ends_of_messages
from ..model import hooks
from ..model.chart import DEFAULT_OPTIONS
from ..model.errors import BuildError, LadderError, LadderFault, MinorFault, Problem
from ..model.expressions import TAG_NAME, parse_address
from ..model.resolver import is_image
from ..model.routine import Routine
from ..model.spec import Spec
from ..model.stubs import NO_STUBS, InPython, Partner, Remote, Stub, Stubs, check_stubbed, parse_stub
from ..model.tagref import TagRef
from ..model.tags import STATUS_FLAGS, Alias, Declaration, Layout, SlotAlias, Tag
from ..model.tree import Address, Step
from ..model.types import INT, MAX_DIMENSIONS, DataType, Structure, count_of, dims_text, size_of
from ..run.edit import Edit, carry_over, is_retained
from ..run.engine import STEP_MS, Engine
from ..run.partners import connect, updates_of, wrong_values
from ..run.view import Tags
from ..state.lowered import LoweredProgram
from ..state.memory import Memory, element_text
from .addon import AddOn, specs_of
from .bound_axes import Axes, axis_tags, lower_axes, prescan_axes, run_axes, with_blocks
from .checks import ALLOWANCES, check_whole, recursive_routines, uses_of_stubs, warnings_of
from .dialects import DIALECTS, HOOKS, LOGIX, SLC
from .guess import type_at
from .resuming import resume
from .rungs import Lowering
from .storage import choose_bytes
from .type_inference import Guesses, Known, Missing

MOST_BYTES = 1 << 25
"""Maximum size of a tag, 32 MiB, which exceeds the memory of the largest controllers."""

REFUSALS_SHOWN = 5
"""Refused parts of an export listed in a message."""


class LadderLogic(ABC):
    """Tags and rungs; callable as the logic of a rack.

    The first use builds the program. If that fails, one error lists all mistakes. After the build, nothing
    can be declared. A call runs the compiled program; `tags` reads and writes its memory.

    Raises:
        LadderError: unknown `allow` or `dialect`.
    """

    kind: str
    """Its name in messages."""

    def __init__(self, name: str, *, allow: Iterable[str] = (), dialect: str = LOGIX) -> None:
        self.name = name
        if dialect not in DIALECTS:
            raise LadderError(f"{dialect!r} is not a dialect; choose from {', '.join(DIALECTS)}")
        self.dialect = dialect  # its instruction set, see `instructions.dialects`
        self.builtin = DIALECTS[dialect]  # specs of its instruction set, by name in capitals
        self.opening: list[Callable[[Engine, bool], None]] = []  # before each scan: engine, first?
        self.closing: list[Callable[[Engine], None]] = []  # after each scan
        self.declarations: list[Declaration] = []  # tags and aliases
        self.add_ons: dict[str, AddOn] = {}  # add-on instructions in use, by name in capitals
        self.allowed = frozenset(allow)  # suppressed warnings, see `checks.ALLOWANCES`
        unknown = self.allowed.difference(ALLOWANCES)
        if unknown:
            raise LadderError(f"{min(unknown)!r} can't be allowed; choose from {', '.join(ALLOWANCES)}")
        self.chart_options = DEFAULT_OPTIONS
        self.stubs: dict[str, Stub] = {}  # stubs of instructions and messages, by name in capitals
        self.modules: Mapping[int, ModuleWords] = {}  # of the rack, by slot
        self.axes: Axes | None = None  # axes that the rack names, or None
        self.remotes: Mapping[str, Remote] = {}  # of consumed tags and messages, by name in capitals
        self.motion = MotionData()  # data of axes in an export
        self.outputs: Mapping[int, bytes] = {}  # first values of output images, by slot
        self.keeps_values = False  # whether it starts from its initial values, without prescan
        self.declares_missing = False  # whether undeclared tags are declared by their use
        self.declared_missing: list[Tag] = []  # tags declared by their use, once it is built
        self.refused: Sequence[str] = ()  # omitted parts of an export, as text
        self.monitors: Callable[[Lowering], None] | None = None  # lowers routines for proofs
        self.left_out: Mapping[str, str] = {}  # stubbed routines of an export, and their stubs
        self._names: set[str] = set()
        self._lowered: LoweredProgram | None = None
        self._scanner: Scanner | None = None
        self._memory: Memory | None = None  # created by the check, for the first engine
        self._initial_memory: Memory | None = None  # copied for further engines
        self._initial_size: object = None  # `Layout.size` at its creation
        self._engine: Engine | None = None
        self._warnings: tuple[Problem, ...] = ()

    @property
    @abstractmethod
    def routines(self) -> Sequence[Routine]:
        """Routines of rungs and of structured text under their full names."""

    @property
    @abstractmethod
    def functions(self) -> Mapping[str, Callable[..., Any]]:
        """Routines in Python, by full name."""

    @abstractmethod
    def _lower(self) -> tuple[LoweredProgram, list[Problem]]:
        """Lower and check the program; return it with its warnings, or raise a BuildError."""

    @property
    def _has_status(self) -> bool:
        """Whether the processor has a status file. Instructions use the file even if it is not declared."""
        return self.dialect == SLC

    def layout_of(self, declarations: Iterable[Declaration]) -> Layout:
        """Return a layout of declarations and of the tags that axes and the processor add."""
        declared = [*declarations, *axis_tags(self.axes)]
        if self._has_status and STATUS not in self._names:
            declared.append(Tag(STATUS, INT, (WORDS,)))
        return Layout(declared, files=self.dialect == SLC, modules=self.modules)

    def lowering(self, layout: Layout, main: str) -> Lowering:
        """Return a lowering with the instructions of this program; `main` is the main routine or ""."""
        add_ons = with_blocks(self.add_ons, self.axes)
        lowering = Lowering(self.name, layout, main, add_ons, self.stubs, self.builtin)
        lowering.lowered.chart_options = self.chart_options
        return lowering

    def _checked(self, lowering: Lowering, problems: list[Problem]) -> tuple[LoweredProgram, list[Problem]]:
        """Check the lowered program; return it with its warnings, or raise a BuildError with all problems."""
        problems += lower_axes(lowering, self.axes, self.motion)
        if self.monitors is not None:
            self.monitors(lowering)
        lowered = lowering.lowered
        lowered.outputs = self.outputs
        lowered.resume = resume if self.keeps_values else None
        lowered.recursive = recursive_routines(lowered)
        problems = lowering.problems + check_whole(lowered) + problems
        problems += connect(lowered, self.stubs, self.remotes)
        choose_bytes(lowered)
        try:
            self._memory = Memory(lowered.layout, lowered.presets, lowered.defaults)
            problems += wrong_values(lowered, self._memory)
        except LadderError as error:
            remedy = "correct the initial value"
            problems.append(Problem("initial values", "", str(error), remedy, error.site))
        if problems:
            raise BuildError(self.name, problems, self.kind)
        return lowered, [*lowering.warnings, *warnings_of(lowered, self.allowed)]

    @property
    def specs(self) -> Mapping[str, Spec]:
        """Specs of all available instructions, by name in capitals."""
        return specs_of(self.add_ons, self.stubs, self.builtin)

    # --- declaring

    def stub(self, name: str, text: str | Callable[..., Any]) -> None:
        r"""Replace an instruction, or set the result of a message.

        Args:
            name: the instruction, or a message's tag; in a controller `\Program.tag` for a program's tag.
            text: `done after 20 ms`, `error 16#00CB after 20 ms`, `false` or `true` (see `stubs`); or a
                function (see `stubs.InPython`).

        Raises:
            LadderError: the text is not a stub, or the instruction can't be stubbed.
        """
        if callable(text):
            function_name = getattr(text, "__name__", type(text).__name__)
            self.take_stubs(Stubs({name.upper(): InPython(function_name, text)}))
        else:
            self.take_stubs(Stubs({name.upper(): parse_stub(text)}))

    def take_stubs(self, stubs: Stubs) -> None:
        """Add stubs, or replace stubs of the same name; raise a LadderError for new stubs after the build.

        A rack's modules can add tag names only before the program is built.
        """
        existing = {name: self.stubs.get(name) for name in stubs.by_name}
        is_new = existing != stubs.by_name or stubs.missing_tags > self.declares_missing
        if stubs == NO_STUBS or (self._lowered is not None and not is_new):
            return
        self._refuse_if_built()
        self.declares_missing |= stubs.missing_tags
        self.modules = {**self.modules, **stubs.modules}
        for name in stubs.by_name:
            check_stubbed(name)
        self.stubs.update(stubs.by_name)

    def before_scans(self, hook: Callable[[Engine, bool], None]) -> None:
        """Call a function before each scan and earlier hooks, with the engine and whether it is the first."""
        lowered = self.build()
        lowered.opening = (hook, *lowered.opening)

    def take_axes(self, axes: Axes) -> None:
        """Use the axes that the rack names; raise a LadderError if the program is already running."""
        if self._engine is not None:
            raise LadderError(f"{self.kind} {self.name} runs already; its axes can't change")
        self.axes = axes
        self.forget()

    def keep_values(self) -> None:
        """Start from the initial values, without prescan; raise a LadderError if the program is running."""
        if self._engine is not None:
            raise LadderError(f"{self.kind} {self.name} runs already; it can't start from its initial values")
        self.keeps_values = True
        if self._lowered is not None:
            self._lowered.resume = resume

    def copied(self) -> Self:
        """Return an unbuilt copy that accepts more declarations; this program is not changed."""
        result = copy(self)
        result.forget()
        result.declarations, result.add_ons = [*self.declarations], {**self.add_ons}
        result.stubs, result._names = {**self.stubs}, {*self._names}
        return result

    def forget(self) -> None:
        """Discard the build; the next use of the program builds it again."""
        self._lowered = self._scanner = self._memory = self._engine = self._initial_memory = None

    @property
    def stubs_in_use(self) -> tuple[str, ...]:
        """Stubs in use, such as `MSG = done after 20 ms (3 times)`."""
        return tuple(f"{name} = {text}" for name, text in self.used_stubs.items())

    @property
    def used_stubs(self) -> dict[str, str]:
        """Stubs in use by name, each with its text and number of uses."""
        counted = Counter(uses_of_stubs(self.build()))
        used = {name: self._use(self.stubs[name], count) for name, count in counted.items()}
        ideal = self.build().ideal_names
        if ideal:
            used["ideal axes"] = shortened(ideal)
        if self.declared_missing:
            used["missing_tags"] = f"declare: {', '.join(map(declared, self.declared_missing))}"
        used.update(self.left_out)
        if self.refused:
            used["refused"] = f"empty: {shortened(self.refused)}"
        return used

    @staticmethod
    def _use(stub: Stub, count: int) -> str:
        return str(stub) if isinstance(stub, Partner) else f"{stub} ({times(count)})"

    def _declare_missing(self, parts: Sequence[LadderLogic]) -> None:
        """Declare the undeclared tags that the routines of `parts` use."""
        if not self.declares_missing:
            return
        own_names = self._names | ({STATUS} if self._has_status else set())
        declared_names = {part.name: own_names | part._names for part in parts}

        def missing(program: str, address: Address) -> tuple[str, tuple[Step, ...]] | None:
            name = address.name
            upper = name.upper()
            is_declared = upper in declared_names[program] or upper in STATUS_FLAGS or is_image(name)
            return None if is_declared or not name else (name, address.steps)

        tags = {part.name: _tags(self, part) for part in parts}

        def known_type(program: str, address: Address) -> DataType | None:
            return type_at(tags[program].get(address.name.upper()), address)

        guesses = self.guesses(missing, known_type)
        guesses.read_all((part.name, routine) for part in parts for routine in part.routines)
        self.declared_missing = [
            Tag(guess.name, guess.type(re.sub(r"\W", "_", f"{guess.name}_type")), guess.dims)
            for guess in guesses.found.values()
        ]
        for tag in self.declared_missing:
            self.add(tag)

    def guesses(self, missing: Missing, known: Known) -> Guesses:
        """Return a collector that records the uses of undeclared tags; see `type_inference`."""
        files = self.dialect == SLC
        return Guesses(missing, known, self.operands_of, self.specs, self.structures(), files=files)

    def operands_of(self, name: str) -> tuple[tuple[DataType, tuple[int, ...]], ...]:
        """Return the types and dimensions of an add-on call's operands; empty if not an add-on."""
        definition = self.add_ons.get(name.upper())
        if definition is None or name.upper() in self.stubs:
            return ()
        return definition.operand_types

    def structures(self) -> list[Structure]:
        """Return the structures that its tags use as types."""
        kinds = (declaration.type for declaration in self.declarations if isinstance(declaration, Tag))
        return [kind for kind in dict.fromkeys(kinds) if isinstance(kind, Structure)]

    def declare(
        self,
        names: str,
        kind: DataType | AddOn,
        *dims: int,
        initial: object = None,
        comment: str = "",
    ) -> Any:
        """Declare one tag, or several tags of one type with spaces between their names.

        Args:
            kind: their type; for instances, the add-on instruction.
            dims: length per dimension, for arrays.
            initial: initial value; None = zero.

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

    def alias(self, name: str, target: str, type: Structure | None = None) -> TagRef:
        """Declare a second name for an address; `type` is the structure of a module's image."""
        self.add(Alias(name, parse_address(target), type=type))
        return TagRef(parse_address(name))

    def slot(self, name: str, number: int) -> TagRef:
        """Name the module in a slot, to use named bits such as `axis.status.MOVE_COMPLETE`."""
        self.add(SlotAlias(name, number))
        return TagRef(parse_address(name))

    def add(self, declaration: Declaration) -> None:
        """Add a declaration; raise a LadderError for a taken or invalid name, or invalid dimensions."""
        self._refuse_if_built()
        name = declaration.name
        if not self._is_name(name):
            raise LadderError(f"{name!r} is not a tag name; use letters, digits and _")
        if name.upper() in self._names:
            raise LadderError(f"tag {name} is declared twice; names are not case-sensitive")
        dims = declaration.dims if isinstance(declaration, Tag) else ()
        if len(dims) > MAX_DIMENSIONS or any(length < 1 for length in dims):
            raise LadderError(f"tag {name} has dimensions {dims}; must be at most 3, each 1 or more")
        if isinstance(declaration, Tag) and size_of(declaration.type) * count_of(dims) > MOST_BYTES:
            raise LadderError(f"tag {name} has more than {MOST_BYTES:,} bytes; make it shorter")
        if self._has_status and name.upper() == STATUS:
            _check_status(declaration)
        self._names.add(name.upper())
        self.declarations.append(declaration)

    def _is_name(self, name: str) -> bool:
        """Return whether a tag can have this name; the slc dialect allows `I:2` for a slot's words."""
        if self.dialect == SLC and re.fullmatch(r"[IO]:\d{1,3}", name, re.ASCII):
            return True
        is_valid = re.fullmatch(TAG_NAME, name, re.ASCII) is not None
        return is_valid and not name.upper().startswith(("S:", "I:", "O:"))

    def use(self, *add_ons: AddOn) -> None:
        """Add add-on instructions; raise a LadderError if another one has the same name."""
        self._refuse_if_built()
        for add_on in add_ons:
            if self.add_ons.setdefault(add_on.name.upper(), add_on) != add_on:
                raise LadderError(f"there are two add-on instructions {add_on.name}")

    def _refuse_if_built(self) -> None:
        if self._lowered is not None:
            raise LadderError(f"{self.kind} {self.name} has been built; nothing can be added")

    # --- building

    def build(self) -> LoweredProgram:
        """Check and lower the program, or raise a BuildError with all problems."""
        if self._lowered is None:
            self._lowered, warnings = self._lower()
            opening, closing = HOOKS[self.dialect]
            axes = self._lowered.axes or self._lowered.ideal
            self._lowered.opening = (
                *opening,
                *updates_of(self._lowered),
                *([prescan_axes] if axes else []),
                *self.opening,
            )
            messages = ends_of_messages(self._lowered)
            self._lowered.closing = (*self.closing, *([run_axes] if axes else []), *messages, *closing)
            self._warnings = tuple(warnings)
        return self._lowered

    @property
    def warnings(self) -> tuple[Problem, ...]:
        """Warnings of likely mistakes, such as a bit with two coils or a program without a task."""
        self.build()
        return self._warnings

    def compile(self) -> Engine:
        """Return a new engine that runs the compiled program, which is compiled only once."""
        return Engine(self.build(), self.scanner, self._take_memory())

    @property
    def scanner(self) -> Scanner:
        """The compiled program, ready to bind to an engine's memory."""
        if self._scanner is None:
            self._scanner = scanner_of(self.build())
        return self._scanner

    def interpret(self) -> Engine:
        """Return a new engine that runs the interpreter."""
        return Engine(self.build(), memory=self._take_memory())

    def _take_memory(self) -> Memory:
        """Return a memory with initial values: first the one used by the check, then copies."""
        lowered = self.build()
        memory, self._memory = self._memory, None
        if memory is not None:
            return memory
        if self._initial_memory is None or self._initial_size != lowered.layout.size:
            self._initial_memory = Memory(lowered.layout, lowered.presets, lowered.defaults)
            self._initial_size = lowered.layout.size
        return self._initial_memory.copy()

    def reset_by_prescan(self) -> list[str]:
        """Return the values that prescan resets before the first scan, by address."""
        engine = self.interpret()
        memory, leaves = engine.memory, engine.lowered.layout.leaves.values()
        retained = [leaf for leaf in leaves if is_retained(engine.lowered.layout, leaf)]
        values_before = [memory.values(leaf) for leaf in retained]
        with suppress(LadderFault):
            engine.interpreter.prescan()
        reset: list[str] = []
        for leaf, before in zip(retained, values_before, strict=True):
            after = memory.values(leaf)
            pairs = zip(before, after, strict=True) if leaf.dims else [(before, after)]  # type: ignore[arg-type]
            reset += [
                element_text(leaf.path, leaf.dims, index)
                for index, (old, new) in enumerate(pairs)
                if old and not new
            ]
        return reset

    # --- running

    @property
    def engine(self) -> Engine:
        """The engine that a call of the program runs."""
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
        """Do one scan of a rack; see `Engine`."""
        (self._engine or self.engine)(scan)

    def __attach_logic__(self, _slots: object) -> None:
        """Compile before the first scan, so the scan's watchdog time does not include compiling."""
        _ = self.engine

    def __close_logic__(self) -> None:  # noqa: B027 - nothing to close between two scans
        """Do nothing."""

    def step(self, ms: float = STEP_MS) -> None:
        """Do one scan without a rack; see `Engine.step`."""
        self.engine.step(ms)

    def take_over(self, running: LadderLogic) -> Edit:
        """Continue from the state of another program, between two scans: an online edit.

        Tags of the same name and type keep their values, and new tags start with their initial values. No
        prescan runs. The other program is unchanged.

        Raises:
            LadderError: this program has already done a scan, or is running.
            BuildError: this program can't be built; the other program continues.
        """
        if self._engine is not None:
            raise LadderError(f"{self.kind} {self.name} runs already; only a new program can take over")
        engine = self.compile()
        edit = carry_over(running.engine, engine)
        self._engine = engine
        return edit

    # --- proving

    def prove(self, **question: Any) -> Any:
        """Prove or refute a property for all inputs, all scan times in a range, and any number of scans.

            assert program.prove(never="Fwd AND Rev")

        Args:
            question: one of `never`, `always` and `reachable`, a condition of structured text on the state
                after a scan; `assume`, conditions that hold in each scan; `free`, patterns of numbers that
                differ from scan to scan; `written_outside`, patterns of tags that an operator also writes;
                `scan_ms`, minimum and maximum ms between two scans, 1 to 1,000 by default.

        Returns:
            The answer, a `prove.answers.Answer`: true if the property is proved or the condition is reached;
            its text is the scenario.

        Raises:
            LadderError: a condition can't be used, or proofs do not cover a part of the program.
            SolverMissingError: the extra `prove` is not installed.
        """
        return hooks.ask(self, **question)

    # --- reading

    def source(self) -> str:
        """Return the program's compiled Python code."""
        return source_of(self.build())

    def text(self, routine: str) -> str:
        """Return the text of a routine, or raise a LadderError."""
        for candidate in self.routines:
            if candidate.name.upper() == routine.upper():
                return candidate.text
        raise LadderError(f"no routine {routine} in {self.kind} {self.name}")


def shortened(names: Sequence[str], most: int = REFUSALS_SHOWN) -> str:
    """Return a list of names as text; for a long list, the first names and the number of others.

    >>> shortened(["Feed", "Clamp", "Table"], 2)
    'Feed, Clamp, and 1 more'
    """
    ending = [f"and {len(names) - most:,} more"] if len(names) > most else []
    return ", ".join([*names[:most], *ending])


def times(count: int) -> str:
    """Return a count in words.

    >>> times(1), times(2), times(2000)
    ('once', 'twice', '2,000 times')
    """
    return {1: "once", 2: "twice"}.get(count, f"{count:,} times")


def _tags(*scopes: LadderLogic) -> dict[str, Tag]:
    """Return the tags in scopes by name in capitals; a later scope takes precedence."""
    return {
        declaration.name.upper(): declaration
        for scope in scopes
        for declaration in scope.declarations
        if isinstance(declaration, Tag)
    }


def _check_status(declaration: Declaration) -> None:
    """Raise a LadderError if a declaration lacks words of the status file."""
    needed = f"the status file of this dialect is {STATUS} : INT[{WORDS}] or longer; it needs no declaration"
    if not isinstance(declaration, Tag):
        raise LadderError(f"{declaration.name} is not a tag; {needed}")
    if declaration.type is not INT or len(declaration.dims) != 1 or declaration.dims[0] < WORDS:
        raise LadderError(f"tag {declared(declaration)}: {needed}")


def declared(tag: Tag) -> str:
    """Return a tag as a program file declares it.

    >>> from scanrack.ladder import DINT
    >>> declared(Tag("Level", DINT, (4,)))
    'Level : DINT[4]'
    """
    return f"{tag.name} : {tag.type.name}{dims_text(tag.dims)}"
