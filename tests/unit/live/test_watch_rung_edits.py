"""Edited rungs over the socket: checked, bounded, tried on the last scans, tested and untested; who edits.

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


async def until_online(page, heard, edit, stage="accepted"):
    async with asyncio.timeout(PATIENCE_S):
        while not any(
            (each["online"].get("edit"), each["online"]["stage"]) == (edit, stage)
            for each in heard
            if "online" in each
        ):
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
                ({"base": "another"}, "changed meanwhile"),
                ({"tags": [["N", "BOOL", ""]]}, "already"),
            ):
                assert why in (await page.ask("rungs", columns=80, **(draft | wrong)))["refused"]
            assert (
                "changed meanwhile" in (await page.ask("would", **(draft | {"base": "another"})))["refused"]
            )
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


def test_two_pages_know_whose_edit_is_accepted_and_keep_their_drafts(rack):
    async def work(session):
        async with page_of(session) as one, page_of(session) as other:
            base = (await one.ask("words"))["base"]
            mine = {"base": base, "rungs": [["Main", 0, ["ADD(N,2,N);"]]], "tags": [["Spare", "BOOL", ""]]}
            theirs = {"base": base, "rungs": [["Main", 1, ["TON(Fill,2000,?);", "XIC(Lamp)OTL(Lamp);"]]]}
            accepted = await one.ask("online", step="accept", **mine)
            assert (accepted["by"], accepted["rungs"]) == ("page 1", mine["rungs"])
            heard = noting(one)
            taken = await other.ask("online", step="accept", **theirs)
            await until_online(one, heard, taken["edit"])
            told = next(each["online"] for each in heard if "online" in each)
            assert (told["by"], told["rungs"], told["tags"]) == ("page 2", theirs["rungs"], [])
            wrong = await one.ask("online", step="assemble", base=accepted["edit"])
            assert "page 2 has accepted another edit" in wrong["refused"]
            done = await other.ask("online", step="assemble", base=taken["edit"])
            await until_online(one, heard, taken["edit"], stage="assembled")
            assert "changed meanwhile" in (await one.ask("online", step="accept", **mine))["refused"]
            moved = await one.ask("rebase", **mine)
            assert (moved["base"], moved["rungs"], moved["tags"]) == (
                done["base"],
                mine["rungs"],
                mine["tags"],
            )
            assert moved["conflicts"] == 0
            both = {"base": base, "rungs": [["Main", 1, ["TON(Fill,3000,?);"]]]}
            assert (await one.ask("rebase", **both))["conflicts"] == 1
            assert "no longer known" in (await one.ask("rebase", **{**mine, "base": "another"}))["refused"]
            del moved["id"], moved["ok"], moved["conflicts"]
            accepted = await one.ask("online", step="accept", **moved)
            assert accepted["of"] == done["base"]
            assert (await one.ask("online", step="test", base=accepted["edit"]))["stage"] == "testing"
            heard = noting(other)
            assert (await one.ask("branch", scan=0))["ok"]  # there no edit has been accepted, in no page
            await until_online(other, heard, None, stage="")
            assert (
                next(each["online"]["base"] for each in heard if each.get("online", {}).get("stage") == "")
                == base
            )

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
