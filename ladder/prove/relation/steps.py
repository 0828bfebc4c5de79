"""Instructions of a scan on terms: the interpreter's row, `Spec.prove`, or havoc of all that it may write."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ....io_images.site import Site
from ...instructions.slc.processor import before_scan, has_status
from ...instructions.slc.status import STATUS
from ...model.operands import Calculation, Constant, Group, Place, StringConstant, leaves_in
from ...model.spec import InstructionKind, Use
from ...model.tags import Leaf
from ...model.types import HIDDEN, leaves_of
from ...state.lowered import LoweredStep, Node, Parallel
from ..algebra.meaning import BOOL
from ..algebra.terms import FALSE, TRUE, T, and_, not_, or_
from .symbols import UnmodelledError
from .values import TermValues

_READ = frozenset(
    (
        *(Use.BIT, Use.NUMBER, Use.TEXT_OR_NUMBER, Use.INTEGER, Use.TEXT, Use.EXPRESSION, Use.CONDITION),
        *(Use.TRUTH, Use.SWITCH, Use.IGNORED, Use.SOURCE, Use.TABLE, Use.ITEM, Use.CONSTANT, Use.MODE),
        *(Use.KEYWORD, Use.LABEL),
    )
)
"""Uses of operands that an instruction does not write."""

_NEVER_WRITTEN = {Use.TIMER: (".PRE",), Use.COUNTER: (".PRE",), Use.CONTROL: (".LEN",)}
"""Members that an instruction of that use only reads."""

_ELSEWHERE = frozenset(("SSV", "EVENT", "SFR", "SFP", "EOT"))
"""Instructions that write more than their operands."""

_REFUSED = (
    *(UnmodelledError, TypeError, AttributeError, KeyError, ValueError, IndexError, ArithmeticError),
    RecursionError,
)
"""What a row on terms raises if it does something that has none."""


class TermSteps(TermValues):
    """Runs instructions, one after the other."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.deep: T = FALSE
        self.cut: list[tuple[Site, str, str]] = []
        self._ended: T = FALSE  # where the scan has ended

    def _series(self, nodes: tuple[Node, ...], power: Any) -> Any:
        for node in nodes:
            power = self._branch(node, power) if isinstance(node, Parallel) else self.execute(node, power)
        return power

    def _branch(self, branch: Parallel, power: Any) -> Any:
        behind = FALSE
        for leg in branch.legs:
            behind = or_(behind, self._series(leg, power))
        return behind

    def execute(self, step: LoweredStep, power: Any) -> Any:
        """Run an instruction; return the power after it."""
        if self.paths.path is not None:
            raise UnmodelledError("an instruction that runs others")
        self.site = step.site
        spec, before, frame = step.spec, self.active, self.frame
        if power is FALSE and spec.kind is not InstructionKind.BOTH and not spec.decides:
            return FALSE
        try:
            if spec.prove is not None:
                return spec.prove(self, power, *step.operands)
            return self._derived(step, power)
        except _REFUSED as why:
            self.active, self.frame, self.site = before, frame, step.site
            return self._havoc(step, power, why)

    def _derived(self, step: LoweredStep, power: T) -> T:
        """Run the row of the interpreter on terms."""
        spec = step.spec
        if spec.leaves:
            raise UnmodelledError("it leaves the rung")
        if spec.kind is InstructionKind.BOTH or spec.decides:
            after = self.on_paths(lambda: spec.run(self, self.symbol(power), *step.operands))
            return after if spec.decides else power
        with self.when(power):
            after = self.on_paths(lambda: spec.run(self, *step.operands))
        return and_(power, after) if spec.kind is InstructionKind.INPUT else power

    @contextmanager
    def when(self, power: T) -> Iterator[None]:
        """Run the body where power holds."""
        before = self.active
        self.active = and_(before, power)
        try:
            yield
        finally:
            self.active = and_(before, not_(self._ended))

    def _havoc(self, step: LoweredStep, power: T, why: Exception) -> T:
        """Let all that a step may write, and the power after it, be anything."""
        spec, site = step.spec, self.lowered.sites[step.site]
        self.cut.append((site, step.name, str(why)))
        acts = spec.kind is InstructionKind.BOTH or spec.decides
        if spec.leaves or step.name in _ELSEWHERE or not all(map(_is_plain, step.operands)):
            self.deep = or_(self.deep, and_(self.active, power))
        with self.when(TRUE if acts else power):
            self._havoc_operands(step)
            for flag in ("S:MINOR", *(("S:V", "S:Z", "S:N", "S:C") if self.lowered.flags else ())):
                self.havoc(self.lowered.layout.leaf(flag))
            if before_scan in self.lowered.opening and has_status(self):
                self.havoc(self.lowered.layout.leaf(STATUS))
        if spec.decides:
            return self.unknown(BOOL)
        return and_(power, self.unknown(BOOL)) if spec.kind is InstructionKind.INPUT else power

    def _havoc_operands(self, step: LoweredStep) -> None:
        uses = step.uses
        for number, operand in enumerate(step.operands):
            use = uses[number] if number < len(uses) else Use.ANYTHING
            if use not in _READ and isinstance(operand, (Place, Group)):
                for leaf in (*leaves_in(operand), *hidden_in(operand)):
                    if not leaf.path.upper().endswith(_NEVER_WRITTEN.get(use, ())):
                        self.havoc(self._in_program(leaf))

    def _in_program(self, leaf: Leaf) -> Leaf:
        """Return the leaf that an add-on instruction's leaf stands for."""
        if not leaf.root:
            return leaf
        return self.lowered.layout.leaf(self.frame[leaf.root].path + leaf.rest)  # type: ignore[attr-defined]


def hidden_in(operand: Place | Group) -> Iterator[Leaf]:
    """Yield the hidden leaves of a structure, at any depth."""
    if isinstance(operand, Group):
        for path, _, _ in leaves_of(operand.type):
            if path.rpartition(".")[2].startswith(HIDDEN):
                yield operand.layout.leaf(f"{operand.path}.{path}")


def _is_plain(operand: object) -> bool:
    """Whether an operand is all that an instruction may write by it; a routine or an axis is not."""
    return isinstance(operand, (Place, Group, Constant, Calculation, StringConstant, str))
