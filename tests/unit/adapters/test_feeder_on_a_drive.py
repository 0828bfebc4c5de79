"""The feeder of the examples runs unchanged on a 3601 and on a networked drive: the same moves."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from feeder_story import moves_of
from scanrack.jobs import build_cpu, build_rack, load_job
from witness import Witness

FEEDER = Path(__file__).parents[3] / "examples" / "feeder"
MODULE = 'module = "amci3601"\nfirmware = "4.1"'
DRIVE = 'module = "amci-drive"\noptions = { in2 = "estop", unwired = "inactive" }'


def story(folder: Path, module: str) -> list[tuple[str, str, int | None]]:
    """Run the feeder for 20 s; return its moves."""
    folder.mkdir()
    shutil.copy(FEEDER / "feeder.rung", folder)
    text = (FEEDER / "feeder.toml").read_text(encoding="utf-8")
    assert MODULE in text
    (folder / "rack.toml").write_text(text.replace(MODULE, module), encoding="utf-8")
    job, witness = load_job(str(folder / "rack.toml")), Witness()
    with build_cpu(job.spec, job.logic, build_rack(job.spec), listeners=[witness]) as cpu:
        cpu.run(10_000)
    return moves_of(witness)


@pytest.mark.slow
def test_the_feeder_runs_unchanged(tmp_path):
    on_a_3601 = story(tmp_path / "amci3601", MODULE)
    assert story(tmp_path / "drive", DRIVE) == on_a_3601
    assert ("absolute", "cut short", None) in on_a_3601
