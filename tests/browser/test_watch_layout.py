"""Where the parts are: the program first, gutters that are kept, lists as tabs, the tag a narrow sheet."""

from watched_page import until

LEFT, RIGHT, UP = "\ue012", "\ue014", "\ue013"
BOX = """
const { left, top, right, bottom } = document.querySelector(arguments[0]).getBoundingClientRect();
return [left, top, right, bottom];
"""
WHOLE_RUNGS = """
const { bottom } = document.getElementById("program").getBoundingClientRect();
const rungs = [...document.querySelectorAll(".rungs .row")];
return rungs.filter(each => each.getBoundingClientRect().bottom <= bottom).length;
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


def test_the_tag_is_a_sheet_in_view_on_a_telephone(page, paused):
    page.look(400, 860)
    page.open(paused.link, paused=True)
    page.until_there("svg.rung .instruction")
    page.until_drawn()
    for place in (0, -1):
        page.run(
            "const found = [...document.querySelectorAll('#program .instruction')].at(arguments[0]);"
            "found.scrollIntoView({ block: 'center' });"
            "found.dispatchEvent(new MouseEvent('click', { bubbles: true }))",
            place,
        )
        page.until_there("#tag[data-selected]")
        left, top, right, bottom = page.run(BOX, "#tag")
        assert (left, right) == (0, page.run("return document.documentElement.clientWidth"))
        assert 0 < top < bottom <= 860
