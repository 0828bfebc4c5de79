"""The three-station example as rungs does what the plain function does."""

from pathlib import Path

import pytest
from scanrack.jobs import build_cpu, build_rack, load_job

EXAMPLES = Path(__file__).parents[3] / "examples"
SCANS = 12_000  # 24 s: three moves and the pulses between them


class Recorder:
    """A listener that keeps the rack's memory of every scan."""

    def __init__(self, rack):
        self.rack, self.images = rack, []

    def scan(self, _scan, _now_ns, _flags):
        self.images.append(bytes(self.rack.memory))

    def event(self, *_event):
        pass

    def close(self):
        pass


@pytest.fixture(scope="module")
def images():
    """Return the memory of the rack after every scan, by example."""
    found = {}
    for example in ("three_stations", "three_stations_ladder"):
        job = load_job(str(EXAMPLES / example / "line.toml"))
        rack = build_rack(job.spec)
        recorder = Recorder(rack)
        with build_cpu(job.spec, job.logic, rack, listeners=[recorder]) as cpu:
            cpu.run(SCANS)
        found[example] = recorder.images
    return found


def test_the_images_are_the_same_in_every_scan(images):
    pairs = zip(images["three_stations"], images["three_stations_ladder"], strict=True)
    assert [number for number, (plain, rungs) in enumerate(pairs) if plain != rungs] == []


def test_something_happened(images):
    assert len(set(images["three_stations"])) > 1000
