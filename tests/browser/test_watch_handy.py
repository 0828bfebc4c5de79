"""Where the hand goes: nothing hides, jumps or vanishes by what is selected, forced or typed.

Broken on purpose: the machine hidden beside a tag, rules over the words, the bar as high as its button,
members of the watch table closed: red.
"""

import pytest
from contrast import contrast
from watched_page import until

BOX = """
const { left, top, right, bottom } = document.querySelector(arguments[0]).getBoundingClientRect();
return [left, top, right, bottom];
"""
AT_POINT = """
const node = document.querySelector(arguments[0]);
const { left, top, right, bottom } = node.getBoundingClientRect();
const met = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
return node.contains(met);
"""
ESTOP = "#machine [aria-label='Press E-stop']"
TEXT = "return document.querySelector(arguments[0])?.innerText ?? ''"
EDGES = """
const hex = part => Math.round(part).toString(16).padStart(2, "0");
const rgb = color => "#" + color.match(/\\d+(\\.\\d+)?/g).slice(0, 3).map(hex).join("");
const ground = node => {
  for (; node; node = node.parentElement) {
    const { backgroundColor } = getComputedStyle(node);
    if (!backgroundColor.endsWith(", 0)")) return rgb(backgroundColor);
  }
};
const controls = document.querySelectorAll("button:not([role=tab]), select, input");
const seen = [...controls].filter(each => each.checkVisibility());
return seen.map(each => {
  const style = getComputedStyle(each), name = each.getAttribute("aria-label") ?? each.textContent;
  const framed = parseFloat(style.borderTopWidth) > 0 && !style.borderTopColor.endsWith(", 0)");
  const edge = framed ? rgb(style.borderTopColor) : "";
  return [name, edge, rgb(style.color), ground(each), ground(each.parentElement), each.disabled];
});
"""


def high(page, selector):
    _, top, _, bottom = page.run(BOX, selector)
    return bottom - top


def test_a_selected_tag_leaves_the_machine_and_its_emergency_stop(page, paused):
    page.look(1280, 720)
    page.open_at(paused, 2000)
    page.click("[data-element='Main.2.1']")
    page.until_there("#tag[data-selected]")
    page.until_drawn()
    until(lambda: page.run(AT_POINT, ESTOP))
    page.press("Press E-stop")
    page.step(1)
    page.until_value("1.input.estop", "1")


def test_rules_leave_the_last_rows_of_the_words(page, paused):
    page.look(1280, 720)
    page.open_at(paused, 4200)
    page.panel("words")
    page.until_there("#rules:not([hidden])")
    page.run("document.getElementById('words').scrollTop = 1e6")
    assert page.run(BOX, "#words")[3] <= page.run(BOX, "#rules")[1]
    until(lambda: page.run(AT_POINT, "#words > :last-child .raw summary"))


def test_the_line_of_a_failure_has_its_cause_at_two_hundred_percent(page, paused):
    page.look(640, 360)
    page.open_at(paused, 4200)
    until(lambda: "INPUT_ERROR came on" in page.run(TEXT, ".band"))
    until(lambda: "emergency stop" in page.run(TEXT, ".band .first"))
    assert page.run(AT_POINT, ".band .first")


def test_a_force_moves_nothing_and_its_button_says_what_it_removes(page, paused):
    page.look(1280, 720)
    page.open_at(paused, 2000)
    before = page.run(BOX, "#program")
    page.run("return import('/orders.js').then(orders => orders.force('Trouble', true))")
    page.step(1)
    until(lambda: page.run(TEXT, "#bar .readings > button") == "Remove 1 force")
    assert page.run(BOX, "#program") == before
    assert page.control("Remove 1 force").accessible_name == "Remove 1 force"


def test_a_structure_in_the_watch_table_shows_its_members(page, paused):
    page.open_at(paused, 2000)
    page.watch("Quiet")
    until(lambda: "1,000" in page.run(TEXT, "#watch .tree"))
    assert "5 members" in page.run(TEXT, "#watch .value")


def test_underscores_are_in_view(page, paused):
    page.open_at(paused, 100)
    page.panel("words")
    clipped = """
    return [...document.querySelectorAll("#words .bit > span:first-of-type, .chip > span")]
      .filter(each => each.scrollHeight > each.clientHeight + 1).map(each => each.textContent);
    """
    assert page.run(clipped) == []


def test_numbers_and_times_are_written_in_one_way(page, paused):
    page.open_at(paused, 4300)
    page.watch("Quiet.PRE")
    until(lambda: "1,000" in page.run(TEXT, "#watch"))
    page.click("[data-element='Main.7.4']")
    page.press("Why")
    until(lambda: "since 00:08.002" in page.run(TEXT, "#tag .answer"))
    events = page.run(TEXT, ".events")
    assert "6,000" in events
    assert "6000" not in events


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_what_carries_meaning_has_a_contrast_of_three(page, paused, scheme):
    page.look(1280, 720, scheme=scheme)
    page.open_at(paused, 2000)
    weak = []
    for name, edge, ink, own, around, disabled in page.run(EDGES):
        if edge and max(contrast(edge, own), contrast(edge, around)) < 3 and contrast(own, around) < 3:
            weak.append((name, edge, own, around))
        if disabled and contrast(ink, own) < 3:
            weak.append((name, ink, own))
    assert weak == []
