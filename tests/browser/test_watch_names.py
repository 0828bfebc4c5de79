"""Names of inputs and outputs; a structure in the watch table, a past that runs on, a pressed button."""

import json
from functools import partial
from pathlib import Path

import pytest
from watched_page import until, watching, why_not

PANEL = Path(__file__).parents[2] / "examples" / "three_stations_panel"
FORCED = "return [...document.querySelectorAll('[data-forced][data-name]')].map(each => each.dataset.name)"
MEMBERS = """
const rows = document.querySelector(arguments[0]).querySelectorAll(".tree[open] > div > .part");
return [...rows].map(row => [...row.children].map(each => each.textContent));
"""
EVENTS = """
const [list, heading, aside] = ["#events", "#events h2", "aside"].map(each => document.querySelector(each));
const [whole, above, beside] = [list, heading, aside].map(each => each.getBoundingClientRect().bottom);
return [whole - above, whole - beside];
"""
HITS = "return [...document.querySelectorAll('.hits b')].map(each => each.textContent)"
CONTRAST = """
const { color, backgroundColor } = getComputedStyle(arguments[0]);
const light = text => {
  const [red, green, blue] = text.match(/[\\d.]+/g).map(each => each / 255)
    .map(each => each <= 0.04045 ? each / 12.92 : ((each + 0.055) / 1.055) ** 2.4);
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue + 0.05;
};
const [one, other] = [light(color), light(backgroundColor)];
return Math.max(one, other) / Math.min(one, other);
"""
"""Gives the contrast of an element's text, WCAG 2.2, 1.4.3: text needs 4.5."""


@pytest.fixture(scope="module")
def panel(tmp_path_factory):
    """The line with a panel, paused before its first scan, without a watchdog."""
    missing = why_not()
    if missing is not None:
        pytest.skip(missing)
    rack = tmp_path_factory.mktemp("panel") / "line.toml"
    text, program = (PANEL / "line.toml").read_text(encoding="utf-8"), (PANEL / "line.rung").as_posix()
    rack.write_text(f"watchdog_ms = 0\n{text.replace('line.rung', program)}", encoding="utf-8")
    with watching(rack, "--paused", "--time-scale", "max") as session:
        yield session


def found(page, text):
    """Type into Find, and return the hits of that text."""
    field = page.control("Find")
    field.clear()
    field.send_keys(text)
    page.until_drawn()
    return page.run(HITS)


def test_a_name_is_found_forced_and_shown_as_its_address(page, panel):
    page.open(panel.link, paused=True)
    page.step(20)
    page.until_scan(19, "paused")
    page.until_drawn()
    assert found(page, "Step")[0] == "Step"
    assert found(page, "slot2.input.start") == ["Local:2:I.Data[0].0"]
    page.control("Find").send_keys("\ue003" * 40, "lamp\ue007")  # the text away, Lamp, Enter
    until(lambda: page.run("return document.querySelector('#tag .name').textContent") == "Lamp")
    until(lambda: not page.control("Write").is_enabled())
    page.control("New value").send_keys("1")
    page.press("Force")
    page.step(2)
    until(lambda: {"Lamp", "3.lamp"} <= set(page.run(FORCED)))
    page.until_value("3.lamp", "1")
    page.press("Remove force")
    page.step(2)
    until(lambda: page.run(FORCED) == [] and page.value("3.lamp") == "0")
    page.watch("slot2.input.stop")
    page.until_value("slot2.input.stop", "1")  # normally closed
    assert not page.run("return document.querySelector('#watch [data-unknown]')")


@pytest.mark.parametrize("size", [(1280, 720), (400, 800)])
def test_a_structure_leaves_room_for_names_in_the_watch_table(page, panel, size):
    page.look(*size)
    page.open(panel.link, paused=True)
    if size[0] == 1280:  # three slots leave room for events
        least, beside = page.run(EVENTS)
        assert least >= 100  # five events
        assert beside <= 1
    page.watch("Axis")
    page.step(1)
    until(lambda: (page.value("Axis") or "").startswith("{"))
    width, height = page.run(
        "const { width, height } = document.querySelector('#watch tbody th').getBoundingClientRect();"
        "return [width, height]"
    )
    assert width >= 96
    assert height < 120
    members = [[name, shown(value)] for name, value in json.loads(page.value("Axis")).items()]
    until(lambda: page.run(MEMBERS, "#watch") == members)
    assert page.run("const root = document.documentElement; return root.scrollWidth <= root.clientWidth")
    if size[0] == 1280:
        page.run("document.querySelector(\"#watch .tree .plain[title='Axis.Words']\").click()")
        until(lambda: page.run("return document.querySelector('#tag .name').textContent") == "Axis.Words")
        page.until_there("#tag .tree:not([hidden])")
        page.click("#tag .tree:not([hidden]) summary")
        words = json.loads(page.value("Axis"))["Words"]
        words = [[f"[{place}]", f"{word:,}"] for place, word in enumerate(words)]
        until(lambda: page.run(MEMBERS, "#tag") == words)
        assert found(page, "aXis")[0] == "Axis"  # the structure first, then its members


def shown(value):
    """Return a member as its tree has it: how many parts, or a value."""
    return f"{len(value)} elements" if isinstance(value, list) else f"{int(value):,}"


def test_the_past_of_a_rack_that_runs_has_its_speed_and_its_pause(page, feeder):
    speed = "return document.querySelector(\"[title^='Speed reached'] output\").textContent"
    page.open(feeder.link)
    page.until_handle("state", "live")
    until(lambda: int(page.handle("scan")) > 20)
    page.run("import('/scrub.js').then(scrub => scrub.lookAt(5))")
    page.until_scan(5, "past")
    until(lambda: page.run(speed) not in ("0×", "–"))
    until(page.control("Pause").is_enabled)
    page.press("Pause")
    until(lambda: not page.control("Pause").is_enabled() and page.run(speed) == "0×")
    page.until_scan(5, "past")
    page.press("Continue")
    page.until_handle("state", "live")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_pressed_button_is_read_under_the_mouse(page, paused, scheme):
    from selenium.webdriver import ActionChains

    page.look(1600, 1000, scheme=scheme, motion="reduce")
    page.open(paused.link, paused=True)
    page.until_there("[data-at='Main.1']")
    page.until_drawn()
    page.press("Breakpoint on rung 1")
    page.until_there("[data-at='Main.1'][data-breakpoint]")
    for name in ("Breakpoint on rung 1", "Run"):
        button = page.control(name)
        ActionChains(page.browser).move_to_element(button).perform()
        until(partial(page.run, "return arguments[0].matches(':hover')", button))
        assert page.run(CONTRAST, button) >= 4.5, name
    page.press("Breakpoint on rung 1")
    page.until_there("[data-at='Main.1']:not([data-breakpoint])")
