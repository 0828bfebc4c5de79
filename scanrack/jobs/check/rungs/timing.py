"""Timers that can't work as intended.

XIC(Start)ONS(Seen)TON(Wait,500,0)     the one-shot enables the timer for only one scan
TON(Wait,-500,0)                       a negative preset is a major fault
TONR(Wait) in a step, TimerEnable 1    nothing disables it, so the second time it is done immediately
TONR(Wait)                             nothing sets Wait.TimerEnable
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from scanrack.ladder.model.operands import Constant, Group, Place
from scanrack.ladder.model.tags import Tag

from ..facts import Facts
from ..logic import TRUE, needed
from ..ranges import Range
from .conditions import EDGE
from .operands import around, first_of, is_zero, own_group_of, path_of
from .view import LadderView
from .walk import Point

RUNG_TIMERS = ("TON", "TOF", "RTO")
ENABLES = {"TONR": ("TIMERENABLE",), "RTOR": ("TIMERENABLE",), "CTUD": ("CUENABLE", "CDENABLE")}
"""By structured text instruction, the bits that can make it run."""


def note_timing(view: LadderView, facts: Facts) -> None:
    """Note timers and counters that can't work as intended, because of their presets or enable bits."""
    targets = {  # paths that anything except the blocks themselves writes
        path_of(mention.where)
        for mention in view.mentions
        if mention.writes and (mention.step is None or mention.step.name not in ENABLES)
    }
    for point in view.points:
        timer = own_group_of(point.step, RUNG_TIMERS)
        if timer is not None:
            _note_rung_timer(point, view.values.range_of(timer.member("PRE")), facts)
        block = own_group_of(point.step, ENABLES)
        if block is not None and not _is_enabled(point, block, targets, view.tags):
            names = " or ".join(ENABLES[point.step.name]).replace("TIMERENABLE", "TimerEnable")
            facts.remark("never-run", point.place, f"{point.text}: nothing sets its {names}")
    _never_disabled(view.points, targets, facts)


def _note_rung_timer(point: Point, preset: Range, facts: Facts) -> None:
    """Note a negative preset, or a TON that a one-shot enables."""
    one_shots = (bit for bit in needed(point.condition) if bit.on and bit.name.startswith(EDGE))
    if preset.is_known and preset.most < 0:
        text = f"{point.text}: the preset is {preset}; a negative preset is a major fault"
        facts.remark("negative-preset", point.place, text)
    elif point.step.name == "TON" and any(one_shots):
        text = f"{point.text}: a one-shot enables it for only one scan: it is never done"
        facts.remark("never-run", point.place, text)


def _is_enabled(point: Point, block: Group, targets: set[str], tags: Mapping[str, Tag]) -> bool:
    """Whether the program or an initial value may enable an instance; True if unknown."""
    path, names = path_of(block), ENABLES[point.step.name]
    if not targets.isdisjoint((path, *around(path), *(f"{path}.{name}" for name in names))):
        return True
    if path not in tags:
        return True
    initial = tags[path].initial
    if not isinstance(initial, dict):
        return initial is not None
    return any(bool(value) for name, value in initial.items() if str(name).upper() in names)


def _assigns_one(point: Point) -> bool:
    """Whether an instruction assigns a constant other than 0 to a bit."""
    value = point.step.operands[-1]
    return point.step.name == ":=" and isinstance(value, Constant) and not is_zero(value)


def _never_disabled(points: Sequence[Point], targets: set[str], facts: Facts) -> None:
    """Note a TONR that is called only in some steps and whose TimerEnable is only ever set to 1."""
    calls: dict[str, list[tuple[Point, Group]]] = {}
    assigns_one: dict[str, list[bool]] = {}  # by bit, for each instruction that writes it
    for point in points:
        timer = own_group_of(point.step, ("TONR",))
        bit = first_of(point.step, (":=", "OTE", "OTL", "OTU"))
        if timer is not None:
            calls.setdefault(path_of(timer), []).append((point, timer))
        elif isinstance(bit, Place):
            assigns_one.setdefault(path_of(bit), []).append(_assigns_one(point))
    for path, timer_calls in calls.items():
        enables = assigns_one.get(f"{path}.TIMERENABLE", [])
        is_reset = not targets.isdisjoint((*around(path), f"{path}.ACC", f"{path}.RESET"))
        in_some_steps = all(point.condition != TRUE for point, _ in timer_calls)
        if enables and all(enables) and not is_reset and in_some_steps:
            point, timer = timer_calls[0]
            text = f"{timer.text} is never disabled or reset: once its DN is on, it stays on"
            facts.remark("latch-never-cleared", point.place, text)
