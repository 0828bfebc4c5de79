"""The three-station line makes the same decisions and the same stops on all three hardwares.

A round is 0, 4000, 8000, 0: three absolute moves, each after the signal of a station.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from scanrack.io_images import Image
from scanrack.io_images.amci3601 import Move, MoveKind, PresetPosition
from scanrack.jobs import build_cpu, build_rack, load_job
from witness import Witness

LINE = Path(__file__).parents[3] / "examples" / "three_stations"
SCANS = 8200  # 16.4 s: a round takes the slowest hardware 15.7 s


def move(target: int) -> list[Image]:
    """Return what the logic writes for a move: the command, then its bit taken away."""
    words = Move(MoveKind.ABSOLUTE, target, speed=5000, acceleration=1, deceleration=1).to_image()
    return [words, Image([0, *list(words)[1:]])]


DECISIONS = [PresetPosition(0).to_image(), Image(), *move(4000), *move(8000), *move(0)]
"""What the PLC writes after the configuration, one after the other."""

STORY = [
    "The station at 0 is done and signals it.",
    "absolute move from 0: complete at 4000",
    "The station at 4000 is done and signals it.",
    "absolute move from 4000: complete at 8000",
    "The station at 8000 is done and signals it.",
    "absolute move from 8000: complete at 0",
]


@pytest.mark.slow
@pytest.mark.parametrize("rack", ["line.toml", "line_pcl601.toml", "line_pmc006.toml"])
def test_the_line_decides_and_stops_alike(rack):
    written: list[Any] = []
    job, witness = load_job(str(LINE / rack)), Witness()

    def logic(scan):
        job.logic(scan)
        words = Image(list(scan.slot[1].outputs))
        if words not in written[-1:]:
            written.append(words)

    with build_cpu(job.spec, logic, build_rack(job.spec), listeners=[witness]) as cpu:
        cpu.run(SCANS)
    after_configuration = written[2:]
    assert after_configuration[: len(DECISIONS)] == DECISIONS
    told = [text for text in witness.texts if text in STORY]
    assert told[: len(STORY)] == STORY
    assert not [text for text in witness.texts if "move from" in text and text not in STORY]
