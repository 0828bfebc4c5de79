"""Ladder programs that call routines in Python: power as noted where they run, and none in a recording.

Broken on purpose: power that is not noted, a recording that says nothing.
"""

import asyncio

import pytest
from scanrack.commands import build
from typer.testing import CliRunner
from watching import page_of, watched

RACK = 'program = "mixed.py"\nscan_ms = 2\n[[slot]]\nnumber = 1\nmodule = "amci3601"\nfirmware = "4.1"\n'
PROGRAM = """\
from scanrack.ladder import ADD, BOOL, DINT, JSR, OTE, XIC, XIO, Program

program = Program("mixed")
even, lamp, dark = program.declare("Even Lamp Dark", BOOL)
scans = program.declare("Scans", DINT)
count = 0


@program.routine
def Main(rung):
    rung(ADD(scans, 1, scans))
    rung(JSR("think"))
    rung(XIC(even), OTE(lamp))
    rung(XIO(even), OTE(dark))


@program.function
def think(tags):
    global count
    count += 1
    tags.Even = count % 2 == 0
"""


@pytest.fixture
def rack(tmp_path):
    (tmp_path / "mixed.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "mixed.py").write_text(PROGRAM, encoding="utf-8")
    return tmp_path / "mixed.toml"


@pytest.mark.slow
def test_power_of_a_paused_scan_is_that_of_its_scan(rack):
    """The routine runs once a scan: Even is on after every second one."""

    async def steps(session):
        found = []
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frame.get("state") == "paused")
            await page.ask("show", routine="Main", columns=88)
            for count in range(1, 7):
                await page.ask("step", scans=1)
                await page.until(lambda seen, count=count: seen.frame.get("tags", {}).get("Scans") == count)
                await page.until(lambda seen: seen.frame.get("power", {}).get("Main.3"))
                frame = page.frame
                found.append(
                    (frame["tags"]["Even"], frame["power"]["Main.2"][:2], frame["power"]["Main.3"][:2])
                )
        return found

    with watched("--paused", rack=rack) as session:
        found = asyncio.run(steps(session))
    assert found == [(False, "00", "11"), (True, "11", "00")] * 3


def test_a_recording_says_that_power_is_missing(rack):
    path = rack.parent / "run.mcap"
    done = CliRunner().invoke(build(), ["run", str(rack), "--record", str(path), "-q", "--scans", "20"])
    assert done.exit_code == 0, done.output

    async def look(session):
        async with page_of(session) as page:
            while "note" not in (message := await page.hear()):
                pass
            return message["note"]

    with watched("--trust", rack=path) as session:
        assert "calls routines in Python" in asyncio.run(look(session))
