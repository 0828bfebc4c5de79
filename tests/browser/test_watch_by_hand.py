"""What surprised in twelve tasks that were done by hand, with the mouse, with keys alone, and in Firefox.

Each was red on the page before it was repaired: `git log` of this file names the surprises.
"""

import re

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from watched_page import until, watching

FOCUS = "const on = document.activeElement; return on.getAttribute('aria-label') ?? on.textContent"
TOP = "return document.querySelector(arguments[0]).getBoundingClientRect().top"
TEXT = "return document.querySelector(arguments[0])?.textContent ?? ''"
PAINTED_TEXTS = """
window.painted = [];
const pen = CanvasRenderingContext2D.prototype, { fillText } = pen;
pen.fillText = function (...all) { painted.push(all[0]); return fillText.apply(this, all); };
"""
POSITION = "return document.querySelector('[data-name=\"1.position\"]').dataset.value"
LATER_VALUES = """
window.seen = [];
const value = document.querySelector("#tag output"), since = document.querySelector("#tag .since");
new MutationObserver(() => seen.push([since.textContent, getComputedStyle(since).visibility]))
  .observe(value, { attributes: true, attributeFilter: ["data-value"] });
"""


def type_keys(page, *keys):
    """Type to what has the focus."""
    ActionChains(page.browser).send_keys(*keys).perform()


def test_keys_alone_reach_an_input_of_the_machine_in_ten_presses(page, paused):
    page.open_at(paused, 10)
    type_keys(page, *[Keys.F6] * 3)
    for _ in range(7):
        if page.run(FOCUS) == "Press E-stop":
            break
        type_keys(page, Keys.TAB)
    assert page.run(FOCUS) == "Press E-stop"
    ActionChains(page.browser).key_down(Keys.SHIFT).send_keys(Keys.F6).key_up(Keys.SHIFT).perform()
    assert page.run("return document.activeElement.closest('#program') !== null")


def test_all_rungs_are_one_stop_of_tab_and_arrows_lead_through_them(page, paused):
    page.open_at(paused, 10)
    stops = (
        "return [...document.querySelectorAll('.rungs [tabindex]')].filter(each => each.tabIndex >= 0).length"
    )
    assert page.run(stops) == 1
    page.run("document.querySelector('[data-element=\"Main.2.0\"]').focus()")
    type_keys(page, Keys.ARROW_DOWN)
    place = "return document.activeElement.dataset.element"
    until(lambda: page.run(place) == "Main.3.0")
    type_keys(page, Keys.ARROW_RIGHT)
    assert page.run(place) == "Main.3.1"
    assert page.run(stops) == 1


def test_letters_beside_the_caret_are_typed_and_give_no_order(page, paused):
    page.open_at(paused, 10)
    page.press("Edit")
    page.until_there(".caret input")
    page.click("[data-at='Main.5'] .comment")
    type_keys(page, "XIO Trouble", Keys.ENTER)
    until(lambda: "XIO(Trouble)" in page.run("return document.querySelector('.rungtext')?.value ?? ''"))
    assert page.handle("state") == "paused"
    assert page.handle("scan") == "9"
    assert page.run(TEXT, "#notice") == ""


def test_rungs_stay_where_they_are_while_an_edit_is_accepted_and_tested(page, paused):
    page.look(1280, 800)
    page.open_at(paused, 10)
    page.press("Edit")
    page.until_there(".caret input")
    before = page.run(TOP, "#program .row")
    type_keys(page, "XIO Trouble", Keys.ENTER)
    until(lambda: page.control("Accept edits").is_enabled())
    assert page.run(TOP, "#program .row") == before
    page.press("Accept edits")
    until(lambda: page.control("Test edits").is_enabled())
    assert page.run(TOP, "#program .row") == before
    page.press("Test edits")
    until(lambda: "Tested" in page.run(TEXT, ".verdict"))
    until(lambda: page.run("return document.querySelectorAll('.row.draft').length") == 0)
    assert page.run(TOP, "#program .row") == before
    assert page.run("return document.querySelector('[aria-label=Edit][title=\"Edit the program\"]').hidden")
    unknown = "return document.querySelector('.unknown').textContent"
    assert page.run(unknown) == "Power and values come with the next scan."
    page.press("Step")
    until(lambda: "edited at 00:00.018, " in page.run(TEXT, "#events"))


def test_the_slider_shows_where_keys_have_gone_and_beyond_the_last_scan_is_the_present(page, paused):
    page.open_at(paused, 2000)
    page.click("input[type=range]")
    until(lambda: page.handle("state") == "past")
    page.run("document.querySelector('input[type=range]').focus()")
    type_keys(page, "[")
    until(lambda: page.run("return Number(document.querySelector('input[type=range]').value)") < 700)
    scan = "return document.querySelector('input[type=range]').value"
    until(lambda: page.handle("scan") == page.run(scan))
    type_keys(page, "]]]]")
    page.until_scan(1999, "paused")


def test_a_page_that_is_loaded_again_has_the_strip_of_before(page, paused):
    page.open_at(paused, 4000)  # more than the monitor sends of itself
    page.open(paused.link)
    page.press("Zoom out")
    page.click("//details[summary='Edges']/summary", "xpath")
    oldest = "return Number([...document.querySelectorAll('.edges li')].at(-1)?.dataset.scan ?? 9999)"
    page.choose("Signal", "1.MOVING_CW")
    until(lambda: page.run(oldest) < 1000)


def test_a_refused_question_stays_at_its_place(page, paused):
    page.open(paused.link, paused=True)
    page.click("[data-element='Main.7.4']")
    page.control("New value").send_keys("1")
    page.press("What would it take")
    until(lambda: page.run(TEXT, "#tag .refused") == "Feeding: no scan has run yet.")
    assert page.run(TEXT, "#notice") == ""


def test_what_it_would_take_says_for_which_value(page, paused):
    page.open_at(paused, 1500)
    page.click("[data-element='Main.7.4']")
    page.press("What would it take")
    until(lambda: page.run(TEXT, "#tag .answer p") == "For Feeding 0 after scan 1,499:")


def test_a_time_is_a_clock_in_the_causes_as_elsewhere(page, paused):
    page.open_at(paused, 1500)
    page.click("[data-element='Main.7.0']")  # Configure.Done
    page.press("Why")
    page.until_there("#tag .chain li")
    page.click(".alert button")
    until(lambda: "00:00.0" in page.run(TEXT, "#causes"))
    assert not re.search(r"\d s[,)]", page.run(TEXT, "#causes"))


def test_since_when_is_not_that_of_another_value(page, paused):
    page.open_at(paused, 900)
    page.click("[data-element='Main.2.1']")  # OTE(Trouble)
    until(lambda: page.run(TEXT, "#tag .since"))
    page.run(LATER_VALUES)
    page.press("Force")
    page.press("Step")
    until(lambda: page.run("return seen.length"))
    until(lambda: page.run(TEXT, "#tag .since").startswith("Since 00:01.8"))
    old = [visibility for text, visibility in page.run("return seen") if "00:01.8" not in text]
    assert set(old) <= {"hidden"}


def test_an_error_that_is_over_is_no_longer_red(page, feeder_rack):
    with watching(feeder_rack, "--paused", "--time-scale", "max") as session:
        page.open(session.link, paused=True)
        page.step(4100)  # its emergency stop comes at 8 s
        until(lambda: "INPUT_ERROR came on" in page.run(TEXT, ".band"))
        page.step(900)  # the program has reset the error
        until(lambda: "INPUT_ERROR was on" in page.run(TEXT, ".band"))
        assert page.run("return document.querySelector('.band').dataset.kind") == "over"


def test_lines_of_a_scale_are_at_round_numbers(page, paused):
    page.open_at(paused, 1500)
    page.press("Plot lanes")
    page.run(PAINTED_TEXTS)
    page.choose("Second lane", "1.MOVING_CW")
    painted = page.run("return painted")
    assert {"0", "1"} <= set(painted)
    assert "0.25" not in painted
    numbers = [int(each.replace(",", "")) for each in painted if re.fullmatch(r"-?[\d,]+", each)]
    assert numbers
    assert all(each in (0, 1) or each % 100 == 0 for each in numbers)
    type_keys(page, Keys.ESCAPE)


def test_values_beside_long_lines_are_whole(page):
    with watching("examples/three_stations/line.toml", "--paused", "--time-scale", "max") as session:
        page.look(1280, 800)
        page.open(session.link, paused=True)
        page.step(10)
        page.until_scan(9, "paused")
        page.until_there(".beside .chip")
        end = "getBoundingClientRect().right"
        cut = f"filter(each => each.lastChild.{end} > each.{end}).length"
        assert page.run(f"return [...document.querySelectorAll('.beside .chip')].{cut}") == 0


def test_the_field_of_the_watch_table_stays_above_its_rows(page, paused):
    page.open_at(paused, 10)
    page.watch("Home")
    page.until_there("#watch tr.tag")
    assert page.run(TOP, "#watch input") < page.run(TOP, "#watch tr.tag")


def test_a_passing_notice_is_not_in_the_way_of_the_strip(page, paused):
    page.open_at(paused, 10)
    type_keys(page, "e")  # marks are of recordings
    until(lambda: page.run(TEXT, "#notice"))
    under = (
        "const { left, right, top, bottom } = document.getElementById('notice').getBoundingClientRect();"
        "return document.elementFromPoint((left + right) / 2, (top + bottom) / 2).id"
    )
    assert page.run(under) != "notice"


def test_beside_a_selected_tag_with_its_causes_the_inputs_are_in_view(page, paused):
    page.look(1920, 1080)
    page.open_at(paused, 4100)
    page.click("[data-element='Main.2.1']")  # OTE(Trouble)
    page.press("Why")
    page.until_there("#tag .chain li")
    button, machine = (
        page.run(f"return document.querySelector('{each}').getBoundingClientRect().bottom")
        for each in ('[aria-label="Press E-stop"]', "#machine")
    )
    assert button <= machine


def test_an_event_stands_after_its_cause_of_the_same_time(page, paused):
    page.open_at(paused, 4100)  # its emergency stop comes at 8 s
    rows = "return [...document.querySelectorAll('#events .what')].map(each => each.textContent)"
    until(lambda: any("energized" in each for each in page.run(rows)))
    latest_first = page.run(rows)
    (cause,) = [place for place, each in enumerate(latest_first) if "is energized" in each]
    (effect,) = [place for place, each in enumerate(latest_first) if "cut short" in each]
    assert effect < cause


def test_find_replaces_what_was_typed_before_and_arrows_lead_through_its_hits(page, paused):
    page.open_at(paused, 10)
    type_keys(page, "/", "Feeding")
    until(lambda: page.run("return document.querySelectorAll('.hits button').length") > 2)
    type_keys(page, Keys.ARROW_DOWN, Keys.ARROW_DOWN, Keys.ARROW_DOWN, Keys.ARROW_UP)
    assert page.run(FOCUS).startswith("Main.7")
    type_keys(page, Keys.ENTER)
    until(lambda: page.run("return document.querySelector('.row[aria-current]')?.dataset.at") == "Main.7")
    type_keys(page, "/", "Quiet.PRE", Keys.ENTER)
    until(lambda: page.run(TEXT, "#tag .name") == "Quiet.PRE")


def test_escape_leaves_a_field_before_it_clears_the_selection(page, paused):
    page.open_at(paused, 10)
    page.click("[data-element='Main.7.4']")
    page.control("New value").send_keys("1", Keys.ESCAPE)
    assert page.run("return document.activeElement === document.body")
    type_keys(page, Keys.ESCAPE)
    until(lambda: page.run("return !document.querySelector('#tag').checkVisibility()"))


def test_the_buttons_of_an_edit_are_a_key_away_from_the_caret(page, paused):
    page.open_at(paused, 10)
    page.press("Edit")
    page.until_there(".caret input")
    type_keys(page, "XIO Trouble", Keys.ENTER)
    until(lambda: page.control("Accept edits").is_enabled())
    ActionChains(page.browser).key_down(Keys.SHIFT).send_keys(Keys.F6).key_up(Keys.SHIFT).perform()
    assert page.run(FOCUS) == "Accept edits"
    type_keys(page, Keys.ENTER)
    until(lambda: page.control("Test edits").is_enabled())
    assert page.run(FOCUS) == "Test edits"
    type_keys(page, Keys.ENTER)
    until(lambda: "Tested" in page.run(TEXT, ".verdict"))


def test_keys_of_the_page_zoom_the_strip(page, paused):
    page.open_at(paused, 10)
    span = "return document.querySelector('#strip .tools output:not(.between)').textContent"
    type_keys(page, "+", "+")
    assert page.run(span) == "1 s"
    type_keys(page, "-")
    assert page.run(span) == "2 s"


def test_a_plot_has_the_values_of_the_scan_shown_without_a_pointer(page, paused):
    page.open_at(paused, 1500)
    page.press("Plot lanes")
    position = f"{int(page.run(POSITION)):,}"
    until(lambda: page.run(TEXT, "dialog[open] output") == f"00:02.998  1.position {position}")
    type_keys(page, Keys.ESCAPE)


def test_keys_break_at_the_line_at_which_a_sequence_waits(page):
    with watching("examples/sequences/labeller.toml", "--paused", "--time-scale", "max") as session:
        page.open_at(session, 500)
        waits = page.run("return document.querySelector('.code-line[data-power=\"1\"]').dataset.at")
        type_keys(page, Keys.ARROW_DOWN)
        until(lambda: page.run("return document.querySelector('[aria-current=true]')?.dataset.at") == waits)
        type_keys(page, "b")
        page.until_there(f"[data-at='{waits}'][data-breakpoint]")
        type_keys(page, "/", "self.labels", Keys.ENTER)  # its text is found as well
        until(lambda: "self.labels" in page.run(TEXT, ".code-line[aria-current]"))
