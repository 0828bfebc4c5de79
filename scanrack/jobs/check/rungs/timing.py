"""Timers that can't do what they are for.

XIC(Start)ONS(Seen)TON(Wait,500,0)     the one-shot enables it for one scan only
TON(Wait,-500,0)                       a negative preset is a major fault
TONR(Wait) in a step, TimerEnable 1    nothing disables it: it is done at once the second time
TONR(Wait)                             and nothing sets Wait.TimerEnable
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from scanrack.ladder.debug.crossref import Mention
from scanrack.ladder.model.operands import Constant, Group, Place
from scanrack.ladder.model.tags import Tag
from scanrack.ladder.state.lowered import LoweredStep

from ..facts import Facts, FileLine
from ..logic import TRUE, needed
from .conditions import EDGE
from .number_ranges import Values
from .output_writes import path_of
from .walk import Point

Placed = Sequence[tuple[Point, FileLine]]

RUNG_TIMERS = ("TON", "TOF", "RTO")
ENABLES = {"TONR": ("TIMERENABLE",), "RTOR": ("TIMERENABLE",), "CTUD": ("CUENABLE", "CDENABLE")}
"""By instruction of structured text: the bits of which one makes it run."""


def note_timing(
    points: Placed,
    mentions: Sequence[Mention],
    values: Values,
    tags: Mapping[str, Tag],
    facts: Facts,
    written: Callable[[LoweredStep], str],
) -> None:
    """Note timers that can't do what they are for.

    Args:
        mentions: all operands of the program.
        written: returns an instruction as it is written.
    """
    targets = {
        path_of(each.where)
        for each in mentions
        if each.writes and (each.step is None or each.step.name not in ENABLES)
    }
    for point, place in points:
        group = point.step.operands[0] if point.step.operands else None
        if not isinstance(group, Group) or group.frame:
            continue
        if point.step.name in RUNG_TIMERS:
            preset = values.of(group.member("PRE"))
            if preset.is_known and preset.most < 0:
                text = f"{written(point.step)}: the preset is {preset}, and a negative one is a major fault"
                facts.remark("negative-preset", place, text)
            elif point.step.name == "TON" and any(
                each.on and each.name.startswith(EDGE) for each in needed(point.condition)
            ):
                text = f"{written(point.step)}: a one-shot enables it, for one scan only: it is never done"
                facts.remark("never-run", place, text)
        elif point.step.name in ENABLES:
            path = group.path.upper()
            enables = [f"{path}.{name}" for name in ENABLES[point.step.name]]
            if not any(each in targets for each in (*_around(path), *enables)) and not _is_enabled(
                tags, path, ENABLES[point.step.name]
            ):
                text = f"{written(point.step)}: nothing sets its {' or '.join(ENABLES[point.step.name])}"
                facts.remark("never-run", place, text.replace("TIMERENABLE", "TimerEnable"))
    _never_disabled(points, targets, facts)


def _around(path: str) -> Iterator[str]:
    """Yield a path and those that contain it."""
    names = path.split(".")
    yield from (".".join(names[:at]) for at in range(len(names), 0, -1))


def _is_enabled(tags: Mapping[str, Tag], path: str, names: Sequence[str]) -> bool:
    """Whether an initial value makes an instance run, or is not simple."""
    tag = tags.get(path)
    if tag is None:
        return True
    initial = tag.initial
    if initial is None:
        return False
    return not isinstance(initial, dict) or any(
        bool(value) for name, value in initial.items() if str(name).upper() in names
    )


def _never_disabled(points: Placed, targets: set[str], facts: Facts) -> None:
    """Note a TONR that only some steps call, and whose TimerEnable only becomes 1."""
    calls: dict[str, list[tuple[Point, FileLine, str]]] = {}
    enabled: dict[str, list[bool]] = {}
    for point, place in points:
        first = point.step.operands[0] if point.step.operands else None
        if point.step.name == "TONR" and isinstance(first, Group) and not first.frame:
            calls.setdefault(first.path.upper(), []).append((point, place, first.text))
        elif point.step.name in (":=", "OTE", "OTL", "OTU") and isinstance(first, Place):
            value = point.step.operands[-1]
            is_one = point.step.name == ":=" and isinstance(value, Constant) and bool(value.value)
            enabled.setdefault(first.leaf.path.upper(), []).append(is_one)
    for path, found in calls.items():
        ones = enabled.get(f"{path}.TIMERENABLE", [])
        others = [f"{path}.ACC", f"{path}.RESET"]
        is_reset = any(each in targets for each in (*list(_around(path))[1:], *others))
        if ones and all(ones) and not is_reset and all(point.condition != TRUE for point, _, _ in found):
            _, place, text = found[0]
            facts.remark(
                "latch-never-cleared",
                place,
                f"{text} is never disabled or reset: once its DN is on, it stays on",
            )
