"""A program that follows recorded inputs without a rack ends as the one that runs on the images of a rack."""

from __future__ import annotations

from pathlib import Path

import pytest
from scanrack.jobs import load_job
from scanrack.jobs.replay.input_replay import InputReplay
from scanrack.jobs.why.followed import can_follow, follow
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import Debugger
from why_questions import do, make

pytestmark = pytest.mark.slow  # together they take seconds

# a link that is lost and comes back, a key that is turned: what a program sees besides its images
DONE = {
    "rungs": "300ms press start 1s key program 200ms key run 300ms press part 200ms",
    "feeder": "1s fail 1=link-lost 200ms fail 1 1s",
    "text": "300ms press start 300ms hold guard 200ms",
}


def debugger_of(folder: Path) -> Debugger:
    """Return the program of a rack under a new debugger."""
    logic = load_job(str(folder / "rack.toml")).logic
    assert isinstance(logic, LadderLogic)
    return Debugger(logic)


@pytest.mark.parametrize("world", DONE)
def test_both_ways_end_with_the_same_tags_and_the_same_chain(tmp_path, world):
    bench = make(tmp_path, world)
    do(bench, DONE[world])
    recording, job = bench._journal.recording(), load_job(str(tmp_path / "rack.toml"))
    last = len(recording.scans) - 1
    followed, played = debugger_of(tmp_path), debugger_of(tmp_path)
    assert can_follow(recording, followed)
    done = follow(recording, followed, last)
    replay = InputReplay(job.spec, recording.slots)
    replay.attach(played)
    assert list(replay.play(recording, last)) == list(range(last + 1))
    assert replay.departs is None
    assert (done.row, done.departs, followed.scans) == (last, None, last + 1)
    names = [each for each in followed.tags if not each.startswith("Local:")]
    assert {name: followed.tags[name] for name in names} == {name: bench[name] for name in names}
    assert {name: followed.tags[name] for name in names} == {name: played.tags[name] for name in names}
    tag = {"rungs": "Run", "feeder": "Axis.State", "text": "Lamp"}[world]
    assert str(followed.chain(tag)) == str(played.chain(tag)) == str(bench.program.chain(tag))


def test_another_program_departs_where_its_outputs_differ(tmp_path):
    bench = make(tmp_path, "rungs")
    do(bench, "100ms press start 100ms hold guard 100ms")  # guard is on from scan 26 on
    recording = bench._journal.recording()
    file = tmp_path / "line.rung"
    file.write_text(file.read_text("utf-8").replace("XIC(Lamp)OTE(Beacon)", "XIO(Lamp)OTE(Beacon)"), "utf-8")
    other = debugger_of(tmp_path)
    assert follow(recording, other, len(recording.scans) - 1).departs == 0


@pytest.mark.parametrize("done", ["100ms set Auto=1 100ms", "100ms force Run=1 100ms", "1s hold sel 100ms"])
def test_a_recording_with_other_inputs_needs_the_images_of_a_rack(tmp_path, done):
    bench = make(tmp_path, "rungs")
    do(bench, done)  # a tag set from outside, a force, a fault of the CPU
    assert not can_follow(bench._journal.recording(), debugger_of(tmp_path))
