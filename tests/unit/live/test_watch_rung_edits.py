"""Edited rungs over the socket: checked, bounded, tried on the last scans, tested and untested; who may edit.

Broken on purpose: a draft of another program that is taken, a read-only session that answers, effects of the
running program on itself, an untest that leaves the edited program.
"""

import asyncio
from typing import Any

import pytest
from watching import PATIENCE_S, page_of, watched

pytestmark = pytest.mark.slow

RACK = 'name = "small"\nprogram = "line.rung"\nscan_ms = 2\nwatchdog_ms = 0\n'
RACK += '[[slot]]\nnumber = 1\nmodule = "1769-IQ16"\n'
RUNGS = """\
PROGRAM Line
TAG Lamp : BOOL
TAG N : DINT
TAG Fill : TIMER
ROUTINE Main
ADD(N,1,N);
TON(Fill,1000,?);
END
"""


@pytest.fixture
def rack(tmp_path):
    (tmp_path / "line.rung").write_text(RUNGS, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    return tmp_path / "rack.toml"


def noting(page):
    """Return the list of all that a page is told from now on."""
    hear, heard = page.hear, []

    async def hear_and_note():
        heard.append(await hear())
        return heard[-1]

    page.hear = hear_and_note
    return heard


async def until_edited(page, heard, *, new="", dropped=""):
    kind, name = ("new", new) if new else ("dropped", dropped)
    async with asyncio.timeout(PATIENCE_S):
        while not any(name in each.get("edited", {}).get(kind, []) for each in heard):
            await page.hear()


def test_rungs_are_checked_tried_tested_and_untested(rack):
    async def work(session):
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frame.get("scan", 0) > 600)
            words = await page.ask("words")
            timer = next(each for each in words["instructions"] if each["name"] == "TON")
            assert (timer["presets"], "TIMER" in words["types"]) == (2, True)
            draft = {"base": words["base"], "rungs": [["Main", 1, ["XIC(Off)TON(Fill,1000,?);"]]]}
            said = await page.ask("rungs", columns=80, **draft)
            assert said["missing"] == [{"name": "Off", "program": "", "types": ["BOOL"]}]
            assert not said["right"]
            draft["tags"] = [["Off", "BOOL", ""]]
            said = await page.ask("rungs", columns=80, **draft)
            assert said["right"]
            assert len(said["rungs"][0]["gaps"]) == 3
            would = await page.ask("would", **draft)
            assert [each["name"] for each in would["groups"]] == ["Fill"]
            assert {"ACC", "EN", "TT"} <= set(would["groups"][0]["members"])
            for wrong, why in (
                ({"rungs": [["Main", 9, []]]}, "no rung 9"),
                ({"rungs": [["Main", 1, ["A" * 60_000]]]}, "60,000 bytes"),
                ({"rungs": "Main"}, "is not allowed"),
                ({"base": "another"}, "edited meanwhile"),
                ({"tags": [["N", "BOOL", ""]]}, "already"),
            ):
                assert why in (await page.ask("rungs", columns=80, **(draft | wrong)))["refused"]
            assert "edited meanwhile" in (await page.ask("would", **(draft | {"base": "another"})))["refused"]
            assert "no edit has been accepted" in (await page.ask("online", step="test"))["refused"]
            wrong = {"step": "accept", "base": words["base"], "rungs": [["Main", 0, ["XIC(Rum)OTE(Lamp);"]]]}
            assert "no tag Rum" in (await page.ask("online", **wrong))["refused"]
            assert (await page.ask("online", step="accept", **draft))["stage"] == "accepted"
            heard = noting(page)
            assert (await page.ask("online", step="test"))["stage"] == "testing"
            await until_edited(page, heard, new="Off")
            assert "is being tested" in (await page.ask("online", step="save"))["refused"]
            assert (await page.ask("online", step="untest"))["stage"] == "accepted"
            await until_edited(page, heard, dropped="Off")
            assert (await page.ask("words"))["base"] == words["base"]
            assert (await page.ask("online", step="cancel"))["stage"] == ""
            assert (rack.parent / "line.rung").read_text(encoding="utf-8") == RUNGS

    with watched(rack=rack) as session:
        asyncio.run(work(session))


def test_a_page_without_control_edits_nothing(rack):
    async def work(session):
        async with page_of(session) as page:
            asked: list[tuple[str, dict[str, Any]]] = [
                ("words", {}),
                ("rungs", {"columns": 80}),
                ("would", {}),
                ("online", {"step": "accept"}),
            ]
            for question, fields in asked:
                assert "read-only" in (await page.ask(question, **fields))["refused"]

    with watched("--read-only", rack=rack) as session:
        asyncio.run(work(session))
