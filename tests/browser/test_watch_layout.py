"""Where the parts are: the program first, gutters that are kept, lists as tabs, the tag a narrow sheet.

Broken on purpose: `held` of scrub.js never set, the strip of a telephone not sticky, tabs of 26 px: red.
"""

from functools import partial

import pytest
from selenium.webdriver.common.action_chains import ActionChains
from watched_page import until, watching

LEFT, RIGHT, UP, DOWN = "\ue012", "\ue014", "\ue013", "\ue015"
BOX = """
const { left, top, right, bottom } = document.querySelector(arguments[0]).getBoundingClientRect();
return [left, top, right, bottom];
"""
WHOLE_RUNGS = """
const { bottom } = document.getElementById("program").getBoundingClientRect();
const { bottom: top } = document.querySelector("#program h2").getBoundingClientRect();
const rungs = [...document.querySelectorAll(".rungs .row")].map(each => each.getBoundingClientRect());
return rungs.filter(each => each.top >= top && each.bottom <= bottom).length;
"""


def wide(page, selector):
    left, _, right, _ = page.run(BOX, selector)
    return right - left


def test_the_program_has_three_fifths_and_a_gutter_is_kept(page, paused):
    page.look(1400, 900)
    page.open(paused.link, paused=True)
    page.until_there("svg.rung")
    page.until_drawn()
    first = wide(page, "#program")
    assert first >= 0.6 * 1400
    assert page.run(WHOLE_RUNGS) >= 3
    page.browser.find_element("id", "program-gutter").send_keys(LEFT)
    until(lambda: wide(page, "#program") < first)
    high = page.run(BOX, "#strip")[1]
    page.browser.find_element("id", "strip-gutter").send_keys(UP)
    until(lambda: page.run(BOX, "#strip")[1] < high)
    page.control("Events").send_keys(RIGHT)
    kept = wide(page, "#program")
    page.open(paused.link, paused=True)
    until(lambda: wide(page, "#program") == kept)
    assert page.run("return document.getElementById('events').hidden")
    assert not page.run("return document.getElementById('watch').hidden")


AXIS = """
const { bottom } = document.querySelector("canvas.axis").getBoundingClientRect();
return document.getElementById("strip").getBoundingClientRect().bottom - bottom;
"""
SPY = """
window.rows = [];
const pen = CanvasRenderingContext2D.prototype, { fillText, clearRect } = pen;
pen.clearRect = function (...box) {
  if (this.canvas.matches(".chart")) rows = [];
  clearRect.apply(this, box);
};
pen.fillText = function (text, ...at) {
  if (text.startsWith("1.")) rows.push([text, at[1]]);
  fillText.call(this, text, ...at);
};
"""
ROWS = "return rows.map(([name]) => name)"
COMPUTED = "Power and values of this scan are being computed."
FOLD = "const fold = document.querySelector('.fold'); return fold.checkVisibility() ? fold.textContent : ''"


def test_at_720_pixels_three_rungs_and_the_time_axis_are_in_view_with_the_causes_open(page, paused):
    page.look(1280, 720)
    page.open(paused.link, paused=True)
    page.step(4300)  # the emergency stop comes at 8 s, in the middle of a stroke
    page.until_scan(4299, "paused")
    until(lambda: "IN_ESTOP" in page.run("return document.querySelector('.first').textContent"))
    page.click(".alert button")
    page.until_there("#causes li")
    page.until_drawn()
    until(lambda: page.run(WHOLE_RUNGS) >= 2)  # about the rung that reads the emergency stop
    page.run("document.getElementById('program').scrollTop = 0")
    until(lambda: page.run(WHOLE_RUNGS) >= 3)
    assert abs(page.run(AXIS)) <= 1
    page.run(SPY)
    page.press("Zoom out")
    page.press("Zoom in")
    tops = until(lambda: page.run("return rows.map(([, top]) => top)"))
    seen = page.run(BOX, "canvas.axis")[1] - page.run(BOX, "canvas.chart")[1]
    assert sum(top < seen for top in tops) >= 5  # the position, and four lanes
    for _ in range(4):
        page.press("Zoom in")  # 0.2 s: the axis stands, and nothing moves
    until(lambda: page.run(FOLD).startswith("▸ "))
    folded = page.run(ROWS)
    page.run("document.querySelector('.fold').click()")
    empty = int(page.run(FOLD).removeprefix("▾ ").split()[0])
    assert (len(page.run(ROWS)), empty) == (len(folded) + empty, empty)
    assert "1.MOVING_CW" not in folded
    assert "1.MOVING_CW" in page.run(ROWS)


def test_at_720_pixels_all_slots_of_a_small_rack_are_in_view(page):
    with watching("examples/three_stations_panel/line.toml", "--paused", "--time-scale", "max") as session:
        page.look(1280, 720)
        page.open_at(session, 10)
        hidden = "const all = document.getElementById('machine'); return all.scrollHeight - all.clientHeight"
        until(lambda: page.run(hidden) <= 0)


def test_the_sentence_above_pale_rungs_is_one_line_on_a_telephone(page, paused):
    page.look(400, 800)
    page.open(paused.link, paused=True)
    page.until_there(".unknown")
    page.run("document.querySelector('.unknown').textContent = arguments[0]", COMPUTED)
    node = "document.querySelector('.unknown')"
    assert page.run(f"return {node}.scrollHeight <= {node}.clientHeight")


def test_a_small_program_leaves_its_room_to_the_strip_and_the_lists(page):
    with watching("examples/first/rack.toml", "--paused", "--time-scale", "max") as session:
        page.open(session.link, paused=True)
        page.until_drawn()
        until(lambda: page.run(BOX, "#strip")[1] < 0.4 * 1000)
        assert (
            page.run(BOX, "#program")[3] - page.run(BOX, ".rungs")[3] < 40
        )  # no empty room beneath the rungs
        assert page.run(BOX, "aside")[3] == page.run(BOX, "#strip")[3]
        first = page.run(BOX, "#strip")[1]
        gutter = page.browser.find_element("id", "strip-gutter")
        gutter.send_keys(DOWN)  # from now on as the viewer sets it
        until(lambda: first < page.run(BOX, "#strip")[1] < first + 50)
        ActionChains(page.browser).double_click(gutter).perform()
        until(lambda: page.run(BOX, "#strip")[1] == first)


HALVES = """
const answer = document.querySelector("#tag .answer").getBoundingClientRect().top;
const rows = [...document.querySelectorAll("#tag :is(button, input, .since)")];
const others = rows.filter(each => !each.closest(".answer"));
const boxes = others.map(each => [each.textContent, each.getBoundingClientRect()]);
return boxes.filter(([, { top, bottom }]) => top < answer && bottom > answer).map(([text]) => text);
"""
UNCOVERED = """
const node = document.querySelector(`#tag ${arguments[0]}`);
const { left, top, width, height } = node.getBoundingClientRect();
return [3, height - 3].every(each => document.elementFromPoint(left + width / 2, top + each) === node);
"""
"""Whether nothing covers a control of the card."""


@pytest.mark.parametrize(("wide", "high"), [(1280, 720), (400, 800)])
def test_a_long_answer_stands_beneath_the_name_and_no_row_of_buttons_is_cut(page, paused, wide, high):
    page.look(wide, high)
    page.open_at(paused, 4100)
    page.run(
        "document.querySelector('[data-element=\"Main.7.4\"]')"
        ".dispatchEvent(new MouseEvent('click', { bubbles: true }))"
    )
    page.press("Why")
    page.until_there("#tag .chain li")
    name, answer = page.run(BOX, "#tag .name"), page.run(BOX, "#tag .answer")
    assert page.run(BOX, "#tag")[1] <= name[1] < name[3] <= answer[1] < page.run(BOX, "#tag")[1] + 90
    assert page.run(HALVES) == []
    page.run("arguments[0].focus()", page.control("What would it take"))
    until(lambda: page.run(UNCOVERED, "[aria-label='What would it take']"))
    page.run("arguments[0].focus()", page.control("Write"))
    until(lambda: page.run(UNCOVERED, "[aria-label='Write']"))


def test_on_a_telephone_the_buttons_of_an_edit_are_whole(page, paused):
    page.look(400, 800)
    page.open_at(paused, 10)
    page.press("Edit")
    page.until_there(".caret input")
    page.control("Instruction, such as XIC Start").send_keys("XIO Trouble", "\ue007")
    until(lambda: page.control("Accept edits").is_enabled())
    ends = "[...document.querySelectorAll('.rungbar button')].map(each => each.getBoundingClientRect().right)"
    assert max(page.run(f"return {ends}")) <= page.run(BOX, ".rungbar")[2]


def test_the_tag_is_a_sheet_in_view_on_a_telephone(page, paused):
    page.look(400, 860)
    page.open(paused.link, paused=True)
    page.until_there("svg.rung .instruction")
    page.until_drawn()
    assert page.run("return document.getElementById('bar').offsetHeight") <= 110
    for place in (0, -1):
        page.run(
            "const found = [...document.querySelectorAll('#program .instruction')].at(arguments[0]);"
            "found.scrollIntoView({ block: 'end' });"
            "found.dispatchEvent(new MouseEvent('click', { bubbles: true }))",
            place,
        )
        page.until_there("#tag[data-selected]")
        left, top, right, bottom = page.run(BOX, "#tag")
        assert (left, right) == (0, page.run("return document.documentElement.clientWidth"))
        assert 0 < top < bottom <= 860
        assert page.run(BOX, ".row[aria-current]")[3] <= top  # the rung is above it


SMALL = """
const seen = [...document.querySelectorAll("button:not(.plain, .bit, .fold), select, summary, .stops")];
const boxes = seen.filter(each => each.checkVisibility({ visibilityProperty: true }))
  .map(each => [each.getAttribute("aria-label") ?? each.textContent, each.getBoundingClientRect()]);
return boxes.filter(([, { width, height }]) => width < 40 || height < 40).map(([name]) => name);
"""
"""Gives what is too small for a finger."""


def test_on_a_telephone_time_is_in_view_and_nothing_is_too_small_for_a_finger(page, paused):
    page.look(400, 800)
    page.open_at(paused, 3000)
    for name in ("More controls", "Breakpoint on rung 0"):
        page.press(name)
    page.run("scrollTo(0, 0)")
    assert page.run(SMALL) == []
    _, top, _, bottom = page.run(BOX, "canvas.axis")
    assert 400 < top < bottom <= 800
    assert page.run(BOX, ".rungs .row")[3] < top  # beneath the first rung


def touch(page, kind, *points):
    given = {"type": kind, "touchPoints": [{"x": x, "y": y} for x, y in points]}
    page.browser.execute_cdp_cmd("Input.dispatchTouchEvent", given)


def test_a_finger_drags_the_slider_back(page, paused):
    page.look(400, 800)
    page.open_at(paused, 3000)
    left, top, right, bottom = page.run(BOX, "[aria-label='Scan shown']")
    middle = (top + bottom) / 2
    touch(page, "touchStart", (right - 8, middle))
    page.run(
        "window.scans = []; new MutationObserver(() => scans.push(document.documentElement.dataset.scan))"
        ".observe(document.documentElement, { attributeFilter: ['data-scan'] })"
    )
    for part in (0.8, 0.6, 0.4, 0.2):
        seen = page.run("return scans.length")
        touch(page, "touchMove", (left + part * (right - left), middle))
        # a frame came, and left it where it is
        until(partial(page.run, "return scans.length > arguments[0]", seen))
    touch(page, "touchEnd")
    page.until_handle("state", "past")
    assert 300 < int(page.handle("scan")) < 900  # about a fifth of 3,000
