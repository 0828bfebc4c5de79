"""What the page says at once: what blocks do, why in view, aliases, what it would take.

Broken on purpose: the seconds of a timer left in ms, the orders of an answer not given in the branch: red.
"""

import re
from pathlib import Path

import pytest
from scanrack.jobs import open_bench
from watched_page import until, watching, why_not

FEEDER = Path(__file__).parents[2] / "examples" / "feeder" / "feeder.rung"
PANEL = FEEDER.parents[1] / "three_stations_panel"
ERROR = "Local:1:I.Data[0].11"

LINES = """
return [...document.querySelectorAll(`[data-at='${arguments[0]}'] [data-now]`)].map(each => each.textContent);
"""


def test_blocks_say_what_they_do_and_show_their_parameters_on_request(page, paused):
    page.open_at(paused, 1500)
    bench = open_bench("examples/feeder/feeder.toml")
    bench.scan(1500)
    position = bench.slot[1].status.position
    until(lambda: page.run(LINES, "Main.10") == ["moving to 6,000", f"at {position:,}, 4,000 steps/s"])
    assert page.run(LINES, "Main.11") == ["idle", ""]
    assert page.run(LINES, "Main.3") == ["0.0 of 1.0 s"]  # TON(Quiet,1000,0)
    assert (
        page.run(LINES, "Main.13")[0] == "moves 0"
    )  # MOV(card.I.Fault,Module.Fault), whatever the axis does
    box = "return document.querySelector(\"[data-at='Main.10'] svg\").textContent"
    assert "Deceleration" not in page.run(box)
    page.press("Parameters")
    until(lambda: "Deceleration" in page.run(box))
    page.until_drawn()
    assert page.value("OutGo") == "1"
    page.step(3100)  # the emergency stop at 8 s is let go 0.5 s later, in scan 4,250; then Quiet counts
    page.until_scan(4599, "paused")
    bench.scan(3100)
    quiet = bench.program.tags["Quiet.ACC"]
    assert 0 < quiet < 1000
    until(lambda: page.run(LINES, "Main.3") == [f"{quiet / 1000:.1f} of 1.0 s"])
    until(lambda: page.run(LINES, "Main.13")[1].startswith("error "))
    page.press("Parameters")
    until(lambda: "Deceleration" not in page.run(box))


INSIDE = """
const [inner, outer] = [...arguments].map(each => document.querySelector(each)?.getBoundingClientRect());
const end = Math.min(outer.bottom, innerHeight);
return Boolean(inner) && inner.height > 0 && inner.top >= outer.top && inner.bottom <= end;
"""
TOLD = """
const parts = [...document.querySelectorAll("#tag .parts, #tag .answer, .alert")];
return parts.map(each => each.innerText).join();
"""
BAND = (
    "return [...document.querySelectorAll('.alert strong, .first')].map(each => each.textContent).join(' ')"
)


@pytest.fixture
def aliased(feeder_rack, tmp_path):
    """The feeder with an alias of INPUT_ERROR, paused before its first scan."""
    missing = why_not()
    if missing is not None:
        pytest.skip(missing)
    program = FEEDER.read_text(encoding="utf-8").replace(
        "SLOT card : 1", f"SLOT card : 1\nALIAS Broken : {ERROR}"
    )
    (tmp_path / "feeder.rung").write_text(program, encoding="utf-8")
    text = feeder_rack.read_text(encoding="utf-8").replace(FEEDER.resolve().as_posix(), "feeder.rung")
    (tmp_path / "feeder.toml").write_text(text, encoding="utf-8")
    with watching(tmp_path / "feeder.toml", "--paused", "--time-scale", "max") as session:
        yield session


def test_the_causes_lead_to_the_contact_and_an_alias_is_its_address(page, aliased):
    page.look(1280, 720)
    page.open_at(aliased, 4300)  # the emergency stop came at 8 s, in scan 4,000
    until(lambda: page.run(BAND).startswith("Broken came on"))
    page.run("document.getElementById('program').scrollTop = 1e6")
    page.click(".alert button")
    page.until_there("#causes li")
    until(lambda: page.run(INSIDE, ".rungs .row[aria-current] svg", "#program"))
    until(
        lambda: page.run(
            INSIDE,
            ".row[aria-current] [data-because] .name, .row[aria-current] [data-because] .heading",
            "#program",
        )
    )
    page.until_scan(4299, "paused")  # it is no reason to leave the present
    page.panel("words")
    page.run(
        "document.querySelector(\"#words .bit[data-name='1.INPUT_ERROR']\").click()"
    )  # a rule lies over it
    page.press("Why")
    until(lambda: page.run(INSIDE, "#tag .answer p", "#tag"))
    until(lambda: "Broken" in page.run(BAND))
    assert "Local:" not in page.run(TOLD)
    page.control("Find").send_keys(ERROR, "\ue007")  # Enter
    until(lambda: page.run("return document.querySelector('#tag .name').textContent") == "Broken")
    page.press("Deselect")
    page.control("Find").send_keys("\ue003" * len(ERROR), "broken\ue007")
    page.until_there("#tag[data-selected]")
    page.press("Strip")
    page.watch("Broken")
    page.watch(ERROR)
    names = "return [...document.querySelectorAll('#watch tr.tag th')].map(each => each.textContent)"
    assert page.run(names) == ["Broken"]
    page.run("return import('/taglanes.js').then(lanes => lanes.toggleTag(arguments[0]))", ERROR)
    assert page.run("return import('/taglanes.js').then(lanes => lanes.tagNames())") == []


ANSWERS = "return [...document.querySelectorAll('#tag .answers button')].map(each => each.textContent)"


def test_what_it_would_take_runs_as_a_branch_beside_the_past(page, tmp_path):
    missing = why_not()
    if missing is not None:
        pytest.skip(missing)
    text = (
        (PANEL / "line.toml")
        .read_text(encoding="utf-8")
        .replace("line.rung", (PANEL / "line.rung").as_posix())
    )
    idle = re.sub(r"timeline = \[.*?\n\]", "", text, flags=re.DOTALL)  # nobody presses start
    (tmp_path / "line.toml").write_text(f"watchdog_ms = 0\n{idle}", encoding="utf-8")
    record = tmp_path / "run.mcap"
    with watching(tmp_path / "line.toml", "--paused", "--time-scale", "max", "--record", record) as session:
        page.open_at(session, 200)
        page.click("[data-element='Main.0.3']")  # OTE(Run)
        page.press("What would it take")
        until(lambda: page.run(ANSWERS))
        assert page.run(ANSWERS)[0] == "Press start (slot 2) for 60 ms"
        page.click("#tag .answers button")
        page.until_value("Run", "1")
        until(lambda: "This is a branch" in page.run("return document.getElementById('notice').textContent"))
        assert page.handle("state") == "paused"
        assert 199 < int(page.handle("scan")) < 200 + 5000 // 2  # within 5 s, at 2 ms
        other = "return document.querySelector('#compared strong')?.textContent"
        until(lambda: page.run(other) == "run.mcap")
        page.press("Step")  # the press of the branch is in its past, and not in that of its parent
        events = "return document.querySelector('#events').textContent"
        until(lambda: "start input is energized" in page.run(events))
    assert (tmp_path / "run-200.mcap").exists()
