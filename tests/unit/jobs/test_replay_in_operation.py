"""A recording that begins in the middle of operation: the module is compared from where its state is known.

Broken on purpose: position or latched bits not taken, an input's change during a motion not noticed: each
turns it red.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from pathlib import Path

import pytest
from amounts import amount
from scanrack import load_rack, run
from scanrack.io_images.image import Image
from scanrack.jobs.replay.replaying import Replay, forced_rows, plan_of, with_stimuli
from scanrack.jobs.replay.resumed import (
    INPUT_CHANGED,
    NO_CONFIGURATION,
    NOT_AT_REST,
    ResumedModule,
    configuration_in,
    words_of,
)
from scanrack.jobs.replay.resumed_operation import ResumedOperation
from scanrack.jobs.replay.targets import ReplayTarget, Stimuli
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.traces.compare import EXACT, Comparison
from scanrack.traces.read.packed import PackedScans
from scanrack.traces.read.reader import open_trace
from scanrack.traces.replay import PackedTrace

EXAMPLES = Path(__file__).parents[3] / "examples"
RACKS = {
    "feeder": EXAMPLES / "feeder/feeder.toml",
    "stations": EXAMPLES / "three_stations_ladder/line.toml",
    "labeller": EXAMPLES / "sequences/labeller.toml",
}
CUTS = amount(20)


@dataclass
class Cut:
    """A replay of a recording that begins late."""

    found: Comparison
    notes: list[str]
    modules: list[ResumedModule]
    scans: int

    @property
    def unknown(self) -> int:
        return max(sum(each.unknown.values()) for each in self.modules)


def cut(recording: PackedTrace, first: int) -> PackedTrace:
    columns = recording.columns
    number = int(columns.scan[first])
    rest = PackedScans.of(recording.layout.words, [columns.rows(first, len(columns.scan))])
    return PackedTrace(recording.slots, rest, tuple(each for each in recording.events if each.scan >= number))


def words_before(recording: PackedTrace, first: int, slot: int) -> tuple[int, ...] | None:
    """Return the configuration that a slot has before a row."""
    shown = [configuration_in(words_of(each)) for each in recording.images((slot, "in"))[:first]]
    return next((each for each in reversed(shown) if each is not None), None)


def replayed(recording: PackedTrace, spec: RackSpec, words: tuple[int, ...] | None) -> Cut:
    resumed = ResumedOperation(
        recording,
        {each.number: each.firmware for each in spec.slot if each.module == "amci3601"},
        forced_rows(plan_of(recording)),
        words and list(Image(words)),
    )
    machine = with_stimuli(spec, recording, Stimuli.INPUTS, resumed.active_high)
    slots = [each.number for each in recording.slots if each.is_stepper]
    replay = Replay(recording, machine, None, ReplayTarget.MODULE, slots, resumed)
    follower = replay.run(EXACT, to_the_end=True)
    return Cut(follower.comparison(), replay.notes, [*resumed.modules.values()], len(recording.scans))


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[PackedTrace, RackSpec]]:
    folder = tmp_path_factory.mktemp("recordings")
    found = {}
    for name, rack in RACKS.items():
        path = folder / f"{name}.mcap"
        run(rack, "12 s", trace=path)
        with open_trace(path) as trace:
            found[name] = PackedTrace.of(trace), load_rack(rack).spec
    return found


LEAST_KNOWN = {"feeder": 0.6, "stations": 0.6, "labeller": 0.1}
"""Part of the scans behind the cuts that is compared at least; no image shows the labeller's minimum
registration distance, which most of its moves use."""


@pytest.mark.sampled
@pytest.mark.parametrize("name", RACKS)
def test_from_the_known_state_on_no_scan_differs(
    name: str, recordings: dict[str, tuple[PackedTrace, RackSpec]]
) -> None:
    recording, spec = recordings[name]
    scans = known = 0
    for first in random.Random(46).sample(range(10, len(recording.scans) * 3 // 4), CUTS):
        done = replayed(
            cut(recording, first), spec, words_before(recording, first, recording.slots[0].number)
        )
        assert done.found.differing == 0, (first, done.found.first, done.notes)
        scans, known = scans + done.scans, known + done.scans - done.unknown
    assert known > LEAST_KNOWN[name] * scans


def test_a_module_that_differs_is_told(recordings: dict[str, tuple[PackedTrace, RackSpec]]) -> None:
    """A starting speed of 400 in place of 500 makes ramps from 0 to 6,000 steps longer."""
    recording, spec = recordings["feeder"]
    words = words_before(recording, 1500, 1)
    assert words is not None
    assert words[3] == 500
    late = cut(recording, 1500)
    assert replayed(late, spec, words).found.same
    other = replayed(late, spec, (*words[:3], 400, *words[4:]))
    assert other.found.differing > 100
    assert other.modules[0].starts[0].position == 6000


def test_what_was_assumed_is_said(recordings: dict[str, tuple[PackedTrace, RackSpec]]) -> None:
    """The feeder rests at 6,000 steps after its first stroke, from scan 1,696 on."""
    recording, spec = recordings["feeder"]
    late = cut(recording, 1500)
    done = replayed(late, spec, words_before(recording, 1500, 1))
    first = done.modules[0].starts[0].row + 1500
    said = f"the module starts with the state of scan {first:,}, position 6,000, configuration as given"
    assert said in done.notes[0]
    assert set(done.modules[0].unknown) == {NOT_AT_REST, INPUT_CHANGED}
    resting = [recording.images((1, "in"))[row] for row in (first - 1, first)]
    assert resting[0] == resting[1]


def test_without_a_configuration_nothing_is_compared(
    recordings: dict[str, tuple[PackedTrace, RackSpec]],
) -> None:
    recording, spec = recordings["feeder"]
    with pytest.raises(ValueError, match=f"{NO_CONFIGURATION}; give the missing words with --configuration"):
        replayed(cut(recording, 1500), spec, None)


def test_a_recording_that_begins_with_the_configuration_needs_none(
    recordings: dict[str, tuple[PackedTrace, RackSpec]],
) -> None:
    """Between power-up and the first command the module is in configuration mode, or just out of it."""
    recording, spec = recordings["feeder"]
    rows = range(1, 30)
    shown = [configuration_in(words_of(recording.images((1, "in"))[row])) is not None for row in rows]
    first = rows[shown.index(True)]
    done = replayed(cut(recording, first), spec, None)
    assert done.found.differing == 0
    assert done.modules[0].starts
