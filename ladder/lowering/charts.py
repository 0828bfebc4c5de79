"""Lowering of sequential function charts, to conditions and statements like those of structured text.

    IF begin(chart) THEN                       paused, or first started; see `instructions.charts`
        clock(chart)
        first := 1
        REPEAT                                 the loop only with `UNTIL_FALSE`
            moved := 0
            IF Fill.X AND (first OR Fill.new)  each step in its order
                step(Fill)                     its timer and status bits
                IF action(Open) THEN call the body
                done(Fill)
            ELSIF first AND one of its actions is on or stored THEN ...
            IF Fill.X AND NOT Fill.new         each transition: its steps have been executed
                Tran_1 := condition
                IF Tran_1 THEN fire(Tran_1)
            first := 0, delta := 0
        UNTIL NOT moved

A body is its own routine, `Sequence.Fill.Open`.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce
from typing import Any
from zlib import crc32

from ..instructions.charts import ACT, BEGIN, CALL, CLOCK, DONE, STEP, fire_of
from ..instructions.statements import CONDITION, assignment
from ..instructions.system.sfc import EOT_STATE
from ..model.chart import (
    ACTION_TYPE,
    STEP_TYPE,
    STOP_TYPE,
    Action,
    Chart,
    ChartStep,
    ExecutionControl,
    Transition,
    body_name,
    presets_of,
)
from ..model.chart_checks import problems_of
from ..model.operand_checks import OperandError, mismatch
from ..model.operands import Calculation, Group, Place, Resolved, constant
from ..model.resolver import AddressError, missing_in
from ..model.routine import Routine
from ..model.spec import Spec
from ..model.tree import Address, Block, Instruction, Origin
from ..model.types import BOOL, HIDDEN, LINT, Structure
from ..state.lowered import (
    Act,
    Arms,
    Body,
    Call,
    ChartAction,
    ChartNode,
    ChartTransition,
    Loop,
    LoweredChart,
    LoweredLine,
    LoweredRoutine,
    LoweredStep,
)
from .statements import StatementLowering

ITSELF = -1
"""Number of the lines that belong to no element."""


class ChartLowering:
    """Lowers one chart."""

    def __init__(self, lowering: Any, routine: Routine) -> None:
        self._lowering = lowering
        self._name = routine.name
        assert routine.chart is not None
        self._tree: Chart = routine.chart
        self._statements = StatementLowering(lowering)
        self._lines: list[LoweredLine] = []
        self._number, self._origin = ITSELF, Origin()  # of the current element
        self._loops = False

    def bodies(self) -> Iterable[tuple[str, Block]]:
        """Yield name and statements of the bodies of actions."""
        for step, action, block in self._tree.bodies():
            yield body_name(self._name, step, action), block

    def routine(self) -> LoweredRoutine:
        """Lower the chart."""
        problems = [*problems_of(self._tree)]
        for problem in problems:
            self._lowering.at(problem.number, Origin(), problem.element)
            self._lowering.report(f"{problem.element}: {problem.text}", problem.remedy)
        chart = None if problems else self._chart()
        if chart is None:
            return LoweredRoutine(self._name, (), {}, None, ())
        self._lowering.lowered.charts[self._name.upper()] = chart
        body = self._body(chart)
        return LoweredRoutine(self._name, tuple(self._lines), {}, self._parameters(), body, chart=chart)

    def _parameters(self) -> tuple[Place, ...] | None:
        return tuple(self._lowering.target(operand) for operand in self._tree.inputs) or None

    # --- the chart's data

    def _chart(self) -> LoweredChart | None:
        try:
            return self._resolved()
        except (AddressError, OperandError) as error:
            self._lowering.report(str(error), error.remedy, tag=missing_in(error))
            return None

    def _resolved(self) -> LoweredChart:
        nodes: dict[str, ChartNode] = {}
        actions: list[ChartAction] = []
        for step in self._tree.steps:
            self._lowering.at(step.number, step.origin, step.head)
            tag = self._tag(step.name, STOP_TYPE if step.stop else STEP_TYPE)
            index, bits = lasting_number(step.name), self._bits(tag)
            node = ChartNode(index, step.number, step.name, bits, tag, step.stop)
            nodes[step.name.upper()] = node
            node.actions = tuple(self._action(step, action, node, actions) for action in step.actions)
        for lowered in actions:
            lowered.resets = tuple(
                other for other in actions if other.tag.path == lowered.tag.path and other is not lowered
            )
        transitions = tuple(self._transition(transition, nodes) for transition in self._tree.transitions)
        initial = self._tree.initial
        assert initial is not None
        return LoweredChart(
            self._name,
            self._lowering.lowered.chart_options,
            tuple(nodes.values()),
            tuple(actions),
            transitions,
            nodes[initial.name.upper()],
            **{name: self._leaf(name) for name in ("state", "reset", "last", "seen", "delta", "rest")},
            first=self._leaf("first", BOOL),
            moved=self._leaf("moved", BOOL),
        )

    def _leaf(self, name: str, kind: Any = LINT) -> Place:
        leaf = self._lowering.lowered.layout.hidden(f"{HIDDEN}{self._name}.{name}", kind)
        return Place(leaf, (), None, f"{self._name}.{name}")

    def _tag(self, name: str, kind: str) -> Group:
        tag = self._lowering.resolver.operand(Address(name))
        if not isinstance(tag, Group) or tag.dims or tag.type.name != kind:
            raise mismatch(name, tag, f"a tag of type {kind}", "declare it so")
        return tag

    def _bits(self, tag: Group) -> dict[str, Place]:
        """Return the members of a step or action by name, bits of Status included."""
        assert isinstance(tag.type, Structure)
        bits = {member.name: tag.member(member.name) for member in tag.type.members}
        return bits | {member.name: tag.member(f"{HIDDEN}{member.name}") for member in tag.type.hidden}

    def _action(
        self, step: ChartStep, action: Action, node: ChartNode, actions: list[ChartAction]
    ) -> ChartAction:
        self._lowering.at(action.number, action.origin, action.head)
        tag = self._tag(action.name, ACTION_TYPE)
        body = None if action.body is None else body_name(self._name, step, action).upper()
        index, bits = lasting_number(f"{step.name}.{action.name}"), self._bits(tag)
        lowered = ChartAction(index, action.number, action.name, action.qualifier, bits, tag, body, node)
        actions.append(lowered)
        return lowered

    def _transition(self, transition: Transition, nodes: dict[str, ChartNode]) -> ChartTransition:
        self._lowering.at(transition.number, transition.origin, transition.head)
        place = self._lowering.target(Address(transition.name))
        if not place.type.is_bool:
            raise mismatch(transition.name, place, "a BOOL", "declare it so")
        sources, targets = (
            tuple(nodes[name.upper()] for name in names) for names in (transition.sources, transition.targets)
        )
        return ChartTransition(transition.number, transition.name, sources, targets, place)

    # --- lines

    def _at(self, number: int = ITSELF, origin: Origin | None = None) -> None:
        """Start the lines of an element, or of the chart itself."""
        self._number, self._origin = number, origin or self._tree.steps[0].origin

    def _line(self, text: str, spec: Spec, *operands: Any) -> LoweredLine:
        """Add and return a line of the current element."""
        self._lowering.at(self._number, self._origin, text)
        return self._added(text, LoweredStep(spec, operands, self._lowering.site(text)))

    def _added(self, text: str, step: LoweredStep) -> LoweredLine:
        line = LoweredLine(self._number, (step,), self._origin, text, "")
        self._lines.append(line)
        return line

    def _set(self, place: Place, value: Resolved, text: str) -> Act:
        return Act(self._line(text, assignment(place, retentive=True), place, value))

    def _block(self, block: Block) -> Body:
        """Lower statements of structured text."""
        body = self._statements.body(block)
        self._lines += self._statements.taken()
        return body

    def _body(self, chart: LoweredChart) -> Body:
        self._at()
        self._loops = chart.options.control is ExecutionControl.UNTIL_FALSE
        begin = self._line("begin of the chart", BEGIN, chart)
        clock = Act(self._line("clock of the chart", CLOCK, chart))
        body: list[Any] = [Arms(((begin, (clock, *self._scan(chart))),), ())]
        if self._tree.returns:
            self._at()
            returned = Instruction("RET", self._tree.returns)
            self._lowering.at(ITSELF, Origin(), str(returned))
            body.append(Act(self._added(str(returned), self._lowering.step(returned))))
        return tuple(body)

    def _scan(self, chart: LoweredChart) -> Body:
        """Lower the steps and the transitions, once or until no transition is true."""
        if not self._loops:
            return self._pass(chart)
        first = self._set(chart.first, constant(1), "first pass")
        start = self._set(chart.moved, constant(0), "next pass")
        inner = self._pass(chart)
        self._at()
        end = (
            self._set(chart.first, constant(0), "no further first pass"),
            *(
                self._set(place, constant(0), "no time until the next pass")
                for place in (chart.delta, chart.rest)
            ),
        )
        until = self._line("until no transition is true", CONDITION, Calculation("NOT", (chart.moved,)))
        return (first, Loop(None, None, (start, *inner, *end), None, until))

    def _pass(self, chart: LoweredChart) -> Body:
        steps = zip(chart.nodes, self._tree.steps, strict=True)
        transitions = zip(chart.transitions, self._tree.transitions, strict=True)
        return (
            *(self._step(chart, node, tree) for node, tree in steps if not node.stop),
            *(self._leaving(chart, transition, tree) for transition, tree in transitions),
        )

    def _step(self, chart: LoweredChart, node: ChartNode, tree: ChartStep) -> Arms:
        self._at(tree.number, tree.origin)
        text, active = f"step {node.name}", node.bits["X"]
        when: Resolved = active
        if self._loops:
            when = _and(active, _or(chart.first, node.bits["new"]))
        head = self._line(f"{text} is active", CONDITION, when)
        presets = self._block(tuple(presets_of(tree)))
        step = Act(self._line(text, STEP, chart, node, node.tag))
        actions = self._actions(chart, node.actions, tree)
        self._at(tree.number, tree.origin)
        done = Act(self._line(f"{text} is done", DONE, node))
        return Arms(((head, (*presets, step, *actions, done)), *self._after(chart, node, tree)), ())

    def _after(
        self, chart: LoweredChart, node: ChartNode, tree: ChartStep
    ) -> tuple[tuple[LoweredLine, Body], ...]:
        """Lower the actions that may be on while their step is inactive."""
        lasting = tuple(action for action in node.actions if action.outlives)
        if not lasting:
            return ()
        stored = [_is_not_0(action.bits["latch"]) for action in lasting if action.qualifier.is_stored]
        after = _or(*(action.bits["A"] for action in lasting), *stored)
        if self._loops:
            after = _and(chart.first, after)
        self._at(tree.number, tree.origin)
        head = self._line(f"step {node.name}: actions after it", CONDITION, after)
        return ((head, self._actions(chart, lasting, tree)),)

    def _actions(self, chart: LoweredChart, actions: tuple[ChartAction, ...], tree: ChartStep) -> Body:
        origins = {action.number: action.origin for action in tree.actions}
        return tuple(self._act(chart, action, origins[action.number]) for action in actions)

    def _act(self, chart: LoweredChart, each: ChartAction, origin: Origin) -> Arms:
        self._at(each.number, origin)
        text = f"step {each.node.name}, action {each.name} ({each.qualifier.value})"
        head = self._line(text, ACT, chart, each, each.tag)
        if each.body is None:
            return Arms(((head, ()),), ())
        call = self._line(f"{text}: body", CALL, Call(each.body, (), ()))
        return Arms(((head, (Act(call),)),), ())

    def _leaving(self, chart: LoweredChart, each: ChartTransition, tree: Transition) -> Arms:
        self._at(each.number, tree.origin)
        text = f"transition {each.name}"
        executed = [(node.bits["X"], Calculation("NOT", (node.bits["new"],))) for node in each.sources]
        sources, targets = (
            " and ".join(node.name for node in nodes) for nodes in (each.sources, each.targets)
        )
        head = self._line(
            f"{text} after {sources}", CONDITION, _and(*(part for pair in executed for part in pair))
        )
        decided = self._decided(each, tree)
        true = self._line(f"{text} is true", CONDITION, each.place)
        each.condition, each.text = self._condition_of(decided), str(tree.condition)
        tags = [node.tag for node in (*each.sources, *each.targets)]
        fire = Act(self._line(f"{text} to {targets}", fire_of(each), chart, each, each.condition, *tags))
        return Arms(((head, (*decided, Arms(((true, (fire,)),), ()))),), ())

    @staticmethod
    def _condition_of(decided: Body) -> Resolved:
        """Return the operand that is assigned to a transition's tag."""
        (step,) = decided[-1].line.nodes if isinstance(decided[-1], Act) else (None,)
        return step.operands[1] if isinstance(step, LoweredStep) and len(step.operands) > 1 else constant(0)

    def _decided(self, each: ChartTransition, tree: Transition) -> Body:
        """Lower the condition of a transition: statements that set its tag."""
        if not isinstance(tree.condition, Instruction):
            return self._block((tree.statement,))
        self._lowering.kept(EOT_STATE, 0)
        state = Place(self._lowering.lowered.layout.leaf(EOT_STATE), (), None, "EOT")
        clear = self._set(state, constant(0), "no EOT yet")
        called = self._block((tree.statement,))
        return (clear, *called, self._set(each.place, _is_not_0(state), f"{each.name} := EOT"))


def lasting_number(name: str) -> int:
    """Return a number above 0 that depends on a name alone, so online edits of the chart do not change it."""
    return crc32(name.upper().encode()) + 1


def _is_not_0(place: Place) -> Resolved:
    return Calculation("<>", (place, constant(0)))


def _and(*parts: Resolved) -> Resolved:
    return reduce(lambda a, b: Calculation("AND", (a, b)), parts)


def _or(*parts: Resolved) -> Resolved:
    return reduce(lambda a, b: Calculation("OR", (a, b)), parts)
