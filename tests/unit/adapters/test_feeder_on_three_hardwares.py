"""A program of motion blocks makes the same moves in the same order on all three hardwares.

The feeder of the examples, with the two changes that docs/adapters.md asks for: a round trip of 400 ms,
since a PMC006 takes 320 ms to be configured, and strokes that end 100 steps off the home switch, which
on a PMC006 is the CCW limit, too.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from feeder_story import HARDWARES, STORY, moves_of
from scanrack.jobs import build_cpu, build_rack, load_job
from witness import Witness

FEEDER = Path(__file__).parents[3] / "examples" / "feeder"
FIRST_RUNG = "XIO(S:FS)OTE(Awake);"
PROGRAM_CHANGES = {FIRST_RUNG: "MOV(400,Axis.RoundTrip);\n" + FIRST_RUNG, "BackGo,0,": "BackGo,100,"}
RACK_CHANGES = {"at_s = 8.0": "at_s = 12.0"}  # two strokes to and fro, then the button in the third one
SCANS = 10_000  # 20 s


def changed(name: str, changes: dict[str, str], folder: Path, to: str) -> Path:
    """Write a file of the example with changes."""
    text = (FEEDER / name).read_text(encoding="utf-8")
    for right, instead in changes.items():
        assert right in text
        text = text.replace(right, instead)
    path = folder / to
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("hardware", HARDWARES)
def test_the_feeder_makes_the_same_moves(hardware, tmp_path):
    module = {'"amci3601"': f'"{hardware}"', 'firmware = "4.1"': HARDWARES[hardware]}
    changed("feeder.rung", PROGRAM_CHANGES, tmp_path, "feeder.rung")
    job = load_job(str(changed("feeder.toml", RACK_CHANGES | module, tmp_path, "rack.toml")))
    witness = Witness()
    with build_cpu(job.spec, job.logic, build_rack(job.spec), listeners=[witness]) as cpu:
        cpu.run(SCANS)
    assert moves_of(witness)[: len(STORY)] == STORY
