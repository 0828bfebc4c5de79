"""Backwards: any scan of a session and of a recording, and another way from there on.

Broken on purpose: values of a later scan, orders of the parent left out, power of the scan before.
"""

import asyncio
import json

import pytest
from scanrack.commands import build
from scanrack.jobs import open_bench
from scanrack.traces import open_trace, read_columns
from typer.testing import CliRunner
from watching import FEEDER, page_of, watched


def run(path, *options):
    done = CliRunner().invoke(build(), ["run", str(FEEDER), "--record", str(path), "-q", *options])
    assert done.exit_code == 0, done.output


async def shown(page, scan):
    """Look at a scan; return the frame once its power is there."""
    page.frame.pop("power", None)
    await page.ask("show", routine="Main", columns=88)
    await page.ask("look", scan=scan)
    await page.until(lambda seen: seen.frame.get("scan") == scan and len(seen.frame.get("power", {})) == 14)
    return page.frame


def bench_at(scan):
    """Return the bench behind a scan."""
    bench = open_bench(FEEDER)
    bench.scan(scan + 1)
    return bench


@pytest.mark.slow
@pytest.mark.parametrize("scan", [0, 1, 700, 4003, 9999])
def test_a_scan_of_a_recording_shows_what_the_bench_shows(tmp_path, scan):
    path = tmp_path / "run.mcap"
    run(path, "--scans", "10000")

    async def look(session):
        async with page_of(session) as page:
            await page.until(lambda seen: "scan" in seen.frame)
            assert page.hello["kind"] == "trace"
            assert page.frame["state"] == "past"
            return await shown(page, scan)

    with watched(f"--port={0}", rack=f"{path}#scan={scan}") as session:
        assert session.link.endswith(f"&scan={scan}")
        session.key = session.key.split("&")[0]
        frame = asyncio.run(look(session))
    bench = bench_at(scan)
    assert frame["words"]["1"] == [*bench.slot[1].inputs, *bench.slot[1].outputs]
    for name, value in frame["tags"].items():
        if not name.startswith("card."):
            assert bench[name] == value, name
    truths = bench.program.truth("Main")
    for number, truth in enumerate(truths):
        power = frame["power"][f"Main.{number}"]
        assert [each == "1" for each in power[: len(truth or ())]] == list(truth or ())


@pytest.mark.slow
def test_a_branch_equals_its_parent_up_to_its_scan_and_goes_its_own_way(tmp_path):
    path = tmp_path / "session.mcap"

    async def branch(session):
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frame.get("scan", 0) > 1500)
            await page.ask("force", tag="Local:1:I.Data[6]", value=99)
            forced = (await page.ask("press", slot=1, name="estop", on=True))["scan"]
            await page.until(lambda seen: seen.frame["scan"] > forced + 500)
            await page.ask("pause")
            page.hello = {}
            await page.ask("branch", scan=forced + 200)
            await page.until(
                lambda seen: seen.hello and "scan" in seen.frame and seen.frame["state"] == "paused"
            )
            begun = page.frame["scan"]
            await page.ask("unforce", tag="all")
            await page.ask("step", scans=100)
            await page.until(lambda seen: seen.frame["scan"] >= begun + 100)
            return forced + 200, page.hello["record"]

    with watched("--record", path, "--time-scale", "5") as session:
        at, record = asyncio.run(branch(session))
    assert record == str(tmp_path / f"session-{at}.mcap")
    with open_trace(path) as trace, open_trace(record) as other:
        parent, child = read_columns(trace), read_columns(other)
        told = other.head.metadata
    assert (told["parent"], told["parent_scan"]) == ("session.mcap", str(at))
    assert (parent.words[:at] == child.words[:at]).all()
    assert (parent.words[: at + 90, 14] == 99).sum() > 200  # the force in the parent
    assert child.words[at + 50, 14] != 99
    for each in (path, record):
        done = CliRunner().invoke(build(), ["replay", "--into", "session", str(each)])
        assert done.exit_code == 0, done.output


@pytest.mark.slow
def test_a_branch_of_a_session_that_runs_goes_on():
    async def branch(session):
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frame.get("scan", 0) > 300)
            page.hello = {}
            await page.ask("branch", scan=200)
            await page.until(lambda seen: seen.hello and seen.frame.get("scan", 0) > 250)
            return page.frame["state"]

    with watched("--time-scale", "5") as session:
        assert asyncio.run(branch(session)) == "live"


@pytest.mark.slow
def test_a_scan_that_was_not_run_is_no_place_for_a_branch():
    async def branch(session):
        async with page_of(session) as page:
            return await page.ask("branch", scan=10**6)

    with watched() as session:
        answer = asyncio.run(branch(session))
    assert "scan 1000000 has not been run yet" in answer["refused"]


def test_a_recording_takes_no_orders_and_does_not_run_foreign_python(tmp_path):
    path = tmp_path / "line.mcap"
    rack = FEEDER.parents[1] / "three_stations" / "line.toml"
    done = CliRunner().invoke(build(), ["run", str(rack), "--record", str(path), "-q", "--scans", "500"])
    assert done.exit_code == 0

    async def look(session):
        async with page_of(session) as page:
            await page.until(lambda seen: "scan" in seen.frame)
            assert page.frame["scan"] == 499
            assert page.hello["read_only"]
            assert page.hello["lacks"].endswith(f"scanrack watch {path} --trust")
            return [await page.ask("pause"), await page.ask("look", scan="live")]

    with watched(rack=path, cwd=tmp_path) as session:
        pause, live = asyncio.run(look(session))
    assert "it accepts no actions" in pause["refused"]
    assert "nothing is running" in live["refused"]


def test_what_is_no_trace_is_refused(tmp_path):
    path = tmp_path / "nothing.mcap"
    path.write_bytes(b"nothing")
    done = CliRunner().invoke(build(), ["watch", str(path)])
    assert done.exit_code == 2
    done = CliRunner().invoke(build(), ["watch", f"{path}#scan=ten"])
    assert done.exit_code == 2
    assert "'ten' is not the number of a scan" in done.output
    assert json.dumps(done.output)
