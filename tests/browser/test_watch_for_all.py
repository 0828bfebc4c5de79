"""For everybody: keyboard, names, no color alone, dark and light, reduced motion, narrow; markup is text."""

import json
from functools import partial

import pytest
from axe_peer import axe_findings
from contrast import contrast
from watched_page import steadily, until, watching

TAB, ENTER, RIGHT = "\ue004", "\ue007", "\ue014"
"""Keys as WebDriver names them [W3C WebDriver, 17.4.2]."""

CONTROLS = "button, input, select, summary, a[href], [tabindex], [role=button], [role=tab]"
REACHED = f"""
const seen = each => each.checkVisibility({{visibilityProperty: true}}) && !each.disabled;
return [...document.querySelectorAll("{CONTROLS}")].filter(each => seen(each) && each.tabIndex >= 0);
"""
WIDE = "return [document.documentElement.scrollWidth, innerWidth]"
HITS = """
const { left, right } = document.querySelector(".hits").getBoundingClientRect();
return [left, right];
"""
STYLE = "return getComputedStyle(document.querySelector(arguments[0])).getPropertyValue(arguments[1])"
COLORS = """
const style = getComputedStyle(document.documentElement);
return arguments[0].map(name => style.getPropertyValue(`--${name}`));
"""
SCALE = """
const rung = document.querySelector("svg.rung");
return rung.clientWidth / rung.viewBox.baseVal.width;
"""
PRESS = "document.querySelector(arguments[0]).dispatchEvent(new MouseEvent('click', { bubbles: true }))"
MOVING = """
const styles = [...document.querySelectorAll("*")].map(each => getComputedStyle(each));
return styles.filter(each => each.transitionDuration !== "0s" || each.animationName !== "none").length;
"""


def html(control):
    return control.get_attribute("outerHTML")[:200]


@pytest.fixture
def opened(page, feeder):
    page.open(feeder.link)
    page.until_there("svg.rung [data-element]")
    page.until_drawn()
    return page


def text(page, selector):
    return page.run("return document.querySelector(arguments[0])?.textContent", selector)


def test_every_control_has_an_accessible_name(opened):
    def nameless():
        controls = opened.run(REACHED)
        assert len(controls) > 40
        return [html(each) for each in controls if not each.accessible_name.strip()]

    assert steadily(nameless) == []


@pytest.mark.parametrize(("wide", "high", "scheme"), [(1280, 720, "light"), (400, 800, "dark")])
def test_axe_finds_nothing(opened, wide, high, scheme):
    opened.look(wide, high, scheme=scheme)
    opened.until_there("svg.rung [data-element='Main.7.2']")
    opened.run(PRESS, "[data-element='Main.7.2']")
    opened.until_there("#tag .name")  # the sheet of a tag, and the causes of its value
    for panel in ("events", "watch", "words"):
        opened.panel(panel)
        assert axe_findings(opened) == []


def test_a_screen_reader_reads_sentences_and_no_running_figures(opened):
    """Live regions of Chromium's accessibility tree; an <output> is one unless it says otherwise."""
    tree = opened.browser.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    live = [
        node["backendDOMNodeId"]
        for node in tree
        for each in node.get("properties", [])
        if each["name"] == "live" and each["value"]["value"] != "off"
    ]
    described = [
        opened.browser.execute_cdp_cmd("DOM.describeNode", {"backendNodeId": each})["node"] for each in live
    ]
    pairs = [each["attributes"] for each in described]
    names = {dict(zip(each[::2], each[1::2], strict=True)).get("id") for each in pairs}
    assert "notice" in names
    assert "OUTPUT" not in {each["nodeName"] for each in described}


def test_the_keyboard_reaches_every_control(opened):
    opened.press("Pause")  # events that come meanwhile are controls, too
    until(lambda: opened.handle("state") == "paused")
    opened.until_drawn()
    expected = opened.run(REACHED)
    opened.run(
        "window.seen = []; document.addEventListener('focusin', event => seen.push(event.target));"
        "document.activeElement.blur()"
    )
    missed = "return arguments[0].filter(each => !seen.includes(each))"
    for _ in range(2 * len(expected)):  # more than there are, if some have come meanwhile
        opened.browser.switch_to.active_element.send_keys(TAB)
        if not opened.run(missed, expected):
            break
    assert [html(each) for each in opened.run(missed, expected)] == []
    opened.press("Continue")


def test_instructions_are_chosen_with_arrows_and_enter(opened):
    def choose():
        first = opened.browser.find_element("css selector", "[data-element='Main.7.0']")
        opened.run("arguments[0].focus()", first)
        for key in (RIGHT, RIGHT, ENTER):
            opened.browser.switch_to.active_element.send_keys(key)

    steadily(choose)
    until(lambda: text(opened, "#tag .name") == "Homing")
    assert opened.run("return document.querySelector('[data-element=\"Main.7.2\"]').ariaCurrent") == "true"


def test_the_focus_stays_when_the_rungs_are_drawn_for_another_width(opened):
    opened.run("document.querySelector(\"[data-element='Main.7.0']\").focus()")
    opened.run("window.before = document.querySelector('svg.rung')")
    opened.look(1900, 1000)
    until(lambda: opened.run("return document.querySelector('svg.rung') !== before"))
    assert opened.run("return document.activeElement.dataset.element") == "Main.7.0"
    opened.look(1600, 1000)


def test_no_state_is_shown_by_color_alone(opened):
    widths = {}
    for power in "01":
        wire = f"[data-power='{power}'] > .wire"
        opened.until_there(wire)
        widths[power] = float(opened.run(STYLE, wire, "stroke-width").strip("px"))
    assert widths["1"] >= 2 * widths["0"]  # power is thick
    for level in "01":  # bits and inputs carry their level as a digit
        shown = f"#words .bit[data-value='{level}'] .level"
        opened.until_there(shown)
        assert text(opened, shown) == level
    assert text(opened, ".state").endswith("Live")
    assert text(opened, ".key [aria-pressed=true]") == "Run"


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_can_be_read_in_either_scheme(opened, scheme):
    opened.look(1600, 1000, scheme=scheme)
    names = ("ink", "soft", "accent", "power", "warn", "fault", "mark")
    panel, *colors = opened.run(COLORS, ["panel", *names])
    for name, color in zip(names, colors, strict=True):
        assert contrast(color, panel) >= 4.5, name  # WCAG 2, 1.4.3
    for name in ("power", "warn", "fault"):
        ink, paper = opened.run(COLORS, [name, f"{name}-soft"])
        assert contrast(ink, paper) >= 4.5, name


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_narrow_window_does_not_scroll_sideways(opened, scheme):
    wide = opened.run("return document.querySelector('svg.rung').getAttribute('width')")
    opened.look(400, 800, scheme=scheme)
    until(lambda: opened.run("return document.querySelector('svg.rung').getAttribute('width')") != wide)
    reach, width = opened.run(WIDE)
    assert reach <= width == 400
    for summary in opened.browser.find_elements("css selector", "summary"):
        opened.run("arguments[0].parentElement.open = true", summary)
    opened.press("More controls")
    opened.control("Find").send_keys("Str")
    opened.until_there(".hits button")
    left, right = opened.run(HITS)
    assert 0 <= left < right <= width
    assert opened.run(WIDE)[0] <= width
    assert opened.run(SCALE) > 0.85  # the rungs are laid out again, not made small


def test_long_names_do_not_widen_a_narrow_window(page, tmp_path):
    name = "a_name_that_is_longer_than_any_place_for_one_of_a_telephone_has"
    (tmp_path / f"{name}.py").write_text(
        f"class Line:\n    {name}: int = 0\n\n\nline = Line()\n\n\ndef logic(scan):\n    pass\n",
        encoding="utf-8",
    )
    (tmp_path / "rack.toml").write_text(
        f"name = '{name}'\nprogram = '{name}.py'\nscan_ms = 2\nwatchdog_ms = 0\n"
        "[[slot]]\nnumber = 1\nmodule = '1769-IQ16'\n"
        f"[slot.options]\ninputs = {{ {name} = 0 }}\n",
        encoding="utf-8",
    )
    with watching(tmp_path / "rack.toml", "--record", tmp_path / f"{name}.mcap") as session:
        page.open(session.link)
        page.until_there(".variables .chip")
        page.click(".variables .chip")
        page.watch(f"line.{name}")
        page.control(f"Press {name}").send_keys(ENTER)
        page.until_there(".events button")
        for width in (400, 1600):
            page.look(width, 800)
            until(partial(page.run, "return innerWidth === arguments[0]", width))
            assert page.run(WIDE)[0] <= width


def test_reduced_motion_moves_nothing_by_itself(opened):
    opened.look(1600, 1000, motion="reduce")
    assert opened.run(MOVING) == 0


MARKUP = "<img src=x onerror=alert(1)><script>alert(2)</script>&amp;"


def test_markup_in_names_and_comments_is_text(page, tmp_path):
    folder = tmp_path / "<b>bold"
    folder.mkdir()
    (folder / "<i>.rung").write_text(
        f"PROGRAM Line\nTAG Go : BOOL\nTAG Text : STRING := {json.dumps(MARKUP)}\n"
        f"ROUTINE Main\n// {MARKUP}\nXIC(Go)CMP(1<2)OTE(Go);\nEND\n",
        encoding="utf-8",
    )
    (folder / "rack.toml").write_text(
        f"name = '{MARKUP}'\nprogram = '<i>.rung'\nscan_ms = 2\nwatchdog_ms = 0\n"
        "[[slot]]\nnumber = 1\nmodule = '1769-IQ16'\n"
        "[slot.options]\ninputs = { go = 0 }\n",
        encoding="utf-8",
    )
    with watching(folder / "rack.toml") as session:
        page.open(session.link)
        page.until_there("svg.rung text")
        assert page.run("return document.querySelectorAll('img, script:not([src]), b').length") == 0
        assert text(page, ".comment") == MARKUP
        assert text(page, ".rack") == MARKUP
        assert MARKUP in page.run("return document.title")
        page.watch("Text")
        until(lambda: page.value("Text") == MARKUP)
        assert page.messages() == []
