"""Programs in structured text and in Python; an edit while the rack runs, and a mistake in one."""

import pytest
from watched_page import until, watching

NOTICE = "return document.getElementById('notice').textContent"
WAITS = "return document.querySelector('.waits')?.textContent ?? ''"
TEXTS = "return [...document.querySelectorAll(arguments[0])].map(each => each.textContent)"
IN_VIEW = """
const place = document.querySelector(arguments[0])?.getBoundingClientRect();
const { top, bottom } = document.getElementById("program").getBoundingClientRect();
return Boolean(place) && place.top >= top && place.bottom <= bottom;
"""
RUNNING = ".code-line[data-power='1'] .number"
RACK = """
name = "small"
program = "{}"
scan_ms = 2
watchdog_ms = 0
[[slot]]
number = 1
module = "1769-IQ16"
[slot.options]
inputs = {{ go = 0 }}
"""
COUNT = """\
PROGRAM Count
TAG N : DINT
TAG Never : BOOL
ROUTINE Main ST
N := N + 1;
IF Never THEN
  N := 0;
END_IF;
END
"""
CALLS = """\
PROGRAM Calls
TAG On : BOOL
ROUTINE Main
JSR(Last,0);
JSR(Middle,0);
END
ROUTINE Middle
XIC(On)JSR(Inner,0);
JSR(Last,0);
END
ROUTINE Inner
XIC(On)OTE(On);
END
ROUTINE Last
XIC(On)OTE(On);
END
"""


@pytest.fixture
def rack(tmp_path):
    """Makes a rack file with a program beside it."""

    def make(name, program):
        (tmp_path / name).write_text(program, encoding="utf-8")
        (tmp_path / "rack.toml").write_text(RACK.format(name), encoding="utf-8")
        return tmp_path / "rack.toml"

    return make


def test_structured_text_has_its_values_beside_the_lines(page, rack):
    with watching(rack("count.rung", COUNT)) as session:
        page.open(session.link)
        until(lambda: int(page.value("N") or 0) > 10)
        assert page.run(TEXTS, ".code-line code") == ["N := N+1;", "IF Never THEN", "    N := 0;", "END_IF;"]
        until(lambda: [*page.power().values()] == ["1", "0", "0"])
        assert page.run(TEXTS, ".code-line .chip span") == ["N", "Never", "N"]


def test_a_sequence_shows_the_line_at_which_it_waits(page):
    with watching("examples/sequences/stations.toml") as session:
        page.open(session.link)
        until(lambda: "waits at line" in page.run(WAITS))
        until(lambda: page.run(TEXTS, RUNNING))
        (line,) = page.run(TEXTS, RUNNING)
        until(lambda: f"waits at line {line} " in page.run(WAITS))
        assert page.value("stations.rounds") is not None
        until(lambda: page.run(IN_VIEW, RUNNING))
        assert "def" in page.run(TEXTS, ".code-line [data-kind='keyword']")


def test_an_edit_is_taken_over_and_a_mistake_is_shown(page, rack):
    program = "PROGRAM Line\nTAG Go : BOOL\nTAG N : DINT\nROUTINE Main\nADD(N,1,N);\n{}END\n"
    path = rack("line.rung", program.format(""))
    with watching(path) as session:
        page.open(session.link)
        until(lambda: int(page.value("N") or 0) > 10)
        before = int(page.value("N"))
        (path.parent / "line.rung").write_text(program.format("XIC(Go)OTX(Go);\n"), encoding="utf-8")
        until(lambda: "The old program continues" in page.run(NOTICE))
        assert "line.rung:6" in page.run(NOTICE)
        (path.parent / "line.rung").write_text(program.format("XIO(Go)OTE(Go);\n"), encoding="utf-8")
        page.until_there("[data-element='Main.1.0']")
        until(lambda: "The old program continues" not in page.run(NOTICE))
        until(lambda: int(page.value("N") or 0) > before)  # values are kept


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


def test_an_edit_that_a_sequence_prevents_is_taken_over_with_a_restart_of_that_sequence(page, rack):
    path = rack("small.py", SEQUENCE)
    with watching(path) as session:
        page.open(session.link)
        until(lambda: page.value("small.rounds") == "7")
        (path.parent / "small.py").write_text(SEQUENCE.replace("go.rises", "go.falls"), encoding="utf-8")
        until(lambda: "is no longer at its place" in page.run(NOTICE))
        assert "small.py:11: cycle waits in cycle" in page.run(NOTICE)
        page.run("document.querySelector('#notice button').click()")
        until(lambda: "restart: cycle" in page.run(NOTICE))
        until(lambda: "go falls" in page.run(WAITS))
        assert page.value("small.rounds") == "7"


def test_a_jsr_is_a_link_and_the_routines_are_a_tree_of_calls(page, rack):
    with watching(rack("calls.rung", CALLS)) as session:
        page.open(session.link)
        page.until_there("svg.rung .instruction")
        page.until_drawn()
        assert page.run(TEXTS, "[data-tree] [role=tab]") == ["Main", "Last", "Middle", "Inner"]
        page.click("[data-element^='Main.1.'][role=link]")
        page.until_there("svg.rung [data-element^='Middle.1.']")
        assert page.run(TEXTS, "[role=tab][data-routine][aria-selected=true]") == ["Middle"]
        assert page.run("return document.querySelector('#tag[data-selected]')") is None
