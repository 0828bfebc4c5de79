"""Edits are orders: a session runs again with them, branches anywhere, and shows each scan's own program.

Broken on purpose: an edit that acts a scan late when it is given again, files of an edit that are left out,
a branch that begins with the program on the disk, power of the latest program in front of an edit.
"""

import asyncio
import os
import shutil
import signal
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from scanrack.commands import build
from scanrack.traces import open_trace, read_columns
from typer.testing import CliRunner
from watching import FEEDER, page_of, watched
from websockets.exceptions import ConnectionClosed

pytestmark = pytest.mark.slow


@pytest.fixture
def feeder(tmp_path):
    for name in ("feeder.toml", "feeder.rung"):
        shutil.copy(FEEDER.parent / name, tmp_path / name)
    return tmp_path


async def saved(page, path, old, new):
    """Save an edit; return what the page is told of it."""
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    while "edited" not in (message := await page.hear()):
        assert "mistake" not in message, message
    return message["edited"]


async def after(page, scans):
    """Wait for scans from now on; return the number of the latest."""
    begun = page.frame["scan"]
    await page.until(lambda seen: seen.frame["scan"] > begun + scans)
    return page.frame["scan"]


async def branched(page, scan):
    """Branch in front of a scan; return the answer once the branch has come there, and goes on or pauses."""
    page.hello = {}
    answer = await page.ask("branch", scan=scan)
    if "refused" not in answer:
        await page.until(lambda seen: seen.hello and seen.frame.get("state") in ("live", "paused"))
        await page.until(lambda seen: seen.frame.get("scan", -1) >= scan - 1)
    return answer


def edits_in(path):
    with open_trace(path) as trace:
        return [each.scan for each in trace.events() if each.fields.get("name") == "edit"]


def rerun(path, *options):
    sys.modules.pop("step", None)  # a command has a process of its own
    done = CliRunner().invoke(build(), ["replay", "--into", "session", str(path), *options])
    assert done.exit_code == 0, done.output
    return done


def words_of(path):
    with open_trace(path) as trace:
        return read_columns(trace).words


ONE = ("EQU(Axis.State,6)OTE(Trouble);", "EQU(Axis.State,6)OTE(Trouble);\n\nXIO(S:FS)ADD(Brand,1,Brand);")
DECLARED = ("TAG Trouble : BOOL", "TAG Trouble : BOOL\nTAG Brand : DINT := 7")
TWO = ("ADD(Brand,1,Brand)", "SUB(Brand,2,Brand)")


async def twice_edited(page, folder):
    """Edit the feeder twice; return the latest scan with each of the three programs."""
    path = folder / "feeder.rung"
    await page.until(lambda seen: "scan" in seen.frame)
    first = await after(page, 300)
    path.write_text(path.read_text(encoding="utf-8").replace(*DECLARED), encoding="utf-8")
    await saved(page, path, *ONE)
    second = await after(page, 300)
    await saved(page, path, *TWO)
    return first, second, await after(page, 300)


def test_a_session_with_edits_runs_again_byte_for_byte(feeder):
    record, again = feeder / "session.mcap", feeder / "again.mcap"

    async def work(session):
        async with page_of(session) as page:
            await twice_edited(page, feeder)

    with watched("--record", record, "--time-scale", "10", rack=feeder / "feeder.toml") as session:
        asyncio.run(work(session))
        assert session.end() == 130
    shutil.copy(FEEDER.parent / "feeder.rung", feeder)  # the files on the disk do not count
    edits = edits_in(record)
    assert len(edits) >= 2
    rerun(record, "--record", str(again))
    assert edits_in(again) == edits
    with open_trace(record) as one, open_trace(again) as other:
        names = [each.name for each in one.attachments()]
        assert [(each.name, each.data) for each in one.attachments()] == [
            (each.name, each.data) for each in other.attachments()
        ]
    assert {"edit-1/feeder.rung", "edit-1/feeder.toml", "edit-2/feeder.rung"} <= set(names)
    assert record.read_bytes() == again.read_bytes() or late(record)


def late(path):
    """Tell whether scans began late, which is flagged: not so in a rerun."""
    with open_trace(path) as trace:
        return (read_columns(trace).flags >> 5 & 1).any()


def test_branches_from_before_between_and_behind_edits(feeder):
    record = feeder / "session.mcap"

    async def branch(page, scan):
        answer = await branched(page, scan)
        assert "refused" not in answer, answer
        await page.ask("step", scans=50)
        await page.until(lambda seen: seen.frame["scan"] >= scan + 49)
        return page.hello["record"]

    async def work(session):
        async with page_of(session) as page:
            scans = await twice_edited(page, feeder)
            found = [await branch(page, scans[2])]  # each branch has the edits before its scan
            found.append(await branch(page, scans[1]))
            found.append(await branch(page, scans[0]))
            assert (await page.ask("look", scan=scans[0] + 20))["scan"] == scans[0] + 20
            return scans, found

    with watched("--record", record, rack=feeder / "feeder.toml") as session:
        scans, found = asyncio.run(work(session))
        assert session.end() == 130
    edits = edits_in(record)
    parent = words_of(record)
    for path, scan in zip(found, reversed(scans), strict=True):
        child = words_of(path)
        assert len(child) >= scan + 50
        assert (child[:scan] == parent[:scan]).all()
        assert edits_in(path) == [each for each in edits if each <= scan]
        assert "identical byte for byte" in rerun(path).output or late(path)


def test_each_scan_is_shown_with_its_own_program(feeder):
    async def look(page, scan):
        await page.ask("look", scan=scan)
        await page.until(lambda seen: seen.frame["scan"] == scan)
        answer = await page.ask("show", routine="Main", columns=88)
        page.frame["power"] = {}
        await page.until(lambda seen: len(seen.frame["power"]) == len(answer["rungs"]))
        unknown = (await page.ask("watch", tags=["Brand"]))["unknown"]
        return " ".join(each["text"] for each in answer["rungs"]), unknown

    async def work(session, scans=None):
        async with page_of(session) as page:
            scans = scans or await twice_edited(page, feeder)
            await page.until(lambda seen: "scan" in seen.frame)
            return scans, [await look(page, scan) for scan in scans]

    record = feeder / "session.mcap"
    with watched("--record", record, rack=feeder / "feeder.toml") as session:
        scans, live = asyncio.run(work(session))
        session.end()
    with watched(rack=record, cwd="/") as session:
        _, recorded = asyncio.run(work(session, scans))
    assert live == recorded
    assert [unknown for _text, unknown in live] == [["Brand"], [], []]
    assert [("ADD(Brand" in text, "SUB(Brand" in text) for text, _ in live] == [
        (False, False),
        (True, False),
        (False, True),
    ]


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="/proc tells of children on Linux only")
def test_a_monitor_that_dies_behind_an_edit_comes_back_whatever_the_file_is_now(feeder):
    async def work(session):
        async with page_of(session) as page:
            await twice_edited(page, feeder)
            (feeder / "feeder.rung").write_text("NONSENSE", encoding="utf-8")
            while "mistake" not in await page.hear():
                pass
        os.kill(session.monitor, signal.SIGKILL)
        async with page_of(session) as page:
            await page.ask("show", routine="Main", columns=88)
            await page.until(lambda seen: seen.frame.get("power", {}).get("Main.0") == "111")
            await page.ask("watch", tags=["Brand"])
            await page.until(lambda seen: seen.frame.get("tags", {}).get("Brand", 7) < 0)

    with watched(rack=feeder / "feeder.toml") as session:
        asyncio.run(work(session))
        assert session.end() == 130


RACK = 'program = "count.py"\nscan_ms = 2\n[[slot]]\nnumber = 1\nmodule = "amci3601"\nfirmware = "4.1"\n'
PROGRAM = """\
from step import STEP


class State:
    count: int = 0


state = State()


def logic(scan):
    state.count += STEP
    scan.slot[1].outputs[7] = state.count % 1000
"""


def test_edits_of_a_python_program_and_its_modules_run_again(tmp_path, monkeypatch):
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "step.py").write_text("STEP = 1\n", encoding="utf-8")
    program, record = tmp_path / "count.py", tmp_path / "session.mcap"
    program.write_text(PROGRAM, encoding="utf-8")

    async def work(session):
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frame.get("tags", {}).get("state.count", 0) > 300)
            first = page.frame["scan"]
            (tmp_path / "step.py").write_text("STEP = -3\n", encoding="utf-8")
            await saved(page, program, "state.count += STEP", "state.count += STEP * 2")
            await page.until(lambda seen: seen.frame.get("tags", {}).get("state.count", 0) < -60)
            last = page.frame["scan"]
            answer = await branched(page, first)
            await page.ask("step", scans=20)
            await page.until(lambda seen: seen.frame["scan"] >= first + 19)
            return first, last, answer, page.hello["record"]

    with watched("--record", record, rack=tmp_path / "rack.toml") as session:
        first, last, answer, branch = asyncio.run(work(session))
        assert session.end() == 130
    assert "refused" not in answer
    parent, child = words_of(record), words_of(branch)
    assert (child[:first] == parent[:first]).all()
    assert (child[:, 7] == np.arange(1, len(child) + 1) % 1000).all()  # by one, as before the edit
    assert set(np.diff(parent[last - 5 : last, 7]).tolist()) <= {-6, 994}  # by twice the new step
    monkeypatch.chdir("/")
    refused = CliRunner().invoke(build(), ["replay", "--into", "session", str(record)])
    assert refused.exit_code == 2
    assert "then add --trust" in refused.output
    rerun(record, "--trust")
    rerun(branch, "--trust")


def test_a_branch_of_a_recording_goes_on_where_it_is_looked_at(feeder):
    record = feeder / "session.mcap"

    async def edit(session):
        async with page_of(session) as page:
            return await twice_edited(page, feeder)

    async def branch(session, scan):
        async with page_of(session) as page:
            await page.until(lambda seen: "scan" in seen.frame)
            assert page.hello["branches"]
            too_far = await page.ask("branch", scan=10**6)
            assert "is not in the recording" in too_far["refused"]
            assert (await page.ask("branch", scan=scan))["ok"]
            with suppress(ConnectionClosed):  # the recording's server ends; a session serves the same link
                while True:
                    await page.hear()
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frame.get("scan", -1) >= scan - 1)
            assert page.hello["kind"] == "rack"
            assert "refused" in await page.ask("reload")
            await page.until(lambda seen: seen.frame["state"] == "live" and seen.frame["scan"] >= scan + 29)
            return page.hello["record"]

    with watched("--record", record, rack=feeder / "feeder.toml") as session:
        scans = asyncio.run(edit(session))
        session.end()
    (feeder / "feeder.rung").unlink()  # the recording brings all
    with watched(rack=record, cwd="/") as session:
        found = asyncio.run(branch(session, scans[2]))
        assert session.end() == 130
    assert found == str(feeder / f"session-{scans[2]}.mcap")
    parent, child = words_of(record), words_of(found)
    assert (child[: scans[2]] == parent[: scans[2]]).all()
    assert len(child) >= scans[2] + 30
    with open_trace(found) as trace:
        assert trace.head.metadata["parent"] == "session.mcap"
    assert "identical byte for byte" in rerun(found).output or late(found)
