"""The handles for scripts in docs/watch-socket.md: each is on the page, and the test printed there runs."""

import os
import re
import shutil
from pathlib import Path

import pytest
from watched_page import until, watching

ROOT = Path(__file__).parents[2]
DOCS = (ROOT / "docs" / "watch-socket.md").read_text(encoding="utf-8")
(TABLE,) = re.findall(r"## Handles for scripts.*?(\|.*?\|)\n\n", DOCS, re.DOTALL)
(EXAMPLE,) = re.findall(r"A whole test.*?```python\n(.*?)```", DOCS, re.DOTALL)
(NAMES,) = re.findall(r"\| accessible names \| (.*) \|", TABLE)

HANDLES = sorted(set(re.findall(r"data-[a-z-]+", TABLE)))
CONTROLS = [name.replace("*input*", "E-stop") for name in NAMES.split(", ")]
VALUES = {"Awake": "1", "Axis.State": "2", "1.MOVING_CW": "1", "1.input.home": "0"}
INDEXER = ROOT / "examples" / "l5x" / "indexer.toml"


@pytest.fixture
def used(page, paused):
    """The feeder in its first stroke, with a breakpoint, a tag selected and forced."""
    page.open(paused.link, paused=True)
    page.step(1000)
    page.until_scan(999, "paused")
    page.browser.find_element("css selector", "[data-element='Main.2.1']").click()  # OTE(Trouble)
    page.press("Force")
    page.press("Breakpoint on rung 3")
    page.step(1)
    page.until_scan(1000, "paused")
    return page


def test_the_table_and_this_test_know_the_same_handles():
    root = {f"data-{name}" for name in ("scan", "mode", "time-ns", "late", "speed", "state", "known")}
    assert {*HANDLES} == root | {
        f"data-{name}" for name in ("name", "value", "element", "power", "forced", "breakpoint", "fault")
    }


def test_handles_controls_and_values_are_on_the_page(used):
    for handle in HANDLES:
        if handle != "data-fault":  # see test_watch_faults
            used.until_there(f"[{handle}]")
    assert [name for name in CONTROLS if not used.control(name).is_displayed()] == []
    assert {name: used.value(name) for name in VALUES} == VALUES
    assert int(used.value("1.shaft")) != 0
    assert int(used.value("Local:1:I.Data[0]")) & 1  # MOVING_CW


def test_a_tag_of_a_program_has_its_full_name(page):
    with watching(INDEXER, "--paused", "--time-scale", "max") as session:
        page.open(session.link, paused=True)
        page.step(100)
        page.watch("\\MainProgram.Step")
        until(lambda: page.value("\\MainProgram.Step") is not None)


def test_the_test_of_the_docs_passes(page, tmp_path, running_rack, monkeypatch):
    command = shutil.which("scanrack")
    if command is None:
        pytest.skip("the command scanrack is not on the path")
    shutil.copy(running_rack, tmp_path / "feeder.toml")
    monkeypatch.chdir(tmp_path)
    assert os.path.exists("feeder.toml")
    names: dict[str, object] = {}
    exec(compile(EXAMPLE, "docs/watch-socket.md", "exec"), names)
    (test,) = (each for name, each in names.items() if name.startswith("test_"))
    assert callable(test)
    test(page.browser)
