"""Compares two racks, programs or exports: what an edit changes, now or later."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scanrack.ladder import LadderLogic
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.operands import Group, Place
from scanrack.ladder.model.resolver import Resolver
from scanrack.ladder.model.tags import Layout
from scanrack.ladder.prove.answers import ScenarioStep, steps_of, tag_text
from scanrack.ladder.prove.difference import ChangedValue, Difference, compare
from scanrack.ladder.prove.differing_runs import FAULT
from scanrack.ladder.prove.relation.stored import MOST_OPEN
from scanrack.ladder.prove.system import Key, ScanBounds
from scanrack.ladder.prove.system.events import LEFT_OUT

from ..check.alone import load_any
from ..load.loading import LoadedRack
from .on_rack import OnRack, difference_on_rack
from .proving import ScenarioFolder, write_scenario
from .report import held_text, scans_of
from .subject import bounds_of

FAULT_NAME = "a major fault"
"""Name that stands for a major fault in only one of the programs."""


@dataclass(frozen=True, slots=True)
class ChangedTag:
    """A value that can differ, under its name in the program, with a run that shows the difference.

    A major fault in only one of the programs also counts as such a value: `FAULT_NAME`.
    """

    name: str
    now: bool  # whether one scan from equal states can make the difference
    steps: tuple[ScenarioStep, ...]
    inputs: tuple[str, ...]  # on which the difference depends
    scenario: Path | None
    allowed: bool  # by the option --may-differ
    rack: OnRack | None = None

    @property
    def when(self) -> str:
        """When it can differ: "now", after one scan from equal states, or "later"."""
        return "now" if self.now else "later"

    @property
    def allowed_text(self) -> str:
        """The option that allows the difference; "" if none does."""
        return " (--may-differ)" if self.allowed else ""


@dataclass(frozen=True, slots=True)
class EditedSubject:
    """The possible differences between two programs."""

    compared: int  # values that both programs have and at least one writes
    changed: tuple[ChangedTag, ...]
    removed: tuple[str, ...]
    added: tuple[str, ...]
    bounds: ScanBounds
    held: Mapping[str, Any]  # numbers that nothing writes, with their assumed values
    open: tuple[str, ...] = ()  # what is not compared, and where the relation is not exact

    @property
    def is_equal(self) -> bool:
        """Whether only allowed values can differ, and everything was compared."""
        return all(tag.allowed for tag in self.changed) and not self.open


def edited(
    old: str, new: str, outputs: Sequence[str], only: Sequence[str], folder: ScenarioFolder
) -> EditedSubject:
    """Compare two programs with the same inputs. The settings of [prove] are those of the new program.

    Args:
        outputs: tags to compare; empty for all. A structure stands for all its members.
        only: tags that may differ.
        folder: receives a scenario for each value that can differ.

    Raises:
        ValueError: a file or a tag name is invalid, or no proof covers a program.
        OSError: a file can't be written.
    """
    before, after = (_ladder(path) for path in (old, new))
    job, logic = after
    prove_spec = job.spec.prove
    bounds = bounds_of(job)
    layout = logic.build().layout
    allowed_places = [_named(layout, text, "--may-differ") for text in only]
    places = [_named(layout, output, "--outputs") for output in outputs]
    difference = compare(
        before[1],
        logic,
        bounds,
        free=prove_spec.free,
        written_outside=prove_spec.written_outside,
        is_output=lambda key: not places or any(_is_in(key, place) for place in places),
    )
    held_values = {number.named(tag_text(layout, number.key)): number.value for number in difference.held}
    changed = []
    for changed_tag in (*difference.changed, *([] if difference.fault is None else [difference.fault])):
        may_differ = any(_is_in(changed_tag.key, place) for place in allowed_places)
        changed.append(_with_scenario(job, before[1], layout, changed_tag, folder, allowed=may_differ))
    names = tuple(difference.removed), tuple(difference.added)
    return EditedSubject(
        difference.compared, tuple(changed), *names, bounds, held_values, tuple(_left_open(difference))
    )


def _left_open(found: Difference) -> Iterator[str]:
    """Yield what the comparison does not cover, one sentence each."""
    yield from (f"elements of {array} from {MOST_OPEN:,} on are not compared" for array in found.uncompared)
    yield from (f"nothing is known after {step}" for step in found.unfollowed)


def _ladder(file: str) -> tuple[LoadedRack, LadderLogic]:
    job, _ = load_any(file)
    if not isinstance(job.logic, LadderLogic):
        raise ValueError(
            f"{job.program}: the program is in Python: only ladder logic and structured text can be proved"
        )
    return job, job.logic


def _named(layout: Layout, text: str, option: str) -> Place | Group:
    """Return the tag or element that an option names."""
    try:
        place = Resolver(layout).named(text)
    except LadderError as error:
        raise ValueError(f"{option} {text}: {error}") from None
    if isinstance(place, Place) and place.bit is not None:
        raise ValueError(f"{option} {text}: it is a bit of a number, which is compared as a whole: name that")
    return place


def _is_in(key: Key, allowed: Place | Group) -> bool:
    """Whether a value is the tag or element that an option names, or a part of it."""
    if isinstance(allowed, Place):
        return key == (allowed.leaf.path.upper(), allowed.fixed_index)
    path = allowed.path.upper()
    return key[0] == path or key[0].startswith(f"{path}.")


def _with_scenario(
    job: LoadedRack,
    old: LadderLogic,
    layout: Layout,
    found: ChangedValue,
    folder: ScenarioFolder,
    *,
    allowed: bool,
) -> ChangedTag:
    is_fault = found.key == FAULT
    name, file, rack = FAULT_NAME if is_fault else tag_text(layout, found.key), None, None
    if found.scans:
        rack = None if is_fault else difference_on_rack(job, old, layout, found.scans, found.key)
        file = write_scenario(job, layout, name, found.scans, rack, folder)
    inputs = tuple(_cased(layout, input_) for input_ in found.inputs)
    return ChangedTag(name, found.now, tuple(steps_of(layout, found.scans)), inputs, file, allowed, rack)


def _cased(layout: Layout, text: str) -> str:
    """Return an address with its tag in the program's spelling."""
    path, sign, index = text.partition("[")
    leaf = layout.find(path)
    return text if leaf is None else f"{leaf.path}{sign}{index}"


def lines_of(found: EditedSubject) -> Iterator[str]:
    """Yield a line for each value that can differ, with its run."""
    yield _summary(found)
    shown = [changed for changed in found.changed if changed.steps]
    width = max((len(changed.name) for changed in shown), default=0)
    for tag in shown:
        yield from _lines_of_tag(tag, width)
    without_run = [changed for changed in found.changed if not changed.steps]
    for when in ("now", "later"):
        names = [f"{changed.name}{changed.allowed_text}" for changed in without_run if changed.when == when]
        yield from _list_line(f"{when}, no run found within the limits:", names)
    yield from found.open
    yield from _list_line("only the old program has", found.removed)
    yield from _list_line("only the new program has", found.added)
    bounds = found.bounds
    yield f"assumed: scans are {bounds.low_ms:,} to {bounds.high_ms:,} ms apart{bounds.steps_text}"
    for assumption in (*LEFT_OUT.values(), *([held_text(found.held)] if found.held else [])):
        yield f"    {assumption}"


def _summary(found: EditedSubject) -> str:
    """Return a sentence with the number of values that can differ."""
    values = [tag for tag in found.changed if tag.name != FAULT_NAME]
    now = sum(value.now for value in values)
    others = "the others are not proved equal" if found.open else "all others are equal in every run"
    return f"{len(values):,} of {found.compared:,} bits and numbers can differ, {now:,} in one scan; {others}"


def _lines_of_tag(changed: ChangedTag, width: int) -> Iterator[str]:
    """Yield the lines of a value that can differ: its run, what the rack did, and the inputs that matter."""
    scans = f"scan {len(changed.steps):,}"
    line = f"{changed.name:<{width}}  {changed.when:<5}  {scans}   {changed.scenario}  {changed.allowed_text}"
    yield line.rstrip()
    for number, step in enumerate(changed.steps, start=1):
        yield f"    scan {number}: {step}"
    if changed.rack is not None:
        yield f"    {changed.rack}"
    yield from _list_line("    depends on", changed.inputs)


def _list_line(begin: str, names: Sequence[str]) -> Iterator[str]:
    """Yield a line with a list of names; nothing if there are none."""
    if names:
        yield f"{begin} {', '.join(names)}"


def as_json(found: EditedSubject) -> dict[str, Any]:
    """Return the differences as JSON values."""
    return {
        "compared": found.compared,
        "changed": [
            {
                "tag": tag.name,
                "when": tag.when,
                "allowed": tag.allowed,
                "scans": scans_of(tag.steps),
                "depends_on": list(tag.inputs),
                "scenario": None if tag.scenario is None else str(tag.scenario),
                "rack": None if tag.rack is None else tag.rack.to_json(),
            }
            for tag in found.changed
        ],
        "removed": list(found.removed),
        "added": list(found.added),
        "open": list(found.open),
        "held": dict(found.held),
        "scan_ms": [found.bounds.low_ms, found.bounds.high_ms],
        "assumed": list(LEFT_OUT.values()),
    }
