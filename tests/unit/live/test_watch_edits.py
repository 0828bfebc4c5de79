"""Edits while a rack runs: values kept, mistakes shown at their line, the page told.

Broken on purpose: a mistake that ends the session, an edit that is not announced: a test turns red.
"""

import asyncio
import shutil

import pytest
from scanrack.traces import open_trace
from watching import FEEDER, PATIENCE_S, page_of, watched

pytestmark = pytest.mark.slow


@pytest.fixture
def feeder(tmp_path):
    for name in ("feeder.toml", "feeder.rung"):
        shutil.copy(FEEDER.parent / name, tmp_path / name)
    return tmp_path


async def told(page, key):
    """Wait for a message with a key; return what it says."""
    async with asyncio.timeout(PATIENCE_S):
        while key not in (message := await page.hear()):
            pass
    return message[key]


def edited(folder, old, new):
    path = folder / "feeder.rung"
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


def test_a_saved_program_goes_on_with_its_values(feeder):
    record = feeder / "session.mcap"

    async def edit(session):
        async with page_of(session) as page:
            await page.ask("watch", tags=["Strokes.ACC"])
            await page.until(lambda seen: seen.frame.get("tags", {}).get("Strokes.ACC", 0) >= 1)
            strokes = page.frame["tags"]["Strokes.ACC"]
            edited(feeder, "TAG Trouble : BOOL", "TAG Trouble : BOOL\nTAG Brand : DINT := 7")
            news = await told(page, "edited")
            await told(page, "program")
            assert (await page.ask("watch", tags=["Strokes.ACC", "Brand"]))["unknown"] == []
            await page.until(lambda seen: seen.frame.get("tags", {}).get("Brand") == 7)
            assert page.frame["tags"]["Strokes.ACC"] >= strokes
            await page.ask("show", routine="Main", columns=88)
            await page.until(lambda seen: seen.frame.get("power", {}).get("Main.0") == "111")
            return news

    with watched("--record", record, "--time-scale", "10", rack=feeder / "feeder.toml") as session:
        news = asyncio.run(edit(session))
    assert news["new"] == ["Brand"]
    assert "tags keep their values; new: Brand" in news["text"]
    with open_trace(record) as trace:
        (event,) = [each for each in trace.events() if each.fields.get("kind") == "edit"]
    assert event.fields["new"] == ["Brand"]


def test_a_read_only_session_goes_on_with_the_program_that_it_began_with(feeder):
    """Longer than the editor takes; a busy machine can't make it fail."""

    async def edit(session):
        async with page_of(session) as page:
            await page.until(lambda seen: "scan" in seen.frame)
            edited(feeder, "TAG Trouble : BOOL", "TAG Trouble : BOOL\nTAG Brand : DINT := 7")
            begun, taken = page.frame["scan"], []
            while page.frame["scan"] < begun + 1000:
                taken += [key for key in await page.hear() if key != "frame"]
            return taken, (await page.ask("watch", tags=["Brand"]))["unknown"]

    with watched("--read-only", rack=feeder / "feeder.toml") as session:
        assert asyncio.run(edit(session)) == ([], ["Brand"])


def test_a_mistake_is_shown_at_its_line_and_the_program_goes_on(feeder):
    async def edit(session):
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frame.get("scan", 0) > 100)
            edited(feeder, "EQU(Axis.State,6)OTE(Trouble);", "EQU(Axis.State,6)OTE(Truble);")
            mistake = await told(page, "mistake")
            begun = page.frame["scan"]
            await page.until(lambda seen: seen.frame["scan"] > begun + 200)
            assert page.frame["mode"] == "run"
            edited(feeder, "OTE(Truble);", "OTE(Trouble);")  # as it was
            assert await told(page, "note") == "The program has not changed."
            return mistake

    with watched(rack=feeder / "feeder.toml") as session:
        mistake = asyncio.run(edit(session))
    assert "Truble" in mistake["text"]
    assert mistake["file"] == "feeder.rung"


def test_a_program_that_has_not_changed_is_no_edit(feeder):
    record = feeder / "session.mcap"

    async def edit(session):
        async with page_of(session) as page:
            await page.until(lambda seen: "scan" in seen.frame)
            for _ in range(2):
                assert (await page.ask("reload"))["ok"]
                assert await told(page, "note") == "The program has not changed."
            edited(feeder, "TAG Trouble : BOOL", "TAG Trouble : BOOL\nTAG Brand : DINT := 7")
            await told(page, "edited")

    with watched("--record", record, rack=feeder / "feeder.toml") as session:
        asyncio.run(edit(session))
        session.end()
    with open_trace(record) as trace:
        given = [each.fields["name"] for each in trace.events() if each.topic == "/orders"]
    assert given == ["reload", "reload", "edit"]


def test_a_python_program_begins_anew_and_says_so(tmp_path):
    (tmp_path / "rack.toml").write_text(
        'program = "count.py"\nscan_ms = 2\n[[slot]]\nnumber = 1\nmodule = "amci3601"\nfirmware = "4.1"\n',
        encoding="utf-8",
    )
    program = tmp_path / "count.py"
    text = (
        "class State:\n    count: int = 0\n\n\nstate = State()\n\n\ndef logic(scan):\n    state.count += 1\n"
    )
    program.write_text(text, encoding="utf-8")

    async def edit(session):
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frame.get("tags", {}).get("state.count", 0) > 500)
            program.write_text(text.replace("+= 1", "-= 1"), encoding="utf-8")
            news = await told(page, "edited")
            await page.until(lambda seen: seen.frame.get("tags", {}).get("state.count", 0) < -5)
            return news

    with watched(rack=tmp_path / "rack.toml") as session:
        news = asyncio.run(edit(session))
    assert "count.py is loaded again: the objects of its module are new" in news["text"]
