"""Rungs that record their power cheaply.

    XIC(a)XIO(b)[XIC(c)XIC(d),XIC(e)]OTE(f)

    __1 = 0 if not (a) else 1 if not (not b) else 2     how far power got in a run of inputs
    __2 = __1 == 2
    __3 = False
    if __2:                                             skipped without power
        __4 = 0 if not (c) else 1 if not (d) else 2
        __5 = __4 == 2
        __6 = e
        __3 = (__5 or __6)
        __notes[90] = __4                               a place in the list per variable
        __notes[91] = __6
    f = __3
    __notes[7] = __1
    __notes[92] = __3

    power after    XIC(a)  XIO(b)  XIC(c)           XIC(d)           XIC(e)           OTE(f)
    is             [7]>0   [7]>1   [7]>1 and [90]>0 [7]>1 and [90]>1 [7]>1 and [91]>0 [92]>0

The last line is the rung's `Reading`: notes are read on demand. A rung that can leave its routine, and a line
of structured text, store the power as a tuple in their first place.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import takewhile

from ..model.spec import InstructionKind
from ..state.lowered import LoweredLine, LoweredStep, Node, Parallel
from .observed import NOTES
from .rungs import RungWriter
from .writer import both, either_of

_ALWAYS, _NEVER = -1, 1 << 30  # thresholds for always and for never

Above = tuple[str, int]
"""A variable and a threshold: there is power if the variable is greater than the threshold."""


def write_rung(rungs: RungWriter, line: LoweredLine, power: str) -> None:
    """Write a rung, and note its power if the rung is observed."""
    if rungs.notes.place(line.number) is None:
        rungs.series(line.nodes, power, needed=False)
    else:
        NotedRung(rungs, line).write(power)


class NotedRung:
    """Writes one rung and notes the power after each instruction."""

    def __init__(self, rungs: RungWriter, line: LoweredLine) -> None:
        self._rungs, self._notes, self._line = rungs, rungs.notes, line
        self._writer = rungs.writer
        self._leaves = any(step.spec.leaves for step in line.steps)
        self._powers: list[tuple[Above, ...]] = []  # conditions of power per instruction
        self._guards: tuple[Above, ...] = ()  # conditions of the branches around, outermost first
        self._power_as_above: dict[str, Above] = {"True": ("", _ALWAYS), "False": ("", _NEVER)}
        # "" is constant power, whose threshold alone decides
        self._place_of_variable = {"": rungs.notes.places[line.number]}
        self._extra_places = 0

    def write(self, power: str) -> None:
        """Write the rung."""
        self._series(self._line.nodes, self._rungs.kept(power))
        if self._leaves:
            self._note_tuple()
        else:
            self._note()

    def _series(self, nodes: tuple[Node, ...], power: str) -> str:
        """Write a series; return the variable with the power after its last instruction."""
        while nodes:
            node, count = nodes[0], 1
            inputs = self._rungs.inline_run(nodes)
            outputs = _plain_outputs(nodes)
            if isinstance(node, Parallel):
                power = self._branch(node, power)
            elif len(inputs) > 1:
                power, count = self._inputs(inputs, power), len(inputs)
            elif len(outputs) > 1:
                self._rungs.outputs(outputs, power)
                count = len(outputs)
                self._add_powers(power, count)
            else:
                power = self._step(node, power)
            nodes = nodes[count:]
        return power

    def _step(self, step: LoweredStep, power: str) -> str:
        """Write an instruction and add its power; return the variable with the power after it.

        The power so far is noted first if the instruction can leave the routine.
        """
        if step.spec.leaves:
            self._note_tuple()
        power = self._rungs.kept(self._rungs.step(step, power, needed=True))
        self._add_powers(power)
        return power

    def _add_powers(self, power: str, count: int = 1) -> None:
        """Add the power after `count` instructions, which is on if a variable is true."""
        self._powers += [(*self._guards, self._power_as_above.get(power, (power, 0)))] * count

    def _inputs(self, run: tuple[LoweredStep, ...], power: str) -> str:
        """Write a run of inputs as one variable, the number of inputs passed; return the power after them."""
        first, *tests_after = (self._rungs.inline(step) for step in run)
        tests = [both(power, first), *tests_after]
        ends = "".join(f"{passed} if not ({test}) else " for passed, test in enumerate(tests))
        reached = self._rungs.values.keep(f"{ends}{len(run)}")
        self._powers += [(*self._guards, (reached, threshold)) for threshold in range(len(run))]
        power_after = self._rungs.kept(f"{reached} == {len(run)}")
        self._power_as_above[power_after] = (reached, len(run) - 1)
        return power_after

    def _branch(self, branch: Parallel, power: str) -> str:
        """Write a branch; return the power after it.

        A branch that does nothing without power is written in an `if`, which also skips its notes.
        """
        if power in ("True", "False") or self._leaves or not self._is_idle_without_power(branch):
            return self._rungs.kept(either_of([self._series(leg, power) for leg in branch.legs]))
        result = self._rungs.values.keep("False")
        outer = self._guards
        with self._writer.block(f"if {power}:"):
            self._guards = (*outer, self._power_as_above.get(power, (power, 0)))
            first_new = len(self._powers)
            legs = [self._series(leg, "True") for leg in branch.legs]
            self._writer.line(f"{result} = {either_of(legs)}")
            guard_count = len(self._guards)
            self._note_variables(
                name for powers in self._powers[first_new:] for name, _ in powers[guard_count:]
            )
        self._guards = outer
        return result

    def _is_idle_without_power(self, node: Node) -> bool:
        """Return whether a node does nothing on a false rung."""
        if isinstance(node, Parallel):
            return all(self._is_idle_without_power(element) for leg in node.legs for element in leg)
        return _acts_plainly(node) or bool(self._rungs.inline_run((node,)))

    # --- notes

    def _note_tuple(self) -> None:
        """Note the power collected so far as a tuple."""
        powers = "".join(f"{_condition_text(*above)}, " for (above,) in self._powers)
        self._writer.line(f"{self._notes.place(self._line.number)} = ({powers})")

    def _note(self) -> None:
        """Note the remaining variables (at least one), and set how to read the notes."""
        self._note_variables((name for powers in self._powers for name, _ in powers), last=True)
        self._notes.read(self._line.number, tuple(map(self._reading, self._powers)))

    def _reading(self, powers: tuple[Above, ...]) -> tuple[int, int, tuple[tuple[int, int], ...]]:
        """Return the entry of an instruction in the rung's `Reading`: one condition, then the others."""
        (first, least), *more = ((self._place_of_variable[name], threshold) for name, threshold in powers)
        return first, least, tuple(more)

    def _note_variables(self, names: Iterator[str], *, last: bool = False) -> None:
        """Note each variable once; with `last`, the first variable goes to the line's first place."""
        fresh = [name for name in dict.fromkeys(names) if name not in self._place_of_variable]
        if last and not fresh:
            fresh = ["True"]
        for name in fresh:
            if last and fresh[0] is name:
                place = self._place_of_variable[""]
            else:
                self._extra_places += 1
                place = self._notes.extra_place(self._line.number, self._extra_places)
            self._place_of_variable[name] = place
            self._writer.line(f"{NOTES}[{place}] = {name}")


def _condition_text(name: str, threshold: int) -> str:
    """Return text for a condition of power; without a variable, the text is constant."""
    if not name:
        return "True" if threshold == _ALWAYS else "False"
    return f"{name} > {threshold}"


def _plain_outputs(nodes: tuple[Node, ...]) -> tuple[LoweredStep, ...]:
    """Return the leading outputs of a series that only act when true."""
    return tuple(node for node in takewhile(_acts_plainly, nodes) if isinstance(node, LoweredStep))


def _acts_plainly(node: Node) -> bool:
    """Return whether a node is an output that only acts when true, and always passes power on."""
    return (
        isinstance(node, LoweredStep)
        and node.kind is InstructionKind.OUTPUT
        and not (node.spec.leaves or node.spec.decides)
    )
