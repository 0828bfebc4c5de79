"""`scanrack conform --judge` of a recording that begins in the middle of operation.

Broken on purpose: position, configuration or inputs of the known state left out, a scene that goes on
when the state is lost: each turns it red.
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from scanrack import run
from scanrack.jobs.conform.hypotheses import search
from scanrack.jobs.conform.moments import KnownState, PlayedScene, Timing
from scanrack.jobs.conform.paths.captured import scenes_in
from scanrack.jobs.replay.resumed import configuration_in, words_of
from scanrack.runtime.modules.amci3601.module import Amci3601
from scanrack.traces.read.packed import PackedScans
from scanrack.traces.read.reader import open_trace
from scanrack.traces.replay import PackedTrace

FEEDER = Path(__file__).parents[3] / "examples/feeder/feeder.toml"
TIMING = Timing(scan_ns=0)
CUTS = 20


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> PackedTrace:
    path = tmp_path_factory.mktemp("feeder") / "feeder.mcap"
    run(FEEDER, "12 s", trace=path)
    with open_trace(path) as trace:
        return PackedTrace.of(trace)


def cut(recording: PackedTrace, first: int) -> PackedTrace:
    columns = recording.columns
    rest = PackedScans.of(recording.layout.words, [columns.rows(first, len(columns.scan))])
    number = int(columns.scan[first])
    return PackedTrace(recording.slots, rest, tuple(each for each in recording.events if each.scan >= number))


def configuration(recording: PackedTrace) -> tuple[int, ...]:
    shown = (configuration_in(words_of(each)) for each in recording.images((1, "in")))
    return next(each for each in shown if each is not None)


def explained(scene: PlayedScene) -> bool:
    return search(scene.moments, Amci3601, TIMING).explains_all


@pytest.mark.slow
def test_cuts_are_judged_from_the_first_rest_on_and_nothing_differs(recording: PackedTrace) -> None:
    words = configuration(recording)
    judged = total = 0
    for first in random.Random(46).sample(range(10, len(recording.scans) * 3 // 4), CUTS):
        late = cut(recording, first)
        found = scenes_in(late, {}, 1, TIMING, words)
        assert (
            "the trace begins in the middle of operation; the module starts with the state of scan"
            in found.notes[0]
        )
        assert all(isinstance(each.moments[0], KnownState) for each in found.scenes)
        for scene in found.scenes[:2]:
            assert explained(scene), (first, scene.name)
        judged, total = judged + sum(each.reads for each in found.scenes), total + len(late.scans)
    assert judged > total / 2
