"""Instructions that together execute one scan of a sequential function chart.

`lowering.charts` puts these rows in the order of a scan. Step and action times are counted in ms from the
scan that activates them [1756-PM006: step tags, action tags, choose a qualifier, last scan options]. The rows
are not in `FAMILIES`, because rungs do not use them. A `LoweredChart` has these tags:

    state     0 new, 1 executing, 2 paused, 3 executing after program mode
    reset     index of the step that SFR names; 0 for none
    last      instant of the last execution, ns; `delta` is the time since then
    seen      instant of the last call, ns, even if the chart was paused; `rest` is the time since then
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..model.arithmetic import wrap
from ..model.chart import LastScan, Qualifier, RestartPosition
from ..model.operands import Group, Place
from ..model.spec import Spec, Use, action, condition, do_nothing
from ..model.types import DINT
from ..state.lowered import ChartAction, ChartNode, ChartTransition, LoweredChart
from .control import JSR

NEW, EXECUTING, PAUSED, RESUMED = range(4)

_MS = 1_000_000  # nanoseconds in a millisecond


def _set_members(machine: Interpreter, bits: Mapping[str, Place], **values: int) -> None:
    """Set members of a step or action by name; for a BOOL, any number but 0 is true."""
    for name, value in values.items():
        place = bits[name]
        machine.put(place, bool(value) if place.type.is_bool else value)


def _integer(machine: Interpreter, place: Place) -> int:
    return machine.whole(machine.get(place))


def _increment_count(machine: Interpreter, bits: Mapping[str, Place]) -> None:
    machine.put(bits["Count"], wrap(_integer(machine, bits["Count"]) + 1, DINT.bits))


def _show_time(machine: Interpreter, bits: Mapping[str, Place], ns: int) -> int:
    """Store a time in ns, set T to the time in ms, and return T."""
    shown = wrap(ns // _MS, DINT.bits)
    _set_members(machine, bits, ns=ns, T=shown)
    return shown


def _elapsed(machine: Interpreter, chart: LoweredChart, bits: Mapping[str, Place]) -> int:
    """Return the time since the last execution, excluding a pause if PauseTimer is set."""
    return _integer(machine, chart.rest if machine.get(bits["PauseTimer"]) else chart.delta)


def _members_of_all(chart: LoweredChart) -> Iterator[Mapping[str, Place]]:
    """Yield the members of each step, stop and action."""
    yield from (node.bits for node in chart.nodes)
    yield from (chart_action.bits for chart_action in chart.actions)


# --- the chart as a whole


def _begin(machine: Interpreter, chart: LoweredChart) -> bool:
    """Begin a scan of the chart; return whether it continues, which is false while the chart is paused.

    A new chart activates its initial step. A step that SFR names replaces the active steps.
    """
    state = _integer(machine, chart.state)
    if state == PAUSED:
        machine.put(chart.seen, machine.now_ns)
        return False
    if state != EXECUTING:
        machine.put(chart.last, machine.now_ns)
        machine.put(chart.seen, machine.now_ns)
        machine.put(chart.state, EXECUTING)
    if state == NEW:
        _clear(machine, chart)
        _activate(machine, chart.initial)
    target = _integer(machine, chart.reset)
    for node in chart.nodes if target else ():
        if node.index == target:
            _reset(machine, chart, node)
    return True


def _write_begin(rungs: RungWriter, chart: LoweredChart) -> str:
    """Return text for `_begin`, which is called unless the chart simply continues."""
    state, reset = rungs.values.read(chart.state), rungs.values.read(chart.reset)
    return f"(({state} == {EXECUTING} and not {reset}) or interpret({rungs.values.site}))"


def _clear(machine: Interpreter, chart: LoweredChart) -> None:
    """Make all steps and actions inactive; if charts restart at the initial step, clear counts and times."""
    machine.put(chart.reset, 0)
    for node in chart.nodes:
        _set_members(machine, node.bits, **dict.fromkeys(_CLEARED_AT_START & node.bits.keys(), 0))
    for chart_action in chart.actions:
        _set_members(machine, chart_action.bits, A=0, Q=0, T=0, ns=0, owner=0, latch=0)
    if chart.options.restart is RestartPosition.INITIAL:
        for bits in _members_of_all(chart):
            _set_members(machine, bits, **dict.fromkeys({"Count", "TMax"} & bits.keys(), 0))


_CLEARED_AT_START = frozenset(("X", "FS", "SA", "LS", "DN", "OV", "Reset", "T", "ns", "new"))
"""Members of a step that are cleared when the chart starts."""


def _reset(machine: Interpreter, chart: LoweredChart, target: ChartNode) -> None:
    """End all steps and actions, and continue at a step [1756-RM003, SFR]."""
    machine.put(chart.reset, 0)
    for chart_action in chart.actions:
        _end_action(machine, chart, chart_action)
    for node in chart.nodes:
        _set_members(machine, node.bits, **dict.fromkeys({"X", "SA", "new", "Reset"} & node.bits.keys(), 0))
    _activate(machine, target)


def _prescan(machine: Interpreter, chart: LoweredChart) -> None:
    """Restart the chart at its initial step, or else note that it was executing before program mode."""
    if chart.options.restart is RestartPosition.INITIAL:
        machine.put(chart.state, NEW)
    elif _integer(machine, chart.state) == EXECUTING:
        machine.put(chart.state, RESUMED)


def resume_chart(machine: Interpreter, chart: LoweredChart) -> None:
    """Continue a chart with its active steps and their times; do nothing if no step is active."""
    if not any(machine.get(node.bits["X"]) for node in chart.nodes):
        return
    machine.put(chart.state, RESUMED)
    for bits in _members_of_all(chart):
        if "T" in bits and "ns" in bits:  # the exact time, in ns, continues from T, in ms
            machine.put(bits["ns"], _integer(machine, bits["T"]) * _MS)


def _postscan(machine: Interpreter, chart: LoweredChart) -> None:
    """End the actions of a nested chart; if charts restart at the initial step, return to it."""
    for chart_action in chart.actions:
        _end_action(machine, chart, chart_action)
    if chart.options.restart is RestartPosition.INITIAL:
        _clear(machine, chart)
        machine.put(chart.state, NEW)


def _clock(machine: Interpreter, chart: LoweredChart) -> None:
    """Set `delta` and `rest` to the time since the last execution and since the last call."""
    for last, passed in ((chart.last, chart.delta), (chart.seen, chart.rest)):
        machine.put(passed, machine.now_ns - _integer(machine, last))
        machine.put(last, machine.now_ns)


def _write_clock(rungs: RungWriter, chart: LoweredChart) -> None:
    for last, passed in ((chart.last, chart.delta), (chart.seen, chart.rest)):
        rungs.values.assign(passed, f"now - {rungs.values.read(last)}")
        rungs.values.assign(last, "now")


# --- steps


def _activate(machine: Interpreter, node: ChartNode) -> None:
    """Activate a step and count the activation; unless it is a stop, its next scan is its first."""
    _set_members(machine, node.bits, X=1)
    _increment_count(machine, node.bits)
    if not node.stop:
        _set_members(machine, node.bits, new=1, T=0, ns=0, DN=0)


def _step(machine: Interpreter, chart: LoweredChart, node: ChartNode, _tag: Group) -> None:
    """Advance the time of an active step, and set its bits for the first scan, done and alarms."""
    bits = node.bits
    new = machine.truth(machine.get(bits["new"]))
    ns = 0 if new else _integer(machine, bits["ns"]) + _elapsed(machine, chart, bits)
    shown = _show_time(machine, bits, ns)
    _set_members(machine, bits, FS=new, SA=not new, TMax=max(_integer(machine, bits["TMax"]), shown))
    if shown >= _integer(machine, bits["PRE"]):
        _set_members(machine, bits, DN=1)
    if ns // _MS > DINT.highest:
        _set_members(machine, bits, OV=1)
    if machine.get(bits["AlarmEn"]) and shown >= _integer(machine, bits["LimitHigh"]):
        _set_members(machine, bits, AlarmHigh=1)


def _write_step(rungs: RungWriter, chart: LoweredChart, node: ChartNode, _tag: Group) -> None:
    """Write code that does the same as `_step`."""
    values, bits = rungs.values, node.bits
    new = values.keep(values.read(bits["new"]))
    ns = values.keep(_write_time(rungs, chart, bits, new))
    shown = values.keep(f"wrap({ns} // {_MS}, {DINT.bits})")
    values.assign(bits["ns"], ns)
    values.assign(bits["T"], shown)
    values.set_bit(bits["FS"], new)
    values.set_bit(bits["SA"], f"not {new}")
    too_long = f"{values.read(bits['AlarmEn'])} and {shown} >= {values.read(bits['LimitHigh'])}"
    for test, name, text in (
        (f"{shown} > {values.read(bits['TMax'])}", "TMax", shown),
        (f"{shown} >= {values.read(bits['PRE'])}", "DN", "True"),
        (f"{ns} > {(DINT.highest + 1) * _MS - 1}", "OV", "True"),
        (too_long, "AlarmHigh", "True"),
    ):
        with rungs.writer.block(f"if {test}:"):
            values.set_bit(bits[name], text)


def _write_time(rungs: RungWriter, chart: LoweredChart, bits: Mapping[str, Place], new: str) -> str:
    """Return text for the new time of a step or action in ns, which begins at 0 if `new` is true."""
    read = rungs.values.read
    passed = f"({read(chart.rest)} if {read(bits['PauseTimer'])} else {read(chart.delta)})"
    return f"0 if {new} else {read(bits['ns'])} + {passed}"


def _end_first_scan(machine: Interpreter, node: ChartNode) -> None:
    _set_members(machine, node.bits, FS=0, new=0)


def _write_end_of_first_scan(rungs: RungWriter, node: ChartNode) -> None:
    rungs.values.set_bit(node.bits["FS"], "False")
    rungs.values.set_bit(node.bits["new"], "False")


def _leave(machine: Interpreter, chart: LoweredChart, node: ChartNode) -> None:
    """Run the last scan of a step, then make the step inactive."""
    bits = node.bits
    _set_members(machine, bits, SA=0, LS=1)
    for chart_action in node.actions:
        if chart_action.qualifier in (Qualifier.P, Qualifier.P0):
            _pulse_action(machine, chart_action)
        elif chart_action.qualifier in (Qualifier.N, Qualifier.L, Qualifier.D):
            _end_action(machine, chart, chart_action)
    if machine.get(bits["AlarmEn"]) and _integer(machine, bits["T"]) < _integer(machine, bits["LimitLow"]):
        _set_members(machine, bits, AlarmLow=1)
    _set_members(machine, bits, LS=0, X=0)


JUMPS = 100
"""Number of backward jumps that a transition counts as; the watchdog allows 2,000 transitions per scan."""


def _fire_transition(
    machine: Interpreter, chart: LoweredChart, transition: ChartTransition, *_read: object
) -> None:
    """End the steps before a transition and begin the steps after it; count it for the watchdog."""
    machine.fault_log.jumped_back(machine.site, JUMPS)
    for node in transition.sources:
        _leave(machine, chart, node)
    for node in transition.targets:
        _activate(machine, node)
    machine.put(chart.moved, True)


# --- actions


def _update_action(machine: Interpreter, chart: LoweredChart, chart_action: ChartAction, _tag: Group) -> bool:
    """Start or end an action, in a scan of its step or later; return whether its body runs."""
    bits, qualifier = chart_action.bits, chart_action.qualifier
    active = machine.truth(machine.get(chart_action.node.bits["X"]))
    if qualifier is Qualifier.R:
        for reset_action in chart_action.resets if active else ():
            _end_action(machine, chart, reset_action)
        return False
    first = active and machine.truth(machine.get(chart_action.node.bits["new"]))
    was_on = _is_on(machine, chart_action)
    stored = _time_action(machine, chart, chart_action, active=active, first=first, was_on=was_on)
    reached = _integer(machine, bits["T"]) >= _integer(machine, bits["PRE"])
    runs, stored = _DECISIONS[qualifier](active, first, stored, reached)
    if stored:
        machine.put(bits["latch"], chart_action.index)
    if runs:
        _start_action(machine, chart_action, was_on=was_on)
        return chart_action.body is not None
    if was_on or not stored:
        _end_action(machine, chart, chart_action)
    return False


def _time_action(
    machine: Interpreter,
    chart: LoweredChart,
    chart_action: ChartAction,
    *,
    active: bool,
    first: bool,
    was_on: bool,
) -> bool:
    """Start or advance T; return whether the action is stored."""
    bits, qualifier = chart_action.bits, chart_action.qualifier
    stored = _integer(machine, bits["latch"]) == chart_action.index
    if first and not stored and qualifier is not Qualifier.P0:
        _show_time(machine, bits, 0)
        return qualifier in (Qualifier.S, Qualifier.SL, Qualifier.SD)
    if was_on or stored or (active and qualifier in (Qualifier.D, Qualifier.DS)):
        _show_time(machine, bits, _integer(machine, bits["ns"]) + _elapsed(machine, chart, bits))
    return stored


_Decision = Callable[[bool, bool, bool, bool], tuple[bool, bool]]

_DECISIONS: Mapping[Qualifier, _Decision] = {
    Qualifier.N: lambda active, _first, _stored, _reached: (active, False),
    Qualifier.P1: lambda _active, first, _stored, _reached: (first, False),
    Qualifier.P: lambda _active, first, _stored, _reached: (first, False),
    Qualifier.P0: lambda _active, _first, _stored, _reached: (False, False),
    Qualifier.L: lambda active, _first, _stored, reached: (active and not reached, False),
    Qualifier.D: lambda active, _first, _stored, reached: (active and reached, False),
    Qualifier.S: lambda _active, _first, stored, _reached: (stored, stored),
    Qualifier.SL: lambda _active, _first, stored, reached: (stored and not reached,) * 2,
    Qualifier.SD: lambda _active, _first, stored, reached: (stored and reached, stored),
    Qualifier.DS: lambda active, _first, stored, reached: (stored or (active and reached),) * 2,
}
"""By qualifier: returns whether an action is on, and whether it is stored [1756-PM006, choose a qualifier].

The arguments say whether its step is active, whether this is the first scan of the step, whether the action
was stored, and whether T has reached PRE.
"""


def _is_on(machine: Interpreter, chart_action: ChartAction) -> bool:
    """Return whether the tag of an action is on, and this action is its owner."""
    bits = chart_action.bits
    return machine.truth(machine.get(bits["A"])) and _integer(machine, bits["owner"]) == chart_action.index


def _start_action(machine: Interpreter, chart_action: ChartAction, *, was_on: bool) -> None:
    """Turn the tag of an action on, with this action as its owner; count it if it was off."""
    if not was_on:
        _increment_count(machine, chart_action.bits)
    _set_members(machine, chart_action.bits, A=1, Q=1, owner=chart_action.index)


def _pulse_action(machine: Interpreter, chart_action: ChartAction) -> None:
    """Run an action on the last scan of its step; it is on until the next scan of the chart."""
    if not _is_on(machine, chart_action):
        _show_time(machine, chart_action.bits, 0)
    _start_action(machine, chart_action, was_on=_is_on(machine, chart_action))
    if chart_action.body is not None:
        machine.call(chart_action.body, ())


def _end_action(machine: Interpreter, chart: LoweredChart, chart_action: ChartAction) -> None:
    """Make an action inactive after its last scan [1756-PM006, choose a last scan option]."""
    if _integer(machine, chart_action.bits["latch"]) == chart_action.index:
        _set_members(machine, chart_action.bits, latch=0)
    if not _is_on(machine, chart_action):
        return
    if chart_action.body is not None:
        _set_members(machine, chart_action.bits, Q=0)
        _scan_last(machine, chart.options.last_scan, chart_action.body, pulse=chart_action.qualifier.is_pulse)
    _set_members(machine, chart_action.bits, A=0, Q=0, owner=0)


def _scan_last(machine: Interpreter, option: LastScan, body: str, *, pulse: bool) -> None:
    """Run the last scan of an action's body, according to the chart's option."""
    if option is LastScan.AUTOMATIC:
        machine.postscan(body)
    elif option is LastScan.PROGRAMMATIC and not pulse:
        machine.call(body, ())


def _write_action(rungs: RungWriter, chart: LoweredChart, chart_action: ChartAction, _tag: Group) -> str:
    """Write code for the common cases: an N action while its step is active, and a pulse that is off."""
    values, bits = rungs.values, chart_action.bits
    call = f"interpret({values.site})"
    on = f"{values.read(bits['A'])} and {values.read(bits['owner'])} == {chart_action.index}"
    if chart_action.qualifier is Qualifier.P1 or chart_action.qualifier is Qualifier.P:
        return f"(({values.read(chart_action.node.bits['new'])} or ({on})) and {call})"
    if chart_action.qualifier is Qualifier.P0:
        return f"({on} and {call})"
    if chart_action.qualifier is not Qualifier.N:
        return call
    result = values.keep(str(chart_action.body is not None))
    with rungs.writer.block(f"if {on} and not {values.read(chart_action.node.bits['new'])}:"):
        values.assign(bits["ns"], _write_time(rungs, chart, bits, "False"))
        values.assign(bits["T"], f"wrap({values.read(bits['ns'])} // {_MS}, {DINT.bits})")
        values.set_bit(bits["Q"], "True")
    with rungs.writer.block("else:"):
        rungs.writer.line(call)
    return result


# --- the rows of a scan, which no rung names

BEGIN = condition(
    "SFC",
    Use.IGNORED,
    run=_begin,
    write=_write_begin,
    partly=True,
    prescan=_prescan,
    postscan=_postscan,
)
CLOCK = action("SFC", Use.IGNORED, run=_clock, write=_write_clock, postscan=do_nothing)
STEP = action("STEP", Use.IGNORED, Use.IGNORED, Use.BLOCK, run=_step, write=_write_step, postscan=do_nothing)
DONE = action("STEP", Use.IGNORED, run=_end_first_scan, write=_write_end_of_first_scan, postscan=do_nothing)
ACT = condition(
    "ACTION",
    Use.IGNORED,
    Use.IGNORED,
    Use.BLOCK,
    run=_update_action,
    write=_write_action,
    partly=True,
    postscan=do_nothing,
)
FIRE = action("TRANSITION", Use.IGNORED, Use.IGNORED, Use.TRUTH, run=_fire_transition, postscan=do_nothing)


def fire_of(transition: ChartTransition) -> Spec:
    """Return the row of a transition; its operands are the condition, then the tags of its steps."""
    steps = len(transition.sources) + len(transition.targets)
    return replace(FIRE, operands=(*FIRE.operands, *[Use.BLOCK] * steps))


CALL = replace(JSR, postscan=do_nothing)
"""The call of an action's body; the body's postscan is part of the last scan of the action."""
