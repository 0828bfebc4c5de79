"""An editor and a page in one session, edits while it runs, and real ports."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest
from debug_client import DebugClient, RefusedError
from watching import Watched, page_of

pytestmark = pytest.mark.slow

RACK = """
name = "counting"
program = "counting.rung"
scan_ms = 2
[[slot]]
number = 1
module = "1762-IQ8"
"""
PROGRAM = """PROGRAM counting
SLOT card : 1
TAG Number : DINT
TAG Big : BOOL
ROUTINE Main
ADD(Number,1,Number);
GRT(Number,10)OTE(Big);
END
"""


@pytest.fixture
def rack(tmp_path: Path) -> Path:
    (tmp_path / "counting.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "counting.rung").write_text(PROGRAM, encoding="utf-8")
    return tmp_path / "counting.toml"


def page_orders(client: DebugClient, *orders: dict[str, Any]) -> list[dict[str, Any]]:
    """Give orders as a page does; return the breakpoints that the page then knows, and its answers."""
    texts = [
        each["body"]["output"] for each in (*client.skipped, *client.events) if each["event"] == "output"
    ]
    link = next(word for text in texts for word in text.split() if word.startswith("http://"))

    async def give() -> list[dict[str, Any]]:
        async with page_of(Watched(None, link)) as page:
            await page.until(lambda page: "breakpoints" in page.frame)
            answers = [await page.ask(each.pop("do"), **each) for each in map(dict, orders)]
            await page.ask("here")
            await page.until(lambda page: page.frames > 1)
            return [{"breakpoints": page.frame["breakpoints"]}, *answers]

    return asyncio.run(give())


def test_breakpoints_of_one_are_seen_by_the_other(client: DebugClient, rack: Path) -> None:
    client.begin(rack, speed="max", page=True)
    client.ask("configurationDone")
    client.stopped()
    client.break_at(rack.with_suffix(".rung"), 7, condition="becomes true")
    client.ask("setDataBreakpoints", breakpoints=[{"dataId": "Big"}])
    state, answer = page_orders(client, {"do": "breakpoint", "at": "Main.0 executes"})
    assert state["breakpoints"] == ["Main.1", "Big", "Main.0 executes"]
    assert answer["ok"]
    new = client.event("breakpoint")
    assert (new["reason"], new["breakpoint"]["line"]) == ("new", 6)
    assert client.go() == ("breakpoint", 1)
    assert client.at() == "Main, rung 0"
    page_orders(client, {"do": "unbreak", "at": "Main.0 executes"})
    assert client.event("breakpoint")["reason"] == "removed"
    assert client.go() == ("breakpoint", 10)
    assert client.at() == "Main, rung 1"


def test_a_page_pauses_and_lets_go(client: DebugClient, rack: Path) -> None:
    client.begin(rack, speed="max", page=True)
    client.ask("configurationDone")
    client.stopped()
    page_orders(client, {"do": "go"})
    client.event("continued")
    page_orders(client, {"do": "pause"})
    assert client.stopped()[0] == "pause"


def test_an_edit_is_replaced_while_it_runs(client: DebugClient, rack: Path) -> None:
    file = rack.with_suffix(".rung")
    client.begin(rack, speed="max")
    client.ask("configurationDone")
    client.stopped()
    client.break_at(file, 7, condition="Number >= 20")
    client.go()
    before = int(client.value("Number"))
    edited = PROGRAM.replace("ADD(Number,1,Number);", "ADD(Number,1,Number);\nNOP();")
    file.write_text(edited, encoding="utf-8")
    client.value("reload")
    assert "edited" in client.event("output")["output"]
    client.break_at(file, 8)
    client.go()
    assert client.at() == "Main, rung 2"
    assert int(client.value("Number")) in (before + 1, before + 2)


def edited(client: DebugClient, command: str, part: str) -> str:
    """Evaluate a command that edits; return the line of the console with a part."""
    assert client.value(command, context="repl") == "the program is checked"
    while part not in (text := client.event("output")["output"]):
        pass
    return text


def numbers(client: DebugClient) -> list[str]:
    """Continue twice; return the numbers at the stops."""
    return [client.value("Number") for _ in range(2) if client.go()]


def test_saved_rungs_are_tested_and_accepted(client: DebugClient, rack: Path) -> None:
    file = rack.with_suffix(".rung")
    client.begin(rack, speed="max")
    client.ask("configurationDone")
    client.stopped()
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "Main.0"}])
    client.break_at(file, 7, condition="changes")
    client.go()
    file.write_text(PROGRAM.replace("Number,1,Number", "Number,100,Number"), encoding="utf-8")
    while "counting.rung was saved" not in client.event("output")["output"]:
        pass
    assert numbers(client) == ["2", "3"]  # before rung 0 of each scan: the saved program waits
    edited(client, "test", "the saved rungs run")
    assert numbers(client) == ["4", "104"]
    edited(client, "cancel", "the program before the edit runs")
    lost = client.event("breakpoint")["breakpoint"]
    assert (lost["verified"], lost["message"]) == (False, "counting.rung differs from the program that runs")
    assert numbers(client) == ["204", "205"]
    edited(client, "accept", "is accepted")
    assert client.event("breakpoint")["breakpoint"]["verified"]
    assert numbers(client) == ["206", "306"]
    assert file.read_text(encoding="utf-8") == PROGRAM.replace("Number,1,Number", "Number,100,Number")


def test_an_edit_with_a_mistake_is_not_tested(client: DebugClient, rack: Path) -> None:
    file = rack.with_suffix(".rung")
    client.begin(rack, speed="max")
    client.ask("configurationDone")
    client.stopped()
    assert "has the rungs that run" in edited(client, "test", "rungs")
    assert "no edit has been accepted" in edited(client, "cancel", "edit")
    file.write_text(PROGRAM.replace("OTE(Big)", "OTX(Big)"), encoding="utf-8")
    assert "counting.rung:7" in edited(client, "test", "OTX")
    assert client.go("next")[0] == "step"


def test_a_real_port_is_not_paused(client: DebugClient, rack: Path) -> None:
    client.begin(rack, live=True)
    client.ask("configurationDone")
    with pytest.raises(RefusedError, match="a real controller does not wait"):
        client.ask("pause", threadId=1)
    (answer,) = client.break_at(rack.with_suffix(".rung"), 7)
    assert (answer["verified"], "only log points" in answer["message"]) == (False, True)
    log = {"logMessage": "n = {Number}", "condition": "Number == 200"}
    (answer,) = client.break_at(rack.with_suffix(".rung"), 7, **log)
    assert answer["verified"]
    while "n = " not in client.event("output")["output"]:
        pass
