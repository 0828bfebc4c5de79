"""Runs instructions on terms by `Spec.prove` or the interpreter's row; otherwise, results are unknown.

Each instruction is a transaction. If its row can't run on terms, all its effects are undone: values, jumps,
results, faults, notes, and the effects of the instructions that it called. Then every place that it may write
becomes unknown wherever it acts. If the row wrote other places or redirected the scan, the relation does not
follow the program there.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

from scanrack.io_images.site import Site

from ...instructions.slc.processor import before_scan, has_status
from ...instructions.slc.status import STATUS
from ...model.operands import Calculation, Constant, Group, Place, StringConstant, can_fault, leaves_in
from ...model.spec import InstructionKind, Use
from ...model.tags import OVERRIDE, Leaf
from ...model.types import HIDDEN, leaves_of
from ...state.lowered import AddOnCall, Call, LoweredStep, Node, Parallel
from ..algebra.meaning import BOOL, INT
from ..algebra.terms import FALSE, TRUE, T, and_, any_of, not_, or_
from .places import Key
from .shapes import world_of
from .stored import MOST_OPEN
from .symbols import UnmodeledError, term_of
from .term_values import TermValues
from .unknowns import ONLY, UnknownOrigin, named, system_leaves

_READ_NAMES = (
    "BIT NUMBER TEXT_OR_NUMBER INTEGER TEXT EXPRESSION CONDITION TRUTH SWITCH IGNORED SHOWN SOURCE TABLE "
    "ITEM CONSTANT MODE KEYWORD LABEL"
)

_READ = frozenset(Use[name] for name in _READ_NAMES.split(" "))
"""Uses of an operand that the instruction does not write."""

_NEVER_WRITTEN = {Use.TIMER: (".PRE",), Use.COUNTER: (".PRE",), Use.CONTROL: (".LEN",)}
"""Members that an instruction reads but does not write, by operand use."""

_ELSEWHERE = frozenset(("SSV", "EVENT", "SFR", "SFP", "EOT"))
"""Instructions that write places that are not operands."""

_BESIDE = {"MCR": OVERRIDE}
"""Status flags that an instruction writes in addition to its operands."""

_OF_STEP = (
    *("active", "site", "frame", "inputs", "deep", "_ended", "_exits", "_passes", "_number", "_depth"),
    *("_labels", "_pending", "_answers", "stops", "faulted"),
)
"""Attributes, in addition to places and notes, that a row may change and an undo restores."""

_FLOW = ("_ended", "_exits", "_pending", "_answers")
"""Attributes in `_OF_STEP` that redirect the scan."""

REFUSED = (
    UnmodeledError,
    TypeError,
    AttributeError,
    LookupError,
    ValueError,
    ArithmeticError,
    RecursionError,
)
"""Exceptions from a row that can't run on terms."""


Answer = tuple[T, tuple[Any, ...]]
"""The condition under which a routine returns, and its results."""


class TermSteps(TermValues):
    """Runs instructions in sequence."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.deep: T = FALSE
        self.selected: Any = None  # the selector of the current CASE; None if it is not modeled
        self.cut: list[tuple[Site, str, str]] = []
        self._ended: T = FALSE  # the condition that the scan has ended
        self._exits: T = FALSE  # the condition that the innermost loop is left
        self._labels: Mapping[str, int] = {}
        self._pending: dict[str, T] = {}  # the condition of a forward jump to each label
        self._number = 0  # number of the current rung
        self._answers: list[Answer] = []
        self._depth = 0  # nesting of calls
        self._passes = 0  # passes of all loops with an unknown end
        self._system: list[Leaf] | None = None  # leaves that instructions may read without naming them
        self._world: Hashable = None

    def _series(self, nodes: tuple[Node, ...], power: Any) -> Any:
        """Run instructions in series; return the power after the last one."""
        for node in nodes:
            power = self._branch(node, power) if isinstance(node, Parallel) else self.execute(node, power)
        return power

    def _branch(self, branch: Parallel, power: Any) -> Any:
        """Run the legs of a branch with the same power; return whether any leg has power."""
        return any_of(self._series(leg, power) for leg in branch.legs)

    def execute(self, step: LoweredStep, power: Any) -> Any:
        """Run an instruction; return the power after it."""
        if self.paths.path is not None:
            raise UnmodeledError("an instruction that runs others")
        self.site = step.site
        if power is FALSE and not _acts_without_power(step):
            return FALSE
        after, origin = self._attempt(step, power, partial(self._row, step, power))
        return after if origin is None else self._power_after(step, power, origin)

    def _attempt(
        self, step: LoweredStep, power: T, row: Callable[[], Any]
    ) -> tuple[Any, UnknownOrigin | None]:
        """Run a step as a transaction; if its row can't run on terms, undo it and make its places unknown.

        Returns:
            The row's result and None; for a refused row, None and the origin of the unknown values.
        """
        saved, mark = [getattr(self, name) for name in _OF_STEP], self.log.begin()
        try:
            result = row()
        except REFUSED as refusal:
            undone, moved = self._undo(saved, mark)
            self.site = step.site
            return None, self._refused(step, power, refusal, undone, moved=moved)
        self.log.commit(mark)
        return result, None

    def _undo(self, saved: Sequence[Any], mark: tuple[int, int]) -> tuple[set[Key], bool]:
        """Undo a transaction; return the places that it wrote, and whether it redirected the scan."""
        flow_before = [getattr(self, attribute) for attribute in _FLOW]
        undone = list(self.log.undo(mark))
        for name, value in zip(_OF_STEP, saved, strict=True):
            setattr(self, name, value)
        self.selected = None
        is_redirected = flow_before != [getattr(self, attribute) for attribute in _FLOW]
        is_redirected = is_redirected or any(
            table is self._pending or table is self._answers for table, _ in undone
        )
        return {key for table, key in undone if table is self.written}, is_redirected

    def _row(self, step: LoweredStep, power: T) -> T:
        """Run the row of an instruction; return the power after it."""
        if step.spec.prove is not None:
            return step.spec.prove(self, power, *step.operands)  # type: ignore[no-any-return]
        return self._derived(step, power)

    def _derived(self, step: LoweredStep, power: T) -> T:
        """Run the interpreter's row on terms."""
        spec = step.spec
        if spec.leaves:
            raise UnmodeledError("it leaves the rung")
        if spec.kind is InstructionKind.BOTH or spec.decides:
            after = self.on_paths(lambda: spec.run(self, self.symbol(power), *step.operands))
            return after if spec.decides else power
        with self.when(power):
            after = self.on_paths(lambda: spec.run(self, *step.operands))
        return and_(power, after) if spec.kind is InstructionKind.INPUT else power

    @contextmanager
    def when(self, power: T) -> Iterator[None]:
        """Run the body under the condition that power is true."""
        active_before = self.active
        self.active = and_(active_before, power)
        try:
            yield
        finally:
            self.active = self._going_on(active_before)

    def _going_on(self, t: T) -> T:
        """Narrow a condition to the cases where the scan continues after the current place."""
        return and_(t, not_(or_(self._ended, self.faulted)))

    def _acting(self, step: LoweredStep, power: T) -> T:
        """Return the condition under which a step acts when it is reached."""
        return TRUE if _acts_without_power(step) else power

    def _refused(
        self, step: LoweredStep, power: T, why: Exception, undone: set[Key], *, moved: bool = False
    ) -> UnknownOrigin:
        """Make every place that a step may write unknown, and allow a fault; return the origin.

        Args:
            undone: places that the step had written before it was refused.
            moved: whether the step had redirected the scan.
        """
        self.log.add(self.cut, (self.lowered.sites[step.site], step.name, str(why)))
        origin = self._origin(step, power)
        freed = [*self._written_by(step), *self._flags(step)]
        beside = {path for path, _ in undone} - {leaf.path.upper() for leaf in freed}
        elsewhere = step.spec.leaves or step.name in _ELSEWHERE or not all(map(_is_plain, step.operands))
        with self.when(self._acting(step, power)):
            if moved or beside or elsewhere:
                self.deep = or_(self.deep, self.active)
            for leaf in freed:
                self.havoc(leaf, origin)
            if may_fault(step):
                fault = self.unknown(BOOL, origin=origin.of("fault"))
                self.log.put(self.may_fault, fault.val, self.lowered.sites[step.site])
                self.stop(fault)
        return origin

    def _power_after(self, step: LoweredStep, power: T, origin: UnknownOrigin) -> T:
        """Return the power after a step that was refused."""
        if not step.spec.decides and step.spec.kind is not InstructionKind.INPUT:
            return power
        after = self.unknown(BOOL, origin=origin.of("power"))
        return after if step.spec.decides else and_(power, after)

    def _origin(self, step: LoweredStep, power: T) -> UnknownOrigin:
        """Return the origin of a refused step's unknown results; `ONLY` for too many arguments.

        The arguments are all values that may decide the results: the power, the elements that operands
        name, and system values.
        """
        leaves = [self._in_program(leaf) for operand in step.operands for leaf in _named_by(operand)]
        if self._system is None:
            self._system, self._world = system_leaves(self.lowered, STATUS), world_of(self.lowered)
        if any(leaf.size > MOST_OPEN for leaf in leaves):
            return ONLY
        arguments: dict[Hashable, T] = {"power": power} if _acts_without_power(step) else {}
        for leaf in (*leaves, *self._system):
            path = leaf.path.upper()
            arguments.update(((path, index), self._kept[path, index]) for index in self.elements_in_use(leaf))
        roots = {leaf.root for operand in step.operands for leaf in _named_by(operand)} - {""}
        for root in roots:  # arguments of the add-on instruction around the step
            argument: Any = self.frame[root]
            numbers = {
                "first": argument.first,
                "left": argument.left,
                "bit": -1 if argument.bit is None else argument.bit,
            }
            arguments.update(((root, name), term_of(value, INT)) for name, value in numbers.items())
        return UnknownOrigin(named(step, tuple(leaves), self._world), arguments)

    def _written_by(self, step: LoweredStep) -> Iterator[Leaf]:
        """Yield the leaves that a step may write through its operands."""
        uses = step.uses
        for number, operand in enumerate(step.operands):
            use = uses[number] if number < len(uses) else Use.ANYTHING
            if use not in _READ and isinstance(operand, (Place, Group)):
                for leaf in (*leaves_in(operand), *hidden_in(operand)):
                    if not leaf.path.upper().endswith(_NEVER_WRITTEN.get(use, ())):
                        yield self._in_program(leaf)

    def _flags(self, step: LoweredStep) -> Iterator[Leaf]:
        """Yield the flags that every instruction may write, and the one that only this instruction writes."""
        if step.name in _BESIDE:
            yield self.lowered.layout.leaf(_BESIDE[step.name])
        for flag in ("S:MINOR", *(("S:V", "S:Z", "S:N", "S:C") if self.lowered.flags else ())):
            yield self.lowered.layout.leaf(flag)
        if before_scan in self.lowered.opening and has_status(self):
            yield self.lowered.layout.leaf(STATUS)

    def _in_program(self, leaf: Leaf) -> Leaf:
        """Return the program's leaf for a leaf of an add-on instruction."""
        if not leaf.root:
            return leaf
        return self.lowered.layout.leaf(self.frame[leaf.root].path + leaf.rest)  # type: ignore[attr-defined]


def _named_by(operand: object) -> Iterator[Leaf]:
    """Yield all leaves of an operand, including hidden leaves and leaves in its subscripts."""
    if isinstance(operand, (Place, Group)):
        yield from leaves_in(operand)
        yield from hidden_in(operand)
        bit = operand.bit if isinstance(operand, Place) else None
        for inner in (*operand.indices, bit):
            yield from _named_by(inner)
    elif isinstance(operand, Calculation):
        for inner in operand.operands:
            yield from _named_by(inner)
    elif isinstance(operand, Call):
        for inner in (*operand.inputs, *operand.returns):
            yield from _named_by(inner)
    elif isinstance(operand, AddOnCall):
        for inner in (operand.instance, *operand.handed.values()):
            yield from _named_by(inner)


def _acts_without_power(step: LoweredStep) -> bool:
    """Return whether an instruction acts, or determines its output power, when it has no power."""
    return step.spec.kind is InstructionKind.BOTH or step.spec.decides


def may_fault(step: LoweredStep) -> bool:
    """Return whether an instruction may cause a major fault, by its row or by its subscripts."""
    return step.spec.faults or any(map(_leaves_array, step.operands))


def _leaves_array(operand: Any) -> bool:
    """Return whether a subscript may be out of range; this is always possible in an array argument."""
    if isinstance(operand, (Place, Group)):
        relative = any(leaf.root and leaf.dims for leaf in leaves_in(operand))
        return relative or can_fault(operand)
    if isinstance(operand, Calculation):
        return any(map(_leaves_array, operand.operands))
    return not _is_plain(operand)


def hidden_in(operand: Place | Group) -> Iterator[Leaf]:
    """Yield the hidden leaves of a structure at any depth."""
    if isinstance(operand, Group):
        for path, _, _ in leaves_of(operand.type):
            if path.rpartition(".")[2].startswith(HIDDEN):
                yield operand.layout.leaf(f"{operand.path}.{path}")


def _is_plain(operand: object) -> bool:
    """Return whether an instruction can write only the tags that an operand names; False for a routine."""
    return isinstance(operand, (Place, Group, Constant, Calculation, StringConstant, str))
