"""An edit is shown before it is taken over: of rungs, structured text and Python; typed here, or saved.

Broken on purpose: a preview that edits, a button that takes over what has mistakes, a Back that saves.
"""

import pytest
from watched_page import until, watching

RACK = """
name = "small"
program = "{}"
scan_ms = 2
watchdog_ms = 0
[[slot]]
number = 1
module = "1769-IQ16"
"""
RUNGS = """\
PROGRAM Line
TAG N : DINT
TAG Fill : TIMER
TAG Go : BOOL
ROUTINE Main
ADD(N,1,N);
XIO(Go)TON(Fill,1000,0);
END
"""
TYPE = """
const field = document.querySelector("textarea");
field.value = arguments[0];
field.dispatchEvent(new Event("input", { bubbles: true }));
"""
GROUPS = """
const titles = [...document.querySelectorAll(".shown dt")];
return titles.map(each => [each.textContent, each.nextSibling.textContent]);
"""
VERDICT = ".shown .verdict"
TEXTS = "return [...document.querySelectorAll(arguments[0])].map(each => each.textContent)"
CHANGED = ".diff [data-sign='+'] code, .diff [data-sign='-'] code"
NOTICE = "return document.getElementById('notice').textContent"


@pytest.fixture
def rack(tmp_path):
    def make(name, program):
        (tmp_path / name).write_text(program, encoding="utf-8")
        (tmp_path / "rack.toml").write_text(RACK.format(name), encoding="utf-8")
        return tmp_path / "rack.toml"

    return make


def edit(page):
    """Open the program's text, behind the picture of rungs; it is there when it has been compared."""
    page.press("Edit")
    until(lambda: page.run("return document.querySelector('.editing:not([hidden])') !== null"))
    if page.run("return document.querySelector('.rungbar:not([hidden])') !== null"):
        page.press("Text")
    until(lambda: page.run(TEXTS, VERDICT) == ["It is the program that runs."])


def typed(page, text, verdict):
    page.run(TYPE, text)
    until(lambda: page.run(TEXTS, VERDICT) == [verdict])


def groups(page):
    """Return the names by title, read at once: some come behind the others."""
    return dict(page.run(GROUPS))


def test_rungs_are_typed_previewed_and_taken_over(page, rack):
    path = rack("line.rung", RUNGS)
    with watching(path) as session:
        page.open(session.link)
        edit(page)
        typed(page, RUNGS.replace("ADD(N", "XIC(Rum)ADD(N"), "A mistake: it can't be taken over.")
        assert page.run(TEXTS, ".note[data-kind='mistake'][data-line='6']")[0].startswith(
            "Line 6 XIC(Rum): no tag Rum"
        )
        assert not page.control("Take over").is_enabled()
        typed(
            page,
            RUNGS.replace("Fill,1000", "Fill,2000").replace("N : DINT", "N : INT"),
            "It can be taken over.",
        )
        assert page.run(TEXTS, CHANGED) == [
            "TAG N : DINT",
            "TAG N : INT",
            "XIO(Go)TON(Fill,1000,0);",
            "XIO(Go)TON(Fill,2000,0);",
        ]
        until(lambda: len(groups(page)) == 4)  # the last two come behind
        assert groups(page) == {
            "Restart, of another type": "N",
            "Keep their value, whatever the text says": "Fill.PRE 1000, not 2000",
            "Outputs that can differ, from power-up on": "none",
            "Other values that can differ, from power-up on": "Fill (ACC, DN, TT), N",
        }
        page.press("Back")
        assert (path.parent / "line.rung").read_text(encoding="utf-8") == RUNGS
        edit(page)
        typed(page, RUNGS.replace("XIO(Go)TON", "XIC(Go)TON"), "It can be taken over.")
        page.press("Take over")
        until(lambda: "3 tags keep their values" in page.run(NOTICE))
        page.until_there("[data-at='Main.1'] [data-power='0']")
        assert "XIC(Go)TON" in (path.parent / "line.rung").read_text(encoding="utf-8")
        assert not page.control("Edit").get_attribute("hidden")


def test_saved_structured_text_waits_for_take_over(page, rack):
    text = "PROGRAM Count\nTAG N : DINT\nROUTINE Main ST\nN := N + 1;\nEND\n"
    path = rack("count.rung", text)
    with watching(path, "--preview") as session:
        page.open(session.link)
        until(lambda: int(page.value("N") or 0) > 10)
        (path.parent / "count.rung").write_text(text.replace("N + 1", "M + 1"), encoding="utf-8")
        until(lambda: page.run(TEXTS, VERDICT) == ["A mistake: it can't be taken over."])
        until(lambda: page.run(TEXTS, ".note[data-line='4']"))
        (path.parent / "count.rung").write_text(text.replace("N + 1", "N - 1"), encoding="utf-8")
        until(lambda: page.run(TEXTS, CHANGED) == ["N := N + 1;", "N := N - 1;"])
        assert int(page.value("N")) > 10
        assert page.run(TEXTS, ".code-line code") == ["N := N+1;"]
        page.press("Take over")
        until(lambda: page.run(TEXTS, ".code-line code") == ["N := N-1;"])
        until(lambda: int(page.value("N")) < 0)


SEQUENCE = """\
from scanrack import Input, Logic, sequence


class Small(Logic):
    go = Input("Local:1:I.Data.0")
    rounds = 7

    @sequence
    async def cycle(self) -> None:
        while True:
            await self.go.rises
            self.rounds += 1
"""


AS_IT_IS = "It can't continue as it is, but with cycle restarted."


def test_python_that_is_typed_says_which_sequence_prevents_it(page, rack):
    path = rack("small.py", SEQUENCE)
    with watching(path, "--trust") as session:
        page.open(session.link)
        until(lambda: page.value("small.rounds") == "7")
        edit(page)
        typed(page, SEQUENCE.replace("rounds = 7", "rounds = 9\n    laps = 0"), "It can be taken over.")
        assert groups(page) == {
            "New": "laps",
            "Keep their value, whatever the text says": "rounds 7, not 9",
            "Continue": "cycle at line 12",
        }
        typed(page, SEQUENCE.replace("go.rises", "go.falls"), AS_IT_IS)
        assert "is no longer at its place" in page.run(TEXTS, "[data-old='11'] + .note")[0]
        page.click("//button[text()='Take over, restart cycle']", "xpath")
        until(lambda: "restart: cycle" in page.run(NOTICE))
        until(lambda: "go falls" in page.run("return document.querySelector('.waits')?.textContent ?? ''"))


def test_python_is_not_typed_without_trust(page, rack):
    with watching(rack("small.py", SEQUENCE)) as session:
        page.open(session.link)
        page.press("Edit")
        until(lambda: "only with --trust" in page.run(NOTICE))
        assert not page.run("return document.querySelector('.editing:not([hidden])') !== null")


def test_a_field_of_a_class_of_logic_is_forced_and_released(page, rack):
    with watching(rack("small.py", SEQUENCE)) as session:
        page.open(session.link)
        until(lambda: page.value("small.rounds") == "7")
        page.click("//button[contains(@class, 'chip')]/span[text()='small.rounds']", "xpath")
        page.control("New value").send_keys("40")
        page.press("Force")
        page.until_there("[data-name='small.rounds'][data-value='40'][data-forced]")
        page.press("Remove force")
        page.until_there("[data-name='small.rounds'][data-value='40']:not([data-forced])")
        until(lambda: page.run(TEXTS, ".since")[0].endswith("before that 7"))


CHART = """\
PROGRAM Press
TAG Start : BOOL
TAG Idle : SFC_STEP
TAG Down : SFC_STEP
TAG Go : BOOL
ROUTINE Main SFC
INITIAL_STEP Idle
END_STEP
STEP Down
END_STEP
TRANSITION Go FROM Idle TO Down
Start
END_TRANSITION
END
"""


STROKE = "return getComputedStyle(document.querySelector(arguments[0]).querySelector('.box')).strokeWidth"


def test_a_chart_lights_its_active_step(page, rack):
    with watching(rack("press.rung", CHART)) as session:
        page.open(session.link)
        lit = "svg.chart .element[data-lit='{}'][data-value='{}']"
        page.until_there(lit.format("Idle.X", 1))
        page.until_there(lit.format("Down.X", 0))
        dark = page.run(STROKE, lit.format("Down.X", 0))
        page.watch("Start")
        page.click("//section[@id='watch']//tbody//button[text()='Start']", "xpath")
        page.until_value("Start", "0")
        page.press("Force")
        page.until_there(lit.format("Down.X", 1))
        page.until_there(lit.format("Idle.X", 0))
        until(lambda: float(page.run(STROKE, lit.format("Down.X", 1))[:-2]) > float(dark[:-2]))
