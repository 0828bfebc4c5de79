"""A fault of the CPU on the page: what it says, where it is, and the values as they stood then."""

import pytest
from watched_page import until, watching

RACK = """
name = "fault"
program = "fault.rung"
scan_ms = 2
watchdog_ms = 0
[[slot]]
number = 1
module = "1769-IQ16"
[slot.options]
inputs = { go = 0 }
"""
PROGRAM = "PROGRAM F\nTAG N : DINT\nTAG A : DINT[4]\nROUTINE Main\nADD(N,1,N);\nMOV(1,A[N]);\nEND\n"


@pytest.fixture
def faulted(page, tmp_path):
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "fault.rung").write_text(PROGRAM, encoding="utf-8")
    with watching(tmp_path / "rack.toml") as session:
        page.open(session.link)
        page.until_handle("mode", "fault")
        yield page


def test_a_fault_is_shown_at_its_rung(faulted):
    faulted.until_there("[data-at='Main.1'][data-fault]")
    said = "return document.querySelector('[role=alert]').textContent"
    until(lambda: "subscript 4 is out of range" in faulted.run(said))
    assert faulted.run("return document.querySelector('.state').textContent").endswith("Fault")
    assert faulted.run("return document.querySelectorAll('[data-fault][data-at]').length") == 1


PYTHON = (
    '"""A line."""\n' + "# parts\n" * 60 + "count = 0\n\n\ndef logic(scan):\n    assert scan.number < 9\n"
)


def test_a_fault_in_python_is_shown_at_its_line_with_the_way_on(page, tmp_path):
    (tmp_path / "rack.toml").write_text(RACK.replace("fault.rung", "fault.py"), encoding="utf-8")
    (tmp_path / "fault.py").write_text(PYTHON, encoding="utf-8")
    with watching(tmp_path / "rack.toml") as session:
        page.open(session.link)
        page.until_there("[data-at='fault.py.66'][data-fault][aria-current]")
        seen = (
            "return document.querySelector('[data-fault][data-at]').getBoundingClientRect().top < innerHeight"
        )
        until(lambda: page.run(seen))
        assert "AssertionError" in page.run("return document.querySelector('[role=alert]').textContent")
        causes = page.run("return document.getElementById('causes').textContent")
        assert "then press Branch from here" in causes
        page.run("location.hash += '&scan=5'")
        page.until_scan(5, "past")  # nothing had failed yet
        assert not page.run("return document.querySelector('[role=alert]').checkVisibility()")
        assert page.run("return document.querySelectorAll('[data-fault]').length") == 0


def test_values_are_those_of_the_scan_that_stopped(faulted):
    faulted.until_scan(3, "paused")  # the fourth scan: A[4] is none of A[0] to A[3]
    faulted.until_value("N", "4")
    faulted.until_value("A[N]", "")  # it can't be read, and the page goes on
