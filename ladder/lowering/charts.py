"""Lower sequential function charts to conditions and statements, as in structured text.

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
"""Element number for lines of the chart itself."""


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
        self._loops = False  # whether a scan repeats passes until no transition is true

    def bodies(self) -> Iterable[tuple[str, Block]]:
        """Yield the name and statements of each action body."""
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
        """Return the chart with its tags; report a wrong tag and return None."""
        try:
            return self._resolve_chart()
        except (AddressError, OperandError) as error:
            self._lowering.report(str(error), error.remedy, tag=missing_in(error))
            return None

    def _resolve_chart(self) -> LoweredChart:
        """Return the chart; raise an AddressError or OperandError for a wrong tag."""
        nodes: dict[str, ChartNode] = {}
        actions: list[ChartAction] = []
        for step in self._tree.steps:
            self._lowering.at(step.number, step.origin, step.head)
            tag = self._tag(step.name, STOP_TYPE if step.stop else STEP_TYPE)
            index, bits = lasting_number(step.name), self._members_of(tag)
            node = ChartNode(index, step.number, step.name, bits=bits, tag=tag, stop=step.stop)
            nodes[step.name.upper()] = node
            node.actions = tuple(self._chart_action(step, tree, node) for tree in step.actions)
            actions += node.actions
        for action in actions:
            action.resets = tuple(
                other_action
                for other_action in actions
                if other_action.tag.path == action.tag.path and other_action is not action
            )
        transitions = tuple(
            self._chart_transition(transition, nodes) for transition in self._tree.transitions
        )
        initial = self._tree.initial
        assert initial is not None
        return LoweredChart(
            self._name,
            self._lowering.lowered.chart_options,
            nodes=tuple(nodes.values()),
            actions=tuple(actions),
            transitions=transitions,
            initial=nodes[initial.name.upper()],
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

    def _members_of(self, tag: Group) -> dict[str, Place]:
        """Return the members of a step or action by name, including bits of Status."""
        assert isinstance(tag.type, Structure)
        bits = {member.name: tag.member(member.name) for member in tag.type.members}
        return bits | {member.name: tag.member(f"{HIDDEN}{member.name}") for member in tag.type.hidden}

    def _chart_action(self, step: ChartStep, action: Action, node: ChartNode) -> ChartAction:
        """Return an action with its tag; raise an AddressError or OperandError for a wrong tag."""
        self._lowering.at(action.number, action.origin, action.head)
        tag = self._tag(action.name, ACTION_TYPE)
        body = None if action.body is None else body_name(self._name, step, action).upper()
        index, bits = lasting_number(f"{step.name}.{action.name}"), self._members_of(tag)
        return ChartAction(
            index, action.number, action.name, action.qualifier, bits=bits, tag=tag, body=body, node=node
        )

    def _chart_transition(self, transition: Transition, nodes: dict[str, ChartNode]) -> ChartTransition:
        """Return a transition with its tag; raise an AddressError or OperandError for a wrong tag."""
        self._lowering.at(transition.number, transition.origin, transition.head)
        place = self._lowering.target(Address(transition.name))
        if not place.type.is_bool:
            raise mismatch(transition.name, place, "a BOOL", "declare it so")
        sources, targets = (
            tuple(nodes[name.upper()] for name in names) for names in (transition.sources, transition.targets)
        )
        return ChartTransition(transition.number, transition.name, sources, targets, place)

    # --- lines

    def _start_element(self, number: int = ITSELF, origin: Origin | None = None) -> None:
        """Start the lines of an element, or of the chart itself."""
        self._number, self._origin = number, origin or self._tree.steps[0].origin

    def _line(self, text: str, spec: Spec, *operands: Any) -> LoweredLine:
        """Add and return a line of the current element."""
        self._lowering.at(self._number, self._origin, text)
        return self._add_step(text, LoweredStep(spec, operands, self._lowering.site(text)))

    def _add_step(self, text: str, step: LoweredStep) -> LoweredLine:
        line = LoweredLine(self._number, (step,), self._origin, text, "")
        self._lines.append(line)
        return line

    def _assign(self, place: Place, value: Resolved, text: str) -> Act:
        return Act(self._line(text, assignment(place, retentive=True), place, value))

    def _lower_block(self, block: Block) -> Body:
        """Lower statements of structured text."""
        body = self._statements.body(block)
        self._lines += self._statements.take_lines()
        return body

    def _body(self, chart: LoweredChart) -> Body:
        """Lower the chart to statements, which also return its results."""
        self._start_element()
        self._loops = chart.options.control is ExecutionControl.UNTIL_FALSE
        begin = self._line("begin of the chart", BEGIN, chart)
        clock = Act(self._line("clock of the chart", CLOCK, chart))
        body: list[Any] = [Arms(((begin, (clock, *self._scan_body(chart))),), ())]
        if self._tree.returns:
            self._start_element()
            returned = Instruction("RET", self._tree.returns)
            self._lowering.at(ITSELF, Origin(), str(returned))
            body.append(Act(self._add_step(str(returned), self._lowering.step(returned))))
        return tuple(body)

    def _scan_body(self, chart: LoweredChart) -> Body:
        """Lower the steps and transitions, to run once or until no transition is true."""
        if not self._loops:
            return self._pass_body(chart)
        first = self._assign(chart.first, constant(1), "first pass")
        start = self._assign(chart.moved, constant(0), "next pass")
        inner = self._pass_body(chart)
        self._start_element()
        end = (
            self._assign(chart.first, constant(0), "no further first pass"),
            *(
                self._assign(place, constant(0), "no time until the next pass")
                for place in (chart.delta, chart.rest)
            ),
        )
        until = self._line("until no transition is true", CONDITION, Calculation("NOT", (chart.moved,)))
        return (first, Loop(start=None, test=None, body=(start, *inner, *end), advance=None, until=until))

    def _pass_body(self, chart: LoweredChart) -> Body:
        """Lower the steps, except stops, and then the transitions: one pass."""
        steps = zip(chart.nodes, self._tree.steps, strict=True)
        transitions = zip(chart.transitions, self._tree.transitions, strict=True)
        return (
            *(self._lower_step(chart, node, tree) for node, tree in steps if not node.stop),
            *(self._lower_transition(chart, transition, tree) for transition, tree in transitions),
        )

    def _lower_step(self, chart: LoweredChart, node: ChartNode, tree_step: ChartStep) -> Arms:
        """Lower a step: presets, timer, actions and end; if inactive, only lasting actions."""
        self._start_element(tree_step.number, tree_step.origin)
        text, active = f"step {node.name}", node.bits["X"]
        condition: Resolved = active
        if self._loops:
            condition = _and(active, _or(chart.first, node.bits["new"]))
        head = self._line(f"{text} is active", CONDITION, condition)
        presets = self._lower_block(tuple(presets_of(tree_step)))
        step = Act(self._line(text, STEP, chart, node, node.tag))
        actions = self._actions(chart, node.actions, tree_step)
        self._start_element(tree_step.number, tree_step.origin)
        done = Act(self._line(f"{text} is done", DONE, node))
        return Arms(
            ((head, (*presets, step, *actions, done)), *self._lasting_arms(chart, node, tree_step)), ()
        )

    def _lasting_arms(
        self, chart: LoweredChart, node: ChartNode, tree_step: ChartStep
    ) -> tuple[tuple[LoweredLine, Body], ...]:
        """Lower the actions that can be on while their step is inactive."""
        lasting = tuple(action for action in node.actions if action.outlives)
        if not lasting:
            return ()
        stored = [_is_not_0(action.bits["latch"]) for action in lasting if action.qualifier.is_stored]
        condition = _or(*(action.bits["A"] for action in lasting), *stored)
        if self._loops:
            condition = _and(chart.first, condition)
        self._start_element(tree_step.number, tree_step.origin)
        head = self._line(f"step {node.name}: actions after it", CONDITION, condition)
        return ((head, self._actions(chart, lasting, tree_step)),)

    def _actions(self, chart: LoweredChart, actions: tuple[ChartAction, ...], tree: ChartStep) -> Body:
        origins = {action.number: action.origin for action in tree.actions}
        return tuple(self._lower_action(chart, action, origins[action.number]) for action in actions)

    def _lower_action(self, chart: LoweredChart, action: ChartAction, origin: Origin) -> Arms:
        """Lower an action. Its body runs while the action is on; a Boolean action has no body."""
        self._start_element(action.number, origin)
        text = f"step {action.node.name}, action {action.name} ({action.qualifier.value})"
        head = self._line(text, ACT, chart, action, action.tag)
        if action.body is None:
            return Arms(((head, ()),), ())
        call = self._line(f"{text}: body", CALL, Call(action.body, (), ()))
        return Arms(((head, (Act(call),)),), ())

    def _lower_transition(self, chart: LoweredChart, transition: ChartTransition, tree: Transition) -> Arms:
        """Lower a transition. It sets its tag once its steps have run, and fires if its condition is true.

        Store its condition, and the condition's text, in `transition`.
        """
        self._start_element(transition.number, tree.origin)
        text = f"transition {transition.name}"
        executed: list[Resolved] = []
        for node in transition.sources:
            executed += (node.bits["X"], Calculation("NOT", (node.bits["new"],)))
        sources, targets = (
            " and ".join(node.name for node in nodes) for nodes in (transition.sources, transition.targets)
        )
        head = self._line(f"{text} after {sources}", CONDITION, _and(*executed))
        condition = self._condition_body(transition, tree)
        true = self._line(f"{text} is true", CONDITION, transition.place)
        transition.condition, transition.text = self._assigned_value(condition), str(tree.condition)
        tags = [node.tag for node in (*transition.sources, *transition.targets)]
        fire = Act(
            self._line(
                f"{text} to {targets}", fire_of(transition), chart, transition, transition.condition, *tags
            )
        )
        return Arms(((head, (*condition, Arms(((true, (fire,)),), ()))),), ())

    @staticmethod
    def _assigned_value(body: Body) -> Resolved:
        """Return the operand that a condition's statements assign to the transition's tag."""
        (step,) = body[-1].line.nodes if isinstance(body[-1], Act) else (None,)
        return step.operands[1] if isinstance(step, LoweredStep) and len(step.operands) > 1 else constant(0)

    def _condition_body(self, transition: ChartTransition, tree: Transition) -> Body:
        """Lower the condition of a transition to statements that set its tag."""
        if not isinstance(tree.condition, Instruction):
            return self._lower_block((tree.statement,))
        self._lowering.kept(EOT_STATE, 0)
        state = Place(self._lowering.lowered.layout.leaf(EOT_STATE), (), None, "EOT")
        clear = self._assign(state, constant(0), "no EOT yet")
        called = self._lower_block((tree.statement,))
        return (clear, *called, self._assign(transition.place, _is_not_0(state), f"{transition.name} := EOT"))


def lasting_number(name: str) -> int:
    """Return a number above 0 that depends only on a name, so online edits do not change it."""
    return crc32(name.upper().encode()) + 1


def _is_not_0(place: Place) -> Resolved:
    return Calculation("<>", (place, constant(0)))


def _and(*parts: Resolved) -> Resolved:
    return reduce(lambda a, b: Calculation("AND", (a, b)), parts)


def _or(*parts: Resolved) -> Resolved:
    return reduce(lambda a, b: Calculation("OR", (a, b)), parts)
