"""A capture of a plant in operation, cut at five places: replayed, compared, judged from its first rest on.

`--long` cuts it at twenty.

`tests/captures/plant.pcapng.gz` is of tshark on the loopback: `scanrack run plant.toml --realtime --server
ethernet-ip` with the rack beside it, and a pylogix that reads all words of Local:1:I and Local:1:O in one
packet, 30 times a second. Each cut begins with another packet, so that requests and replies of before are
missing.
"""

from __future__ import annotations

import gzip
import random
import re
from collections.abc import Iterator
from pathlib import Path
from struct import unpack_from

import pytest
from scanrack.commands import build
from scanrack.jobs.conform.hypotheses import search
from scanrack.jobs.conform.moments import KnownState, Timing
from scanrack.jobs.conform.paths.captured import scenes_of
from scanrack.jobs.replay.resumed import configuration_words
from scanrack.runtime.modules.amci3601.module import Amci3601
from typer.testing import CliRunner

CAPTURES = Path(__file__).parents[2] / "captures"
PORT = 34841
CONFIGURATION = "843Ch 003Ch 0 500"
TOLERANCE = ["--tolerance-time", "80ms", "--tolerance-counts", "150"]
"""Two reads of the client, and what the axis moves within a read and a half at 5,000 steps/s."""
PACKET = 6
"""Kind of a pcapng block."""
CUTS = random.Random(46).sample(range(1, 500), 20)
FEW = 5
"""How many of them are played without `--long`."""


def blocks(capture: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield the blocks of a pcapng file and their kinds."""
    at = 0
    while at < len(capture):
        kind, size = unpack_from("<II", capture, at)
        yield kind, capture[at : at + size]
        at += size


def scanrack(*words: str) -> str:
    done = CliRunner().invoke(build(), words)
    assert done.exit_code == 0, done.output
    return done.output


def imported(folder: Path, dropped: int) -> Path:
    """Return the trace of the capture without its first packets."""
    whole = list(blocks(gzip.decompress((CAPTURES / "plant.pcapng.gz").read_bytes())))
    packets = [place for place, (kind, _) in enumerate(whole) if kind == PACKET]
    late = [data for place, (_, data) in enumerate(whole) if place not in packets[:dropped]]
    (folder / "late.pcapng").write_bytes(b"".join(late))
    trace = folder / "late.mcap"
    words = ("--as", "compactlogix", "--port", str(PORT), "--out", str(trace))
    scanrack("import", str(folder / "late.pcapng"), *words)
    return trace


@pytest.mark.slow
@pytest.mark.parametrize(
    "dropped", [*CUTS[:FEW], *(pytest.param(each, marks=pytest.mark.long) for each in CUTS[FEW:])]
)
def test_a_cut_capture_is_replayed_compared_and_judged(tmp_path: Path, dropped: int) -> None:
    late, model = imported(tmp_path, dropped), tmp_path / "model.mcap"
    given = ("--configuration", CONFIGURATION, *TOLERANCE)
    said = scanrack(
        "replay", str(late), "--rack", str(CAPTURES / "plant.toml"), "--record", str(model), *given
    )
    known = re.search(r"the module starts with the state of scan (\d+), .*configuration as given", said)
    assert known is not None
    left_out = re.search(r"slot 1: (\d+) of (\d+) scans are not compared", said)
    assert left_out is not None
    assert int(left_out[1]) < 0.4 * int(left_out[2])
    assert "show the same within" in scanrack("compare", str(late), str(model), *TOLERANCE)
    found = scenes_of(late, 1, Timing(), configuration_words(CONFIGURATION))
    assert found.captured_at.startswith("2026-11-28 19:3")
    assert all(isinstance(each.moments[0], KnownState) for each in found.scenes)
    judged = [search(each.moments, Amci3601, Timing()) for each in found.scenes[:2]]
    assert [each.unexplained for each in judged] == [None] * len(judged)
    assert sum(each.reads for each in judged) > 40
    assert sum(each.reads for each in found.scenes) > int(left_out[2]) / 2
