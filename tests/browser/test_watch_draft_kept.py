"""An edit stays where the hand has left it: behind what is chosen, in view, kept over a reload, one's own.

Broken on purpose: typing in place of what is chosen, the program scrolled to its top by Test, no draft in the
tab's storage, `ours` noted after the answer was reported: red.
"""

from functools import partial

import pytest
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from watched_page import until, watching

RACK = """
name = "small"
program = "line.rung"
scan_ms = 2
watchdog_ms = 0
[[slot]]
number = 1
module = "1769-IQ16"
"""
DRAFTS = "return [...document.querySelectorAll('.draft svg.rung')].map(each => each.ariaLabel)"
CARET = "return document.activeElement.classList.contains('typed')"
VERDICT = "return document.querySelector('.rungbar .verdict')?.textContent ?? ''"
SCROLL = "return document.getElementById('program').scrollTop"
NOTE_VERDICTS = """
const verdict = document.querySelector(".rungbar .verdict");
window.said = [];
new MutationObserver(() => said.push(verdict.textContent)).observe(verdict, { childList: true });
"""


@pytest.fixture
def rack(tmp_path):
    many = "".join(f"XIC(Go)OTE(Lamp{number});\n" for number in range(30))
    tags = "".join(f"TAG Lamp{number} : BOOL\n" for number in range(30))
    text = f"PROGRAM Line\nTAG Go : BOOL\n{tags}ROUTINE Main\n{many}END\n"
    (tmp_path / "line.rung").write_text(text, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    return tmp_path / "rack.toml"


def choose(page, element):
    """Begin to edit at an instruction that is chosen by a click."""
    page.run("document.querySelector(arguments[0]).scrollIntoView({ block: 'center' })", element)
    page.press("Edit")
    until(lambda: page.run(CARET))
    page.click(element)
    until(lambda: page.run(CARET))


def says(page, reported):
    return page.run(VERDICT).startswith(reported)


def type_keys(page, *keys):
    ActionChains(page.browser).send_keys(*keys).perform()


def test_typing_stands_behind_what_is_chosen_and_f2_types_it_again(page, rack):
    with watching(rack) as session:
        page.open(session.link)
        page.until_drawn()
        choose(page, "[data-element='Main.0.0']")
        type_keys(page, "xio Lamp1", Keys.ENTER)
        until(lambda: page.run(DRAFTS) == ["XIC(Go)XIO(Lamp1)OTE(Lamp0);"])
        page.click(".draft [data-element$='.0']")
        until(lambda: page.run(CARET))
        type_keys(page, Keys.F2)
        type_keys(page, "xic Lamp2", Keys.ENTER)
        until(lambda: page.run(DRAFTS) == ["XIC(Lamp2)XIO(Lamp1)OTE(Lamp0);"])
        assert "F2" in page.run("return document.querySelector('.hint').textContent")


def test_steps_of_an_edit_stay_where_they_are_and_it_is_the_pages_own(page, rack):
    page.look(1280, 720)
    with watching(rack) as session:
        page.open(session.link)
        page.until_drawn()
        choose(page, "[data-element='Main.20.0']")
        type_keys(page, "xio Lamp1", Keys.ENTER)
        until(lambda: page.run(VERDICT) == "1 place edited, no mistake.")
        page.run(NOTE_VERDICTS)
        page.run("document.querySelector(\"[aria-label='Accept edits']\").click()")
        until(lambda: page.run(VERDICT).startswith("Accepted"))
        assert not [said for said in page.run("return said") if "not this one" in said or "page 1" in said]
        before = page.run(SCROLL)
        assert before > 300
        for step, reported in (("Test", "Tested"), ("Cancel", "Nothing")):
            page.run("document.querySelector(`[aria-label='${arguments[0]} edits']`).click()", step)
            until(partial(says, page, reported))
            page.until_drawn()
            assert abs(page.run(SCROLL) - before) < 150  # notes of the edit come and go above the rungs


def test_a_draft_outlives_a_reload(page, rack):
    with watching(rack) as session:
        page.open(session.link)
        page.until_drawn()
        choose(page, "[data-element='Main.0.0']")
        type_keys(page, "xio Lamp1", Keys.ENTER)
        until(lambda: page.run(VERDICT) == "1 place edited, no mistake.")
        page.browser.refresh()
        until(lambda: page.run(VERDICT) == "1 place edited, no mistake.")
        assert page.run(DRAFTS) == ["XIC(Go)XIO(Lamp1)OTE(Lamp0);"]
        assert "draft" in page.run("return document.getElementById('notice').textContent")
        page.run("document.querySelector(\"[aria-label='Cancel edits']\").click()")
        until(lambda: page.run(DRAFTS) == [])
        page.browser.refresh()
        page.until_there("svg.rung")
        page.until_drawn()
        assert page.run("return document.querySelector('.rungbar').hidden")
