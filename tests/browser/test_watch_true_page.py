"""What the page says is so: keys pressed quickly, errors that came before the page, what blocks a rung now.

Broken on purpose: `moveBy` from the scan shown, no error for a new page, red by the causes alone, `idle` of
unknown states, steps/s of the scans before, another key that only moves the link: red.
"""

import pytest
from scanrack.commands import build
from scanrack.terminal.status import DONE
from typer.testing import CliRunner
from watched_page import until, watching

QUICKLY = """
for (let press = 0; press < 3; press++) {
  document.body.dispatchEvent(new KeyboardEvent("keydown", { key: arguments[0], bubbles: true }));
}
"""
BAND = "return document.querySelector('.band')?.innerText ?? ''"
STROKES = """
const color = name => {
  const probe = document.body.appendChild(document.createElement("i"));
  probe.style.color = `var(--${name})`;
  const found = getComputedStyle(probe).color;
  probe.remove();
  return found;
};
const red = color("fault"), groups = document.querySelectorAll(`[data-at='${arguments[0]}'] .instruction`);
const stroked = each => getComputedStyle(each).stroke;
const isRed = group => [...group.querySelectorAll(".sign, .box")].some(each => stroked(each) === red);
return [...groups].filter(isRed).map(group => group.dataset.tag);
"""
NOW = "return [...document.querySelectorAll('[data-now]')].map(each => each.textContent)"
WORK_OUT = """
return import("/state.js").then(state => state.take({ known: false }));
"""
SPEED = "return document.querySelector('.figures [title=\"Steps/s\"] output').textContent"
TONES = """
return Object.fromEntries([...document.querySelectorAll("#words .bit[data-value='1']")].map(each =>
  [each.firstElementChild.textContent, getComputedStyle(each).borderColor]));
"""
EVENTS = "return [...document.querySelectorAll('.events .what')].map(each => each.textContent)"


def test_keys_that_are_pressed_quickly_add_up(page, paused):
    page.open_at(paused, 3000)
    page.run(QUICKLY, "[")
    page.until_scan(2999 - 3 * 500, "past")
    page.run(QUICKLY, ",")
    page.until_scan(2999 - 3 * 500 - 3, "past")
    page.run(QUICKLY, "]")
    page.until_scan(2999 - 3, "past")


def test_an_error_is_told_of_to_a_page_that_is_opened_after_it_and_is_not_green(page, paused):
    page.open_at(paused, 4200)  # the emergency stop comes at 8 s, scan 4,000
    until(lambda: "INPUT_ERROR came on" in page.run(BAND))
    assert page.run(SPEED) == "0"  # it stands, though it moved within the last 50 scans
    page.open(paused.link, paused=True)
    until(lambda: "INPUT_ERROR came on" in page.run(BAND))
    page.panel("words")
    tones = page.run(TONES)
    assert tones["INPUT_ERROR"] != tones["MODULE_OK"]


def test_the_contact_that_blocks_now_is_red_and_not_one_that_is_true(page, paused):
    page.open_at(paused, 4300)  # Homing was the cause at 8 s; Trouble keeps power from Feeding now
    page.click("[data-element='Main.7.4']")
    page.press("Why")
    page.until_there("#tag .chain li")
    until(lambda: page.run(STROKES, "Main.7") == ["Trouble"])
    assert page.run("return document.querySelector('[data-because]') !== null")


def test_a_block_whose_values_are_worked_out_says_nothing(page, paused):
    page.open_at(paused, 1500)
    until(lambda: "idle" in page.run(NOW))
    page.run(WORK_OUT)
    until(lambda: page.handle("known") == "0")
    until(lambda: "idle" not in page.run(NOW))
    assert "configured" not in page.run(NOW)


def test_the_link_of_another_session_at_the_port_opens_it(page, running_rack):
    with watching(running_rack, "--paused") as first:
        page.open(first.link, paused=True)
        port = first.base.rpartition(":")[2]
    page.until_handle("state", "lost")
    with watching(running_rack, "--paused", "--port", port) as second:
        assert second.base == first.base
        page.run("location.hash = arguments[0]", second.link.partition("#")[2])
        page.until_handle("state", "paused")


def test_a_press_is_one_event_and_events_stand_by_time(page, paused):
    page.open_at(paused, 2000)
    page.press("Press E-stop")
    page.step(10)
    page.until_scan(2009, "paused")
    until(lambda: any("estop" in text for text in page.run(EVENTS)))
    assert not [text for text in page.run(EVENTS) if "emergency stop input is energized" in text]
    times = page.run("return [...document.querySelectorAll('.events time')].map(each => each.textContent)")
    assert times == sorted(times, reverse=True)


@pytest.fixture(scope="module")
def recording(feeder_rack, tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "long.mcap"
    words = ["run", str(feeder_rack), "--scans", "24000", "--record", str(path), "--quiet"]
    assert CliRunner().invoke(build(), words).exit_code == DONE
    return path


def test_a_recording_is_known_to_its_first_scan(page, recording):
    since = "return document.querySelector('#tag .since').textContent"
    with watching(recording) as session:
        page.open(session.link)
        page.run(
            "import('/selection.js').then(all => all.select({ tag: 'Local:1:I.Data[0].11' }))"
        )  # INPUT_ERROR
        until(lambda: page.run(since).startswith("Since 00:09.5"))  # more than 16,384 scans before the end
        page.run("import('/selection.js').then(all => all.select({ tag: 'S:FS' }))")
        until(lambda: "in any scan" in page.run(since) or "Since" in page.run(since))


UNKNOWN = """
const unknown = document.querySelector(".unknown");
return [getComputedStyle(unknown).visibility, unknown.textContent];
"""


def test_values_that_are_not_known_yet_say_so(page, recording):
    computing = "Power and values of this scan are being computed."
    with watching(recording) as session:
        page.open(session.link)
        page.until_drawn()
        until(lambda: page.handle("known") == "1")
        assert page.run(UNKNOWN)[0] == "hidden"
        page.run(WORK_OUT)
        until(lambda: page.run(UNKNOWN) == ["visible", computing])


BOX = """
const found = {};
let caption = "";
for (const text of document.querySelectorAll(`[data-at='${arguments[0]}'] [data-instruction='TON'] text`)) {
  if (text.matches(".caption")) caption = text.textContent;
  else if (caption && text.textContent) found[caption] = text.textContent;
}
return found;
"""


def test_a_timer_of_an_slc_has_its_preset_and_its_time_in_seconds(page):
    with watching("examples/slc/conveyor.toml", "--paused", "--time-scale", "max") as session:
        page.open_at(session, 240)  # of 5 ms; the box comes at 1 s, in scan 200
        until(lambda: "0.1 of 0.5 s" in page.run(NOW) or "0.2 of 0.5 s" in page.run(NOW))
        page.press("Parameters")
        until(lambda: page.run(BOX, "U2.2").get("Preset") == "50")
        shown = page.run(BOX, "U2.2")
        assert (shown["Timer"], shown["Time base"]) == ("T4:0", "0.01")
        assert 10 <= int(shown["Accum"]) <= 20
