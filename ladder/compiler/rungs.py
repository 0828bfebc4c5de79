"""Rungs as Python code: power through series and branches.

The `Spec` of an instruction writes its Python code through the `RungWriter`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import takewhile

from ..model.operands import can_fault
from ..model.spec import InstructionKind
from ..model.tags import OVERRIDE
from ..state.lowered import LoweredStep, Node, Parallel
from .observed import Notes
from .terms import calculates
from .value_writer import ValueWriter
from .writer import Writer, both, either_of


class RungWriter:
    """Writes the rungs of one routine."""

    def __init__(self, writer: Writer, functions: dict[str, str], notes: Notes) -> None:
        self.notes = notes  # the noted lines
        self.writer = writer
        self.values = ValueWriter(writer)
        self.sections: dict[str, int] = {}  # numbers of the sections after labels
        self.section = 0  # number of the current section
        self.functions = functions  # Python function of each routine in capitals
        self._override = writer.lowered.layout.leaf(OVERRIDE)
        self.override = self._override.ident  # variable of the MCR state

    def set_override(self, text: str) -> None:
        """Write an assignment of the MCR state."""
        self.writer.assigned(self._override)
        self.writer.line(f"{self.override} = {text}")

    def inline(self, step: LoweredStep) -> str:
        """Return the expression of an input from `inline_run`."""
        self.values.site = step.site
        return self._write(step)

    def inline_run(self, nodes: tuple[Node, ...]) -> tuple[LoweredStep, ...]:
        """Return the leading inputs of a series that each compile to one expression."""
        steps = takewhile(lambda node: isinstance(node, LoweredStep) and _is_inline(node), nodes)
        return tuple(step for step in steps if isinstance(step, LoweredStep))

    def series(self, nodes: tuple[Node, ...], power: str, *, needed: bool) -> str:
        """Write a series; return the power after it, valid only if `needed`."""
        outputs = len(nodes) if needed else _first_of_last_outputs(nodes)
        for number, node in enumerate(nodes[:outputs], start=1):
            is_used = needed or number < len(nodes)
            if isinstance(node, Parallel):
                power = self._branch(node, power, needed=is_used)
            else:
                power = self.step(node, power, needed=is_used)
        if outputs < len(nodes):
            self.outputs(nodes[outputs:], power)
        return power

    def _branch(self, branch: Parallel, power: str, *, needed: bool) -> str:
        """Write a branch; return the power after it, valid only if `needed`."""
        if all(_is_inline(node, safe=True) for leg in branch.legs for node in leg):
            legs = [self.series(leg, "True", needed=True) for leg in branch.legs]
            return both(power, either_of(legs))
        power = self.kept(power)
        ends = []
        for leg in branch.legs:
            leg_power = self.series(leg, power, needed=needed)
            if needed:
                ends.append(leg_power if leg_power == power else self.kept(leg_power))
        # a leg that passes the power on unchanged decides for all
        return power if not needed or power in ends else either_of(ends)

    def kept(self, power: str) -> str:
        """Return power as text that can be repeated."""
        return power if power in ("True", "False") else self.values.keep(power)

    def outputs(self, nodes: Iterable[Node], power: str) -> None:
        """Write instructions that act when true."""
        if power == "True":
            for node in nodes:
                self._act(node)
            return
        with self.writer.block(f"if {power}:"):
            for node in nodes:
                self._act(node)

    def _act(self, node: Node) -> None:
        assert isinstance(node, LoweredStep)
        self.values.site = node.site
        self._write(node)

    def step(self, step: LoweredStep, power: str, *, needed: bool) -> str:
        """Write an instruction; return the power after it, valid only if `needed`."""
        self.values.site = step.site
        if step.spec.decides:
            return self._write(step, power)
        if step.kind is InstructionKind.INPUT:
            return self._input(step, power)
        if needed:
            power = self.kept(power)
        if step.kind is InstructionKind.OUTPUT:
            self.outputs((step,), power)
        else:
            self._write(step, power)
        return power

    def _write(self, step: LoweredStep, *power: str) -> str:
        """Write an instruction; return an input's truth, power after a deciding instruction, or ""."""
        self.writer.instructions += 1
        if step.spec.write is not None:
            return step.spec.write(self, *power, *step.operands) or ""
        call = self._interpretation(*power)
        if step.kind is InstructionKind.INPUT or step.spec.decides:
            return self.values.keep(call)
        self.writer.line(call)
        return ""

    def interpret(self, *power: str) -> None:
        """Write a call to the interpreter for the current instruction, by default as on a true rung."""
        self.writer.line(self._interpretation(*power))

    def interpreted(self) -> str:
        """Write a call to the interpreter for an input; return the power after it."""
        return self.values.keep(self._interpretation())

    def _interpretation(self, *power: str) -> str:
        """Return text for the interpreter's call for the current instruction, with an add-on's stores."""
        frame = self.values.stores()
        arguments = [str(self.values.site), *power, *([f"frame={frame}"] if frame else [])]
        return f"interpret({', '.join(arguments)})"

    def _input(self, step: LoweredStep, power: str) -> str:
        """Write an input; return the power after it. If it needs lines, it is evaluated only with power."""
        if _is_inline(step):
            return both(power, self._write(step))
        if power == "True":
            return self.kept(self._write(step))
        result = self.values.keep("False")
        with self.writer.block(f"if {power}:"):
            self.writer.line(f"{result} = {self._write(step)}")
        return result

    def either(self, power: str, when_true: Callable[[], None], when_false: Callable[[], None]) -> None:
        """Write an instruction's actions on a true rung and on a false rung."""
        if power == "True":
            when_true()
        elif power == "False":
            when_false()
        else:
            with self.writer.block(f"if {power}:"):
                when_true()
            with self.writer.block("else:"):
                when_false()


def _first_of_last_outputs(nodes: tuple[Node, ...]) -> int:
    """Return the index of the first of the trailing outputs that act only when true."""
    return len(nodes) - sum(1 for _ in takewhile(_acts_when_true, reversed(nodes)))


def _acts_when_true(node: Node) -> bool:
    return isinstance(node, LoweredStep) and node.kind is InstructionKind.OUTPUT


def _is_inline(node: Node, *, safe: bool = False) -> bool:
    """Return whether a node is an input in one expression that, with `safe`, can't fault."""
    if isinstance(node, Parallel):
        return all(_is_inline(element, safe=safe) for leg in node.legs for element in leg)
    spec = node.spec
    if (
        spec.kind is not InstructionKind.INPUT
        or spec.decides
        or spec.write is None
        or not spec.inline(*node.operands)
    ):
        return False
    operands = [operand for operand in node.operands if not isinstance(operand, str)]
    return not any(map(calculates, operands)) and not (safe and any(map(can_fault, operands)))
