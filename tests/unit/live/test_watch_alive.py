"""A session and its pages: pictures, orders, questions; a killed monitor, and pages that never read.

Broken on purpose: no restart, a pump that waits for each page, edges of the last row only: a test turns red.
"""

import asyncio
import os
import signal
from contextlib import AsyncExitStack
from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.traces import open_trace, read_columns
from typer.testing import CliRunner
from watching import FEEDER, page_of, watched


@pytest.fixture(scope="module")
def session():
    with watched() as running:
        yield running


def on_a_page(session, work):
    async def run():
        async with page_of(session) as page:
            await page.until(lambda seen: "scan" in seen.frame)
            return await work(page)

    return asyncio.run(run())


def test_a_page_is_told_of_the_rack_and_sees_scans(session):
    async def look(page):
        begun = page.frame["scan"]
        await page.until(lambda seen: seen.frame["scan"] > begun + 50)
        return page

    page = on_a_page(session, look)
    assert page.hello["rack"] == "feeder"
    assert page.hello["kind"] == "rack"
    assert [each["name"] for each in page.hello["routines"]] == ["Main"]
    (slot,) = page.hello["slots"]
    assert (slot["number"], slot["catalog"]) == (1, "amci3601")
    assert {"name": "home", "title": "Home", "kind": "switch", "rest": False} in slot["inputs"]
    assert page.frame["mode"] == "run"
    assert len(page.frame["words"]["1"]) == 16


def test_power_and_tags_of_a_shown_routine_come_with_the_frames(session):
    async def look(page):
        answer = await page.ask("show", routine="Main", columns=88)
        await page.until(lambda seen: len(seen.frame.get("power", {})) == len(answer["rungs"]))
        return answer, page.frame

    answer, frame = on_a_page(session, look)
    assert [each["number"] for each in answer["rungs"]] == list(range(14))
    assert all("data-element" in each["svg"] for each in answer["rungs"])
    assert frame["power"]["Main.0"] == "111"  # XIO(S:FS)OTE(Awake): both conduct, as the rail does
    assert frame["tags"]["Awake"] is True


def test_a_pulse_of_one_scan_is_in_the_strip(session):
    async def press(page):
        await page.ask("pause")
        for on in (False, True, False):  # off first: the carriage may stand on the switch
            await page.ask("press", slot=1, name="home", on=on)
            last = (await page.ask("step", scans=1))["scan"]
        await page.until(lambda seen: seen.frame["scan"] == last)
        await page.ask("press", slot=1, name="home", on=None)
        await page.ask("go")
        return page.edges["1.IN_HOME"]

    edges = on_a_page(session, press)
    (rise, up), (fall, down) = edges[-2:]
    assert (up, down) == (1, 0)
    assert fall - rise == 2_000_000  # one scan


@pytest.mark.slow
def test_a_tag_is_forced_and_shown(session):
    async def force(page):
        await page.ask("watch", tags=["Homing", "Nothing"])
        acts = (await page.ask("force", tag="Homing", value=True))["scan"]
        await page.until(lambda seen: seen.frame["scan"] >= acts)
        await page.until(lambda seen: seen.frame["tags"].get("Homing") is True)
        why = await page.ask("why", tag="Homing")
        await page.ask("unforce", tag="Homing")
        return why

    assert on_a_page(session, force)["text"].startswith("Homing is on since ")
    assert on_a_page(session, force)["text"].rpartition(": ")[2].startswith("forced to 1 since ")


def test_why_find_and_xref_answer(session):
    async def ask(page):
        return [
            await page.ask("why", tag="Awake"),
            await page.ask("find", text="strokes"),
            await page.ask("xref", tag="Strokes"),
            await page.ask("why", tag="Nothing"),
        ]

    why, find, xref, unknown = on_a_page(session, ask)
    assert "Awake is on since" in why["text"]
    assert {each["rung"] for each in find["hits"]} >= {None, "Main.12"}
    assert {each["rung"] for each in xref["hits"]} == {"Main.12"}
    assert "no tag Nothing" in unknown["refused"]


def test_a_past_scan_is_shown_to_the_page_that_asks_and_to_no_other(session):
    async def look(page):
        await page.ask("show", routine="Main", columns=88)
        async with page_of(session) as other:
            await other.until(lambda seen: seen.frame.get("scan", 0) > 30)
            assert (await page.ask("look", scan=20))["scan"] == 20
            await page.until(lambda seen: seen.frame["state"] == "past")
            await other.until(lambda seen: seen.frame["scan"] > 40)
            assert (page.frame["scan"], other.frame["state"]) == (20, "live")
        await page.ask("look", scan="live")
        await page.until(lambda seen: seen.frame["state"] == "live" and seen.frame["scan"] > 40)
        return await page.ask("look", scan=10**9)

    assert "no scan 1000000000; available are" in on_a_page(session, look)["refused"]


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="/proc tells of children on Linux only")
def test_a_killed_monitor_is_started_again_and_the_trace_is_whole(tmp_path):
    path = tmp_path / "session.mcap"
    with watched("--record", path) as session:
        before = on_a_page(session, still)
        os.kill(session.monitor, signal.SIGKILL)
        after = on_a_page(session, still)  # the same port, and the link is still good
        assert after > before
        assert session.end() == 130
        assert "the monitor has died and is started again" in session.process.stderr.read()
    with open_trace(path) as trace:
        numbers = read_columns(trace).scan
        assert trace.notes == []
    assert numbers.tolist() == list(range(len(numbers)))
    done = CliRunner().invoke(build(), ["replay", "--into", "session", str(path)])
    assert done.exit_code == 0, done.output


async def still(page):
    """Wait until power is known, and return the scan: the monitor runs scans again."""
    await page.ask("show", routine="Main", columns=88)
    await page.until(lambda seen: seen.frame.get("power", {}).get("Main.0") == "111")
    return page.frame["scan"]


@pytest.mark.slow
def test_pages_that_never_read_keep_nobody_waiting(session):
    async def look():
        async with AsyncExitStack() as stack:
            for _ in range(3):
                deaf = await stack.enter_async_context(page_of(session))
                deaf.socket.transport.pause_reading()
            page = await stack.enter_async_context(page_of(session))
            await page.until(lambda seen: seen.frames > 60)
            return page.frame["missed"]

    assert asyncio.run(look()) == 0


@pytest.mark.slow
def test_a_session_ends_by_itself_after_its_scans():
    with watched("--scans", "50", "--time-scale", "max") as session:
        assert session.process.wait(120) == 0


@pytest.mark.slow
def test_a_program_in_python_shows_its_text_and_its_values():
    async def look(page):
        await page.until(lambda seen: "scan" in seen.frame)
        answer = await page.ask("show", routine="line.py", columns=88)
        await page.until(lambda seen: seen.frame.get("tags", {}).get("line.station") is not None)
        refused = await page.ask("write", tag="line.station", value=1)
        return answer, page.frame["tags"], refused["refused"]

    rack = FEEDER.parents[1] / "three_stations" / "line.toml"
    with watched(rack=rack) as session:
        answer, tags, refused = on_a_page(session, look)
    assert answer["file"] == "line.py"
    assert answer["text"][0]["text"].startswith('"""Logic of the three-station line')
    assert set(tags) >= {"line.step", "line.station"}
    assert isinstance(tags["line.step"], str)
    assert "the program has no tags that can be set" in refused


@pytest.mark.slow
def test_a_session_that_begins_paused_has_a_picture_before_its_first_scan():
    async def look(running):
        async with page_of(running) as page:
            await page.until(lambda seen: seen.frame.get("state") == "paused")
            before = dict(page.frame)
            await page.ask("breakpoint", at="Awake")
            await page.until(lambda seen: seen.frame["breakpoints"])
            await page.ask("step", scans=1)
            await page.until(lambda seen: "scan" in seen.frame)
            return before, page.frame

    with watched("--paused") as running:
        before, after = asyncio.run(look(running))
    assert "scan" not in before
    assert (before["mode"], before["breakpoints"]) == ("run", [])
    assert after["scan"] == 0
