"""Compares two racks, programs or exports to find the effects of an edit, now or later."""

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
from ..load.claims import NO_LADDER
from ..load.loading import LoadedRack
from .on_rack import OnRack, difference_on_rack
from .proving import ScenarioFolder, write_scenario
from .report import held_text, scans_of
from .subject import bounds_of

FAULT_NAME = "a major fault"
"""Name that stands for a major fault in only one of the programs."""


@dataclass(frozen=True, slots=True)
class ChangedTag:
    """A value that can differ, with a run that shows the difference.

    A major fault in only one of the programs also counts as a value, with the name `FAULT_NAME`.
    """

    name: str  # as in the program
    now: bool  # whether one scan from equal states can make the difference
    steps: tuple[ScenarioStep, ...]  # the run; empty if no run was found
    inputs: tuple[str, ...]  # inputs on which the difference depends
    scenario: Path | None
    allowed: bool  # whether --may-differ names it
    rack: OnRack | None = None  # the effect of the run on the rack

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

    compared: int  # number of values that both programs have and at least one writes
    changed: tuple[ChangedTag, ...]
    removed: tuple[str, ...]  # tags that only the old program has
    added: tuple[str, ...]  # tags that only the new program has
    bounds: ScanBounds
    held: Mapping[str, Any]  # numbers that nothing writes, with their assumed values
    open: tuple[str, ...] = ()  # limits of the comparison, one sentence each

    @property
    def is_equal(self) -> bool:
        """Whether only allowed values can differ, and everything was compared."""
        return all(tag.allowed for tag in self.changed) and not self.open


def edited(
    old: str, new: str, outputs: Sequence[str], only: Sequence[str], folder: ScenarioFolder
) -> EditedSubject:
    """Compare two programs with the same inputs and the new program's settings of [prove].

    Args:
        outputs: tags to compare; empty for all. The name of a structure includes all its members.
        only: tags that may differ.
        folder: receives a scenario for each value that can differ.

    Raises:
        ValueError: a file or a tag name is invalid, or no proof covers a program.
        OSError: a file can't be written.
    """
    _, old_logic = _ladder(old)
    job, new_logic = _ladder(new)
    bounds = bounds_of(job)
    layout = new_logic.build().layout
    allowed_places = [_named(layout, text, "--may-differ") for text in only]
    output_places = [_named(layout, text, "--outputs") for text in outputs]
    difference = compare(
        old_logic,
        new_logic,
        bounds,
        free=job.spec.prove.free,
        written_outside=job.spec.prove.written_outside,
        is_output=lambda key: not output_places or any(_is_in(key, place) for place in output_places),
    )
    held_values = {number.named(tag_text(layout, number.key)): number.value for number in difference.held}
    changed_values = list(difference.changed)
    if difference.fault is not None:
        changed_values.append(difference.fault)
    changed_tags = []
    for value in changed_values:
        may_differ = any(_is_in(value.key, place) for place in allowed_places)
        changed_tags.append(_with_scenario(job, old_logic, layout, value, folder, allowed=may_differ))
    return EditedSubject(
        compared=difference.compared,
        changed=tuple(changed_tags),
        removed=tuple(difference.removed),
        added=tuple(difference.added),
        bounds=bounds,
        held=held_values,
        open=tuple(_limits_of(difference)),
    )


def _limits_of(difference: Difference) -> Iterator[str]:
    """Yield the limits of a comparison, one sentence each."""
    for array in difference.uncompared:
        yield f"elements of {array} from {MOST_OPEN:,} on are not compared"
    for step in difference.unfollowed:
        yield f"nothing is known after {step}"


def _ladder(file: str) -> tuple[LoadedRack, LadderLogic]:
    """Load a file; raise a ValueError unless its program is ladder logic."""
    job, _ = load_any(file)
    if not isinstance(job.logic, LadderLogic):
        raise ValueError(NO_LADDER.format(job.program))
    return job, job.logic


def _named(layout: Layout, text: str, option: str) -> Place | Group:
    """Return the tag or element that an option names."""
    try:
        place = Resolver(layout).named(text)
    except LadderError as error:
        raise ValueError(f"{option} {text}: {error}") from None
    if isinstance(place, Place) and place.bit is not None:
        raise ValueError(f"{option} {text}: only whole numbers are compared, not their bits: name the number")
    return place


def _is_in(key: Key, allowed: Place | Group) -> bool:
    """Return whether a value is the tag or element that an option names, or a part of it."""
    if isinstance(allowed, Place):
        return key == (allowed.leaf.path.upper(), allowed.fixed_index)
    path = allowed.path.upper()
    return key[0] == path or key[0].startswith(f"{path}.")


def _with_scenario(
    job: LoadedRack,
    old: LadderLogic,
    layout: Layout,
    value: ChangedValue,
    folder: ScenarioFolder,
    *,
    allowed: bool,
) -> ChangedTag:
    """Run the scenario of a changed value on the rack, and write it; return the value's row of the report."""
    is_fault = value.key == FAULT
    name = FAULT_NAME if is_fault else tag_text(layout, value.key)
    file, rack = None, None
    if value.scans:
        rack = None if is_fault else difference_on_rack(job, old, layout, value.scans, value.key)
        file = write_scenario(job, layout, name, value.scans, rack, folder)
    inputs = tuple(_program_spelling(layout, address) for address in value.inputs)
    steps = tuple(steps_of(layout, value.scans))
    return ChangedTag(name, value.now, steps, inputs, scenario=file, allowed=allowed, rack=rack)


def _program_spelling(layout: Layout, text: str) -> str:
    """Return an address with its tag in the program's spelling."""
    path, sign, index = text.partition("[")
    leaf = layout.find(path)
    return text if leaf is None else f"{leaf.path}{sign}{index}"


def lines_of(edit: EditedSubject) -> Iterator[str]:
    """Yield the lines of a comparison: the values that can differ with their runs, and the assumptions."""
    yield _summary(edit)
    with_run = [tag for tag in edit.changed if tag.steps]
    width = max((len(tag.name) for tag in with_run), default=0)
    for tag in with_run:
        yield from _lines_of_tag(tag, width)
    without_run = [tag for tag in edit.changed if not tag.steps]
    for when in ("now", "later"):
        names = [f"{tag.name}{tag.allowed_text}" for tag in without_run if tag.when == when]
        yield from _list_line(f"{when}, no run found within the limits:", names)
    yield from edit.open
    yield from _list_line("only the old program has", edit.removed)
    yield from _list_line("only the new program has", edit.added)
    bounds = edit.bounds
    yield f"assumed: scans are {bounds.low_ms:,} to {bounds.high_ms:,} ms apart{bounds.steps_text}"
    yield from (f"    {assumption}" for assumption in LEFT_OUT.values())
    if edit.held:
        yield f"    {held_text(edit.held)}"


def _summary(edit: EditedSubject) -> str:
    """Return a sentence with the number of values that can differ."""
    values = [tag for tag in edit.changed if tag.name != FAULT_NAME]
    now = sum(value.now for value in values)
    others = "the others are not proved equal" if edit.open else "all others are equal in every run"
    return f"{len(values):,} of {edit.compared:,} bits and numbers can differ, {now:,} in one scan; {others}"


def _lines_of_tag(tag: ChangedTag, width: int) -> Iterator[str]:
    """Yield the lines of a value that can differ: the run, the run on the rack, and the inputs."""
    scans = f"scan {len(tag.steps):,}"
    yield f"{tag.name:<{width}}  {tag.when:<5}  {scans}   {tag.scenario}  {tag.allowed_text}".rstrip()
    for number, step in enumerate(tag.steps, start=1):
        yield f"    scan {number}: {step}"
    if tag.rack is not None:
        yield f"    {tag.rack}"
    yield from _list_line("    depends on", tag.inputs)


def _list_line(begin: str, names: Sequence[str]) -> Iterator[str]:
    """Yield a line with a list of names; nothing if there are none."""
    if names:
        yield f"{begin} {', '.join(names)}"


def as_json(edit: EditedSubject) -> dict[str, Any]:
    """Return the differences as JSON values: the changed tags with their runs, and the assumptions."""
    return {
        "compared": edit.compared,
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
            for tag in edit.changed
        ],
        "removed": list(edit.removed),
        "added": list(edit.added),
        "open": list(edit.open),
        "held": dict(edit.held),
        "scan_ms": [edit.bounds.low_ms, edit.bounds.high_ms],
        "assumed": list(LEFT_OUT.values()),
    }
