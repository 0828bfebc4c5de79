"""The page of a program in Python: values at their lines, the line that waits or ran, breakpoints, causes.

Broken on purpose: no values of `self`, a trace of another file, no numbers at lines of causes: red.
"""

import pytest
from scanrack.commands import build
from selenium.webdriver import ActionChains
from typer.testing import CliRunner
from watched_page import until, watching

RACK = """
name = "small"
program = "small.py"
scan_ms = 2
watchdog_ms = 0
[[slot]]
number = 1
module = "1769-IQ16"
[slot.options]
inputs = { go = 0 }
"""
FUNCTION = """\
class State:
    step: int = 0
    rounds: int = 0


state = State()


def logic(scan):
    state.step += 1
    if state.step == 300:
        state.rounds += 1
"""
SEQUENCE = """\
from scanrack import Input, Logic, sequence


class Small(Logic):
    go = Input("go")
    rounds = 7

    @sequence
    async def cycle(self) -> None:
        while True:
            await self.go.rises
            self.rounds += 1
"""
STEPS = """\
words 843Eh 003Fh 1 until MODE_CONFIG -CONFIG_ERROR
zero until -MODE_CONFIG
PRESET_POSITION until -POSITION_INVALID
zero for 400 ms
zero
"""
BESIDE = """
const line = document.querySelector(`[data-at='small.py.${arguments[0]}']`);
return [...line.querySelectorAll(".chip")].map(each => each.textContent);
"""
MARKED = "return [...document.querySelectorAll(\".code-line[data-power='1']\")].map(each => each.dataset.at)"
RAN = "return [...document.querySelectorAll('.code-line[data-ran]')].map(each => each.dataset.at)"
CLIPPED = """
return [...document.querySelectorAll(".chip > span")]
  .filter(each => each.scrollHeight > each.clientHeight + 1).map(each => each.textContent);
"""  # an underscore that is cut looks like a space
CAUSES = "return [...document.querySelectorAll('.code-line[data-cause]')].map(each => each.dataset.at)"


@pytest.fixture
def rack(tmp_path):
    """Makes a rack file with a program beside it."""

    def make(program):
        (tmp_path / "small.py").write_text(program, encoding="utf-8")
        (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
        return tmp_path / "rack.toml"

    return make


@pytest.fixture
def steps(tmp_path):
    """A rack file with a list of steps beside it."""
    (tmp_path / "small.steps").write_text(STEPS, encoding="utf-8")
    text = RACK.replace("small.py", "small.steps").replace("1769-IQ16", "amci3601").partition("[slot.op")[0]
    (tmp_path / "rack.toml").write_text(text, encoding="utf-8")
    return tmp_path / "rack.toml"


def break_at(page, line):
    page.run("document.querySelector(`[data-at='small.py.${arguments[0]}'] .stop`).click()", line)
    page.until_there(f"[data-at='small.py.{line}'][data-breakpoint]")


def test_a_function_has_values_at_its_lines_breakpoints_and_causes(page, rack):
    with watching(rack(FUNCTION), "--paused", "--time-scale", "max") as session:
        page.open_at(session, 100)
        until(lambda: page.run(BESIDE, 10) == ["step100"])
        assert page.run(BESIDE, 12) == ["rounds0"]
        assert page.run(BESIDE, 1) == []
        assert page.run(CLIPPED) == []
        break_at(page, 12)
        page.press("Continue")
        page.until_scan(299, "paused")
        until(lambda: page.run(MARKED) == ["small.py.12"])
        assert "small.py line 12 has run" in page.run("return document.getElementById('notice').textContent")
        until(lambda: page.run(RAN) == ["small.py.10", "small.py.11", "small.py.12"])
        until(lambda: page.run(BESIDE, 12) == ["rounds1"])
        page.run("document.querySelector(\"[data-at='small.py.12'] .chip\").click()")
        page.press("Why")
        until(lambda: "small.py.12" in page.run(CAUSES))
        page.run("document.querySelector(\"[data-at='small.py.1'] .stop\").click()")
        until(
            lambda: "nothing runs there" in page.run("return document.getElementById('notice').textContent")
        )


def test_a_sequence_shows_the_line_that_waits_and_stops_at_one(page, rack):
    with watching(rack(SEQUENCE), "--paused", "--time-scale", "max") as session:
        page.open_at(session, 50)
        until(lambda: page.run(MARKED) == ["small.py.11"])
        assert page.run(BESIDE, 12) == ["rounds7"]
        break_at(page, 12)
        page.press("Press go")
        page.press("Continue")
        until(lambda: page.run(MARKED) == ["small.py.11", "small.py.12"])
        assert page.handle("state") == "paused"
        until(lambda: page.run(BESIDE, 12) == ["rounds8"])


BRANCHES = """\
class State:
    step = 0


state = State()


def logic(scan):
    state.step += 1
    if state.step % 2:
        return
    for _ in range(2):
        state.step += 10
"""


def test_a_function_shows_the_lines_that_ran_in_the_scan_shown_without_a_breakpoint(page, rack):
    """By hand: the step is 1, 22, 23, 44 and so on; the loop runs in odd scans."""
    with watching(rack(BRANCHES), "--paused", "--time-scale", "max") as session:
        page.open_at(session, 100)
        until(lambda: page.run(RAN) == [f"small.py.{line}" for line in (9, 10, 12, 13)])
        page.step(1)
        until(lambda: page.run(RAN) == [f"small.py.{line}" for line in (9, 10, 11)])
        page.press("Continue")
        until(lambda: page.run(RAN) == [])
        says = "return document.querySelector('.sheet p[role=status]').textContent"
        assert page.run(says) == "Pause, or go back, to see the lines that ran in a scan."


def test_lines_that_ran_in_a_recording_are_there_at_once_around_a_scan(page, rack, tmp_path):
    trace = tmp_path / "run.mcap"
    words = ["run", str(rack(BRANCHES)), "--record", str(trace), "--scans", "4000"]
    assert CliRunner().invoke(build(), words).exit_code == 0
    with watching(f"{trace}#scan=3001", "--trust") as session:
        page.open(session.link)
        until(lambda: page.run(RAN) == [f"small.py.{line}" for line in (9, 10, 12, 13)])
        page.run("document.activeElement.blur()")
        ActionChains(page.browser).send_keys(",").perform()
        until(lambda: page.handle("scan") == "3000")
        until(lambda: page.run(RAN) == [f"small.py.{line}" for line in (9, 10, 11)])


def test_a_value_that_changes_is_a_breakpoint(page, rack):
    with watching(rack(FUNCTION), "--paused", "--time-scale", "max") as session:
        page.open_at(session, 100)
        page.run("document.querySelector(\"[data-at='small.py.12'] .chip\").click()")
        page.press("Breakpoint")
        page.press("Continue")
        page.until_scan(299, "paused")
        until(
            lambda: (
                "state.rounds was 0 and is 1"
                in page.run("return document.getElementById('notice').textContent")
            )
        )


def test_a_list_of_steps_shows_the_step_that_runs_what_ends_it_and_stops_at_one(page, steps):
    with watching(steps, "--paused", "--time-scale", "max") as session:
        page.open_at(session, 100)
        until(lambda: page.run(MARKED) == ["small.steps.4"])
        waits = page.run("return document.querySelector('.waits').textContent")
        assert waits == "program waits at line 4 for 400 ms since 00:00.006zero for 400 ms"
        page.run("document.querySelector(\"[data-at='small.steps.5'] .stop\").click()")
        page.until_there("[data-at='small.steps.5'][data-breakpoint]")
        page.press("Continue")
        until(lambda: page.run(MARKED) == ["small.steps.5"])
        assert page.handle("state") == "paused"
