"""Previews of edits: difference, mistakes at their lines, what begins anew; nothing changes meanwhile.

Broken on purpose: a preview that edits, a text that is saved over another program's, Python that is typed
and runs without trust: a test turns red.
"""

import asyncio

import pytest
from watching import PATIENCE_S, page_of, watched

pytestmark = pytest.mark.slow

RACK = 'name = "small"\nprogram = "{}"\nscan_ms = 2\n[[slot]]\nnumber = 1\nmodule = "1769-IQ16"\n'
RUNGS = """\
PROGRAM Line
TAG Go : BOOL
TAG N : DINT
TAG Fill : TIMER
ROUTINE Main
ADD(N,1,N);
XIO(Go)TON(Fill,1000,0);
END
"""


@pytest.fixture
def rack(tmp_path):
    def make(name, text):
        (tmp_path / name).write_text(text, encoding="utf-8")
        (tmp_path / "rack.toml").write_text(RACK.format(name), encoding="utf-8")
        return tmp_path / "rack.toml"

    return make


async def told(page, key):
    async with asyncio.timeout(PATIENCE_S):
        while key not in (message := await page.hear()):
            pass
    return message[key]


def changed(preview):
    return [row["sign"] + row["text"] for row in preview["rows"] if row["sign"] != " "]


def groups(preview):
    return {each["title"]: each["names"] for each in preview["groups"]}


def run(work, *options, rack):
    async def play(session):
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frame.get("scan", 0) > 50)
            return await work(page)

    with watched(*options, rack=rack) as session:
        return asyncio.run(play(session))


def test_a_typed_text_is_previewed_and_taken_over_only_then(rack):
    path = rack("line.rung", RUNGS)

    async def work(page):
        source = await page.ask("source")
        assert (source["file"], source["text"], source["lacks"]) == ("line.rung", RUNGS, "")
        text = RUNGS.replace("TAG Go", "TAG New : DINT\nTAG Go").replace("TON(Fill,1000", "TON(Fill,2000")
        text = text.replace("TAG N : DINT", "TAG N : INT")
        preview = (await page.ask("draft", text=text, base=source["base"], effects=True))["preview"]
        assert changed(preview) == [
            "+TAG New : DINT",
            "-TAG N : DINT",
            "+TAG N : INT",
            "-XIO(Go)TON(Fill,1000,0);",
            "+XIO(Go)TON(Fill,2000,0);",
        ]
        assert groups(preview) == {
            "new": ["New"],
            "of another type": ["N"],
            "keep their value": ["Fill.PRE 1000, not 2000"],
            "outputs that can differ, from power-up on": ["none"],
            "other values that can differ, from power-up on": ["Fill.ACC", "Fill.DN", "Fill.TT", "N"],
        }
        assert [each["rule"] for each in preview["findings"] if each["line"] == 2] == ["unused-tag"]
        begun = page.frame["scan"]
        await page.until(lambda seen: seen.frame["scan"] > begun + 50)
        assert (await page.ask("watch", tags=["New"]))["unknown"] == ["New"]
        assert (path.parent / "line.rung").read_text(encoding="utf-8") == RUNGS
        assert "saved" in await page.ask("draft", text=text, base=source["base"], take=True)
        assert (await told(page, "edited"))["new"] == ["New"]
        assert (path.parent / "line.rung").read_text(encoding="utf-8") == text
        refused = await page.ask("draft", text=RUNGS, base=source["base"])
        assert "was changed by another program" in refused["refused"]

    run(work, rack=path)


def test_all_mistakes_are_at_their_lines(rack):
    text = RUNGS.replace("ADD(N,1,N)", "XIC(Rum)OTE(Go);\nADD(N,1,M)")

    async def work(page):
        base = (await page.ask("source"))["base"]
        preview = (await page.ask("draft", text=text, base=base))["preview"]
        lines = {each["line"]: each["text"] for each in preview["mistakes"]}
        assert list(lines) == [6, 7]
        assert lines[6].startswith("XIC(Rum): no tag Rum")
        assert preview["groups"] == []

    run(work, rack=rack("line.rung", RUNGS))


def test_a_saved_file_waits_where_previews_are_wanted(rack):
    path = rack("line.rung", RUNGS)

    async def work(page):
        (path.parent / "line.rung").write_text(RUNGS.replace("ADD(N,1,N)", "ADD(N,2,N)"), encoding="utf-8")
        preview = await told(page, "preview")
        assert changed(preview) == ["-ADD(N,1,N);", "+ADD(N,2,N);"]
        assert preview["keeps"] == "3 tags keep their values"
        (path.parent / "line.rung").write_text(RUNGS, encoding="utf-8")
        assert await told(page, "preview") is None
        (path.parent / "line.rung").write_text(RUNGS.replace("ADD(N,1,N)", "ADD(N,3,N)"), encoding="utf-8")
        assert changed(await told(page, "preview")) == ["-ADD(N,1,N);", "+ADD(N,3,N);"]
        await page.ask("reload")
        assert "3 tags keep their values" in (await told(page, "edited"))["text"]

    run(work, "--preview", rack=path)


LOGIC = """\
class State:
    count: int = 0


state = State()


def logic(scan):
    state.count += 1
"""


def test_a_python_function_begins_anew_and_its_text_needs_trust(rack):
    path = rack("count.py", LOGIC)
    text = LOGIC.replace("+= 1", "+= 2")

    async def refused(page):
        source = await page.ask("source")
        assert "only with --trust" in source["lacks"]
        assert source["text"] == ""
        return (await page.ask("draft", text=text, base=source["base"]))["refused"]

    assert "only with --trust" in run(refused, rack=path)

    async def work(page):
        base = (await page.ask("source"))["base"]
        preview = (await page.ask("draft", text=text, base=base))["preview"]
        assert preview["keeps"] == "the program is loaded again: the objects of its module are new"
        assert groups(preview) == {"restart": ["state.count"]}
        broken = (await page.ask("draft", text=f"{text}    (\n", base=base))["preview"]
        assert [(each["line"], each["text"][:33]) for each in broken["mistakes"]] == [
            (10, "the program has a syntax error: '")
        ]

    run(work, "--trust", rack=path)
