"""Check a whole program for errors, such as missing routines, and for likely mistakes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

from scanrack.io_images.site import Site

from ..instructions.motion import ideal_moves, ideal_systems
from ..instructions.motion.motion_3601 import STARTERS
from ..model.errors import Problem
from ..model.operand_checks import described
from ..model.operands import Constant, Group, Place, Resolved, first_leaf
from ..model.schedule import TaskKind
from ..model.spec import Use
from ..model.stubs import ALL_MESSAGES, Ending, InPython, Power, stub_of
from ..model.tags import Leaf
from ..model.types import dims_text
from ..state.lowered import (
    ADD_ON,
    AddOnCall,
    Call,
    LoweredLine,
    LoweredProgram,
    LoweredRoutine,
    LoweredStep,
)
from ..state.regions import ArrayRegion, region_of

REPEATED_COILS = "repeated coils"
REPEATED_TIMERS = "repeated timers"
ALLOWANCES = (REPEATED_COILS, REPEATED_TIMERS)
"""Warnings that a program can allow by name."""

_EXCLUSIVE = {
    Use.COIL: (
        REPEATED_COILS,
        "is written by a coil",
        "join the two as branches of one rung, or use OTL and OTU",
    ),
    Use.STORAGE: (REPEATED_COILS, "remembers a rung", "give each one-shot its own bit"),
    Use.TIMER: (REPEATED_TIMERS, "is timed", "give each rung its own timer, or join the rungs"),
}
"""Uses that should occur only once per place, each with the name of the allowance, the text and the
remedy."""

IDEAL = {*ideal_moves.STARTERS, *ideal_moves.GROUP_ACTIONS, *ideal_systems.STARTERS}
"""Motion instructions of ideal axes, their group and coordinate systems."""


def warnings_of(lowered: LoweredProgram, allowed: frozenset[str]) -> list[Problem]:
    """Return warnings of likely mistakes, except those allowed; see `ALLOWANCES`."""
    return [*_repeated(lowered, allowed), *_not_ideal(lowered)]


def check_whole(lowered: LoweredProgram) -> list[Problem]:
    """Return the errors of a lowered program as a whole."""
    return [
        *(problem for routine in lowered.routines.values() for problem in _jumps(lowered, routine)),
        *_deep_calls(lowered),
        *_main_with_inputs(lowered),
        *_half_words(lowered),
        *_without_stub(lowered),
        *_impossible_on_3601(lowered),
    ]


def _without_stub(lowered: LoweredProgram) -> Iterator[Problem]:
    """Yield a problem for each message without a stub."""
    for routine, line, step in _all_steps(lowered, copies=False):
        message = step.operands[0] if step.name == "MSG" else None
        if isinstance(message, Group) and stub_of(lowered.stubs, message.path) is None:
            remedy = (
                'describe its end: MSG = "done after 20 ms" below [stubs] of the rack file, '
                'STUB MSG : done after 20 ms, or program.stub("MSG", "done after 20 ms")'
            )
            text = f"no stub for the message {message.text}"
            yield _problem(routine, line, text, remedy)


def uses_of_stubs(lowered: LoweredProgram) -> Iterator[str]:
    """Yield the stub name, in capitals, of each stubbed instruction."""
    for _, _, step in _all_steps(lowered, copies=False):
        first = step.operands[0] if step.operands else None
        if isinstance(first, (Ending, Power, InPython)):
            yield step.name
        elif step.name == ALL_MESSAGES and isinstance(first, Group):
            yield first.path.upper() if first.path.upper() in lowered.stubs else ALL_MESSAGES
    yield from (connection.tag for connection in lowered.connections)


def ideal_motion_of(lowered: LoweredProgram) -> dict[str, list[str]]:
    """Return the motion instructions outside of add-ons, by ideal axis, group or coordinate system."""
    by_axis: dict[str, list[str]] = {}
    for _, _, step, axis in _motion_steps(lowered, on_3601=False):
        if not axis.frame and step.name not in by_axis.setdefault(axis.path, []):
            by_axis[axis.path].append(step.name)
    return by_axis


def _motion_steps(
    lowered: LoweredProgram, *, on_3601: bool
) -> Iterator[tuple[LoweredRoutine, LoweredLine, LoweredStep, Group]]:
    """Yield motion instructions, either on 3601s or all others, with their axis, group or system."""
    for routine, line, step in _all_steps(lowered, copies=False):
        axis = step.operands[0] if Use.MOTION in step.uses else None
        if isinstance(axis, Group) and (axis.path.upper() in lowered.axes) == on_3601:
            yield routine, line, step, axis


def _impossible_on_3601(lowered: LoweredProgram) -> Iterator[Problem]:
    """Yield problems with motion instructions that the 3601 of their axis can't execute."""
    for routine, line, step, axis in _motion_steps(lowered, on_3601=True):
        if step.name not in STARTERS:
            text = f"{axis.text} is a 3601, which can't do {step.name}"
            yield _problem(routine, line, text, f"a 3601 does {', '.join(STARTERS)}; stub it")


def _not_ideal(lowered: LoweredProgram) -> Iterator[Problem]:
    """Yield problems with motion instructions that neither a 3601 nor an ideal axis can execute."""
    for routine, line, step, _ in _motion_steps(lowered, on_3601=False):
        if step.name not in IDEAL:
            text = f"an ideal axis can't do {step.name}: it ends with ER, and ERR 25, illegal instruction"
            yield _problem(routine, line, text, "stub the instruction", "no-place")


def _repeated(lowered: LoweredProgram, allowed: frozenset[str]) -> Iterator[Problem]:
    """Yield a warning for each further use of a place that should be used once, unless it is allowed."""
    first_sites: dict[object, Site] = {}
    for routine, line, step in _all_steps(lowered, copies=False):
        for use, operand, place in exclusive_places(step):
            allowance, phrase, remedy = _EXCLUSIVE[use]
            if allowance in allowed:
                continue
            if place in first_sites:
                text = f"{operand.text} {phrase} in {first_sites[place].where} already"
                yield _problem(routine, line, text, remedy, "repeated-coil")
            else:
                first_sites[place] = _site(routine, line)


def exclusive_places(step: LoweredStep) -> Iterator[tuple[Use, Place | Group, object]]:
    """Yield an instruction's operands whose uses should occur once per place, each with a key."""
    for use, operand in zip(step.uses, step.operands, strict=False):
        place = _identity(use, step.name, operand) if use in _EXCLUSIVE else None
        if place is not None and isinstance(operand, Place | Group):
            yield use, operand, place


def _identity(use: Use, name: str, operand: object) -> object:
    """Return a key that is equal for equal places; None for a computed place."""
    kind = "bit" if use in (Use.COIL, Use.STORAGE) else use.name
    if isinstance(operand, Place):
        if operand.can_fault:
            return None
        bit = operand.bit.value if isinstance(operand.bit, Constant) else None
        return kind, operand.frame, operand.leaf.path, operand.fixed_index, bit
    if isinstance(operand, Group):
        if not all(isinstance(index, Constant) for index in operand.indices):
            return None
        return kind, operand.frame, operand.path, operand.indices
    return None


def _all_steps(
    lowered: LoweredProgram, *, copies: bool = True
) -> Iterator[tuple[LoweredRoutine, LoweredLine, LoweredStep]]:
    """Yield the instructions with valid operands, each with its routine and its rung or line.

    Args:
        copies: whether the copies of add-on parameters are included.
    """
    for routine in lowered.routines.values():
        for line in routine.lines:
            for step in line.all_steps if copies else line.steps:
                if step.operands or (step.name != ADD_ON and not step.spec.operands):
                    yield routine, line, step


def _site(routine: LoweredRoutine, line: LoweredLine) -> Site:
    origin = line.origin
    return Site("", routine.name, line.number, unit=routine.unit, file=origin.file, line=origin.line)


def _problem(routine: LoweredRoutine, line: LoweredLine, text: str, remedy: str, rule: str = "") -> Problem:
    site = _site(routine, line)
    return Problem(site.where, line.text, text, remedy, site, rule)


def _jumps(lowered: LoweredProgram, routine: LoweredRoutine) -> Iterator[Problem]:
    """Yield a problem for each jump, call or event with a missing or unsuitable target."""
    for line in routine.lines:
        for step in line.all_steps:
            problem = _jump_problem(lowered, routine, step) if step.operands else None
            if problem:
                yield _problem(routine, line, *problem)


def _jump_problem(
    lowered: LoweredProgram, routine: LoweredRoutine, step: LoweredStep
) -> tuple[str, str] | None:
    """Return the text and remedy of a problem with an instruction's target, or None."""
    target = step.operands[0]
    if step.name == "JMP" and target not in routine.labels:
        return f"no label {target} in the routine", "add LBL, or correct the name"
    if isinstance(target, Call):
        return _call_problem(lowered, target)
    if step.name in ("SFR", "SFP"):
        return _chart_problem(lowered, *step.operands)
    if step.name == "EVENT" and isinstance(target, str):
        return _event_problem(lowered, target)
    return None


def _chart_problem(lowered: LoweredProgram, routine: str, target: object) -> tuple[str, str] | None:
    """Return the problem with the chart or step in an SFR or SFP; None if both exist."""
    chart = lowered.charts.get(routine)
    if chart is None:
        names = ", ".join(lowered_chart.name for lowered_chart in lowered.charts.values()) or "none"
        return f"no sequential function chart {routine}", f"charts are {names}"
    if isinstance(target, Group) and chart.node_of(target) is None:
        names = ", ".join(node.name for node in chart.nodes)
        return f"{target.text} is not a step of chart {chart.name}", f"its steps are {names}"
    return None


def _event_problem(lowered: LoweredProgram, name: str) -> tuple[str, str] | None:
    """Return the problem with the task of an EVENT; None if it is an event task."""
    tasks = lowered.schedule.tasks if lowered.schedule is not None else ()
    events = [task.task.name for task in tasks if task.task.kind is TaskKind.EVENT]
    if name in map(str.upper, events):
        return None
    return f"no event task {name}", f"event tasks are {', '.join(events) or 'none'}"


def _call_problem(lowered: LoweredProgram, call: Call) -> tuple[str, str] | None:
    """Return the problem with the routine, inputs or results of a call; None if they fit."""
    if call.routine in lowered.functions:
        return None
    target = lowered.routines.get(call.routine)
    if target is None:
        names = [routine.name for routine in lowered.routines.values()]
        names += list(lowered.functions)
        return f"no routine {call.routine}", f"routines are {', '.join(names)}"
    parameters = target.parameters or ()
    if len(parameters) > len(call.inputs):
        text = f"{target.name} has {len(parameters)} inputs, but JSR passes {len(call.inputs)}"
        return text, "make SBR and JSR agree"
    mismatch = _type_mismatch(zip(call.inputs, parameters, strict=False))
    if mismatch:
        passed, expected = mismatch
        return f"{target.name} takes {expected}, {passed} is passed", "make SBR and JSR agree"
    return _return_problem(target, call)


def _return_problem(target: LoweredRoutine, call: Call) -> tuple[str, str] | None:
    """Return the problem with the first RET that does not fit a call; None if all fit."""
    for line in target.lines:
        for step in line.all_steps:
            if step.name != "RET":
                continue
            head = f"RET in {target.unit} {line.number} of {target.name} returns"
            if len(step.operands) < len(call.returns):
                text = f"{head} {len(step.operands)} values; JSR expects {len(call.returns)}"
                return text, "make RET and JSR agree"
            mismatch = _type_mismatch(zip(step.operands, call.returns, strict=False))
            if mismatch:
                returned, expected = mismatch
                return f"{head} {returned}; JSR expects {expected}", "make RET and JSR agree"
    return None


def _type_mismatch(pairs: Iterable[tuple[Resolved, Resolved]]) -> tuple[str, str] | None:
    """Return the types of the first passed and expected structures or arrays that differ."""
    for passed, expected in pairs:
        kinds = _type_text(passed), _type_text(expected)
        if kinds[0] != kinds[1] and (isinstance(passed, Group) or isinstance(expected, Group)):
            return kinds
    return None


def _type_text(parameter: Resolved) -> str:
    """Return a parameter's type and dimensions, such as `INT[5]`; describe a constant or calculation."""
    if not isinstance(parameter, Place | Group):
        return described(parameter)
    return parameter.type.name + (dims_text(parameter.dims) if isinstance(parameter, Group) else "")


def calls_of(routine: LoweredRoutine) -> list[str]:
    """Return the names in capitals of the routines that a routine calls, including add-on routines."""
    called: list[str] = []
    for line in routine.lines:
        for step in line.all_steps:
            for operand in step.operands:
                if isinstance(operand, Call):
                    called.append(operand.routine)
                elif isinstance(operand, AddOnCall):
                    called.extend(operand.routines)
    return called


def recursive_routines(lowered: LoweredProgram) -> frozenset[str]:
    """Return the names in capitals of routines that are directly or indirectly recursive."""
    recursive = set()
    for name, routine in lowered.routines.items():
        reached: set[str] = set()
        open_names = calls_of(routine)
        while open_names:
            called = open_names.pop()
            if called not in reached and called in lowered.routines:
                reached.add(called)
                open_names += calls_of(lowered.routines[called])
        if name in reached:
            recursive.add(name)
    return frozenset(recursive)


MOST_CALLS = 50
"""Maximum nesting depth of routine and add-on calls."""


def _deep_calls(lowered: LoweredProgram) -> Iterator[Problem]:
    """Yield a problem for the first routine whose calls nest too deeply; scans check recursion."""
    depths: dict[str, int] = {}
    non_recursive = lowered.routines.keys() - lowered.recursive
    pending = list(lowered.routines)
    while pending:
        name = pending[-1]
        called = [callee for callee in calls_of(lowered.routines[name]) if callee in non_recursive]
        unknown = [callee for callee in called if callee not in depths]
        if name not in depths and unknown:
            pending += unknown
            continue
        pending.pop()
        depths[name] = 1 + max((depths[callee] for callee in called), default=0)
        if depths[name] > MOST_CALLS:
            site = Site(routine=lowered.routines[name].name)
            text = f"its calls go more than {MOST_CALLS} deep"
            yield Problem(site.where, "", text, "call from fewer routines", site)
            return


def _main_with_inputs(lowered: LoweredProgram) -> Iterator[Problem]:
    """Yield a problem for each main or fault routine with inputs, because a scan passes none."""
    for name in sorted(lowered.roots):
        main = lowered.routines.get(name)
        if main is None or not main.parameters:
            continue
        site = Site(routine=main.name, rung=0)
        text = "SBR takes inputs, but a scan passes none to the main routine"
        yield Problem(site.where, main.lines[0].text, text, "remove SBR, or call the routine by JSR", site)


def _half_words(lowered: LoweredProgram) -> Iterator[Problem]:
    """Yield problems with copies of single bytes that can end in the middle of a word of an output image."""
    longest = max((image.size for image in lowered.layout.images if image.output), default=0)
    if not longest:
        return
    handed = _outputs_handed(lowered)
    for routine, line, step in _all_steps(lowered):
        if step.uses[:2] != (Use.SOURCE, Use.DESTINATION):
            continue
        source, target = (region_of(operand) for operand in step.operands[:2])
        length = step.operands[2]
        elements_left = longest if target.whole else target.fixed_left(target.fixed_first or 0)
        count = min(int(length.value), elements_left) if isinstance(length, Constant) else elements_left
        if _in_outputs(target.parts[0].leaf, handed) and _may_end_in_a_byte(source, count * target.size):
            text = (
                f"{source.text} may end in the middle of a word of {target.text}, "
                "which would then contain half of a new and half of an old command"
            )
            remedy = "copy from an array of INT, or copy an even number of bytes"
            yield _problem(routine, line, text, remedy)


def _outputs_handed(lowered: LoweredProgram) -> set[tuple[str, str]]:
    """Return the InOuts that receive words of an output image, as add-on and InOut names in capitals."""
    operands = chain.from_iterable(step.operands for _, _, step in _all_steps(lowered))
    calls = [operand for operand in operands if isinstance(operand, AddOnCall)]
    handed: set[tuple[str, str]] = set()
    while True:
        count = len(handed)
        for call in calls:
            for name, operand in call.handed.items():
                if _in_outputs(first_leaf(operand), handed):
                    handed.add((call.name, name))
        if len(handed) == count:
            return handed


def _in_outputs(leaf: Leaf, handed: set[tuple[str, str]]) -> bool:
    return (leaf.slot is not None and leaf.output) or (leaf.frame, leaf.root) in handed


def _may_end_in_a_byte(source: ArrayRegion, size: int) -> bool:
    """Return whether a copy can have an odd byte count because the source is shorter than `size`."""
    if source.size % 2 == 0:
        return False
    first = source.fixed_first
    if first is None:
        return True
    bytes_left = source.fixed_left(first) * source.size
    return bytes_left < size and bytes_left % 2 == 1
