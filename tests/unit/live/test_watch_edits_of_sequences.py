"""Edits of a class of logic in a session: the sequence continues, and the recording runs again.

Broken on purpose: an edit that begins anew, a restart that is not in the order, a force that is not recorded.
"""

import asyncio
import shutil
import sys
from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.traces import open_trace, read_columns
from typer.testing import CliRunner
from watching import PATIENCE_S, page_of, watched

pytestmark = pytest.mark.slow

EXAMPLES = Path(__file__).parents[3] / "examples/sequences"


@pytest.fixture
def stations(tmp_path):
    for name in ("stations.toml", "stations.py"):
        shutil.copy(EXAMPLES / name, tmp_path)
    rack = tmp_path / "stations.toml"
    rack.write_text(rack.read_text(encoding="utf-8").replace("run_for_s", "# run_for_s"), encoding="utf-8")
    return tmp_path


async def told(page, key):
    async with asyncio.timeout(PATIENCE_S):
        while key not in (message := await page.hear()):
            pass
    return message[key]


def saved(folder, old, new):
    path = folder / "stations.py"
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


def test_a_session_with_edits_of_sequences_and_forces_runs_again(stations):
    record, again = stations / "session.mcap", stations / "again.mcap"

    async def work(session):
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frame.get("scan", 0) > 2500)
            saved(stations, "    rounds = 0", "    rounds = 0\n    laps = 0")
            edited = await told(page, "edited")
            assert (edited["new"], edited["dropped"]) == (["laps"], [])
            assert "continue: cycle at line " in edited["text"]
            saved(stations, "while True:\n            try", "while self.laps == 0:\n            try")
            await told(page, "edited")
            saved(stations, "await self.make_round()", "await self.make_round( )  # again")
            await told(page, "edited")
            assert "refused" not in await page.ask("force", tag="stations.rounds", value=5)
            begun = page.frame["scan"]
            await page.until(lambda seen: seen.frame["scan"] > begun + 300)
            saved(stations, "while self.laps == 0:", "for _ in range(99):")
            mistake = await told(page, "mistake")
            assert "is no longer at its place" in mistake["text"]
            assert (mistake["restart"], mistake["line"] is None) == (["cycle"], False)
            assert "refused" not in await page.ask("reload", restart="cycle")
            assert "restart: cycle" in (await told(page, "edited"))["text"]
            begun = page.frame["scan"]
            await page.until(lambda seen: seen.frame["scan"] > begun + 300)
            page.hello, scan = {}, page.frame["scan"] - 100
            assert "refused" not in await page.ask("branch", scan=scan)
            await page.until(lambda seen: seen.hello and seen.frame.get("scan", -1) >= scan + 50)
            return page.hello["record"], scan

    rack = stations / "stations.toml"
    with watched("--record", record, "--time-scale", "10", rack=rack) as session:
        branch, scan = asyncio.run(work(session))
        session.end()
    shutil.copy(EXAMPLES / "stations.py", stations)  # the files on the disk do not count
    sys.modules.pop("stations", None)
    done = CliRunner().invoke(
        build(), ["replay", "--into", "session", str(record), "--record", str(again), "--trust"]
    )
    assert done.exit_code == 0, done.output
    assert record.read_bytes() == again.read_bytes() or late(record)
    with open_trace(record) as one, open_trace(again) as other, open_trace(branch) as third:
        words = [read_columns(each).words for each in (one, other, third)]
        assert (words[0] == words[1]).all()
        assert (words[0][:scan] == words[2][:scan]).all()
        rounds = {int.from_bytes(each.tags, "little") for each in one.scans()}
    assert 5 in rounds


def late(path):
    """Tell whether scans began late, which is flagged: not so in a rerun."""
    with open_trace(path) as trace:
        return (read_columns(trace).flags >> 5 & 1).any()
