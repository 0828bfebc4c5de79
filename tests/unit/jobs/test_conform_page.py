"""The page of `scanrack conform` and what it suggests: verdicts made by hand, each part of the page."""

from __future__ import annotations

from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
from scanrack.io_images.amci3601 import RULES
from scanrack.jobs.conform.findings import ConformVerdict, Difference, SceneVerdict
from scanrack.jobs.conform.moments import PlayedScene, Timing
from scanrack.jobs.conform.page import MOST_DIFFERENCES, save_report
from scanrack.jobs.conform.plan import load_plan
from scanrack.jobs.conform.report import PlayedPlan, fitted_scales, lines, next_steps
from scanrack.jobs.conform.rules_apart.scales import FittedScale
from scanrack.jobs.conform.verdicts import Judge

READ, SHOWN = (0x4401, 0, 0, 7, 0, 0, 0, 0), (0x4421, 0, 0, 9, 0, 0, 0, 0)
DIFFERENCE = Difference(12_300_000, (2, 0, 1, 500, 2, 500, 5, 5), READ, (SHOWN, SHOWN))


def judged(*scenes: SceneVerdict) -> Judge:
    judge = Judge("4.1", Timing())
    judge.result.scenes += scenes
    return judge


def differing(name: str, **more: object) -> SceneVerdict:
    return SceneVerdict(name, ConformVerdict.DIFFERS, 5, 9, difference=DIFFERENCE, **more)  # type: ignore[arg-type]


def recorded(plan: str, *scenes: str, scan_ns: int = 0) -> PlayedPlan:
    return PlayedPlan("4.1", Timing(scan_ns=scan_ns), [PlayedScene(each) for each in scenes], plan=plan)


def test_the_page_has_the_first_read_the_rule_and_the_reason(tmp_path: Path) -> None:
    judge = judged(
        differing("ramps", scales=[FittedScale("acceleration", 0.92, 0.94)]),
        SceneVerdict("holds", ConformVerdict.OPEN, 3, 9, "too many hypotheses & more"),
    )
    rule = judge.result.rules["PRO-03"]
    rule.verdict, rule.why = ConformVerdict.DIFFERS, "It accelerates at 0.930 ± 0.010 of the programmed rate."
    save_report(tmp_path / "r.html", recorded("quick", "ramps", "holds"), judge.result, {})
    page = (tmp_path / "r.html").read_text("utf-8")
    for part in (
        "1 of 2 scenes differ.",
        "12.3 ms after the words 0002h 0000h 1 500 2 500 5 5",
        "read   4401h 0000h 0 7 0 0 0 0  MOVING_CW POSITION_INVALID MODULE_OK",
        "model  4421h 0000h 0 9 0 0 0 0  MOVING_CW ACCELERATING POSITION_INVALID MODULE_OK",
        RULES["PRO-03"].section,
        RULES["PRO-03"].text,
        rule.why,
        "too many hypotheses &amp; more",
        "Play the plan hour",
    ):
        assert part in page, part


class Elements(HTMLParser):
    """The names of a page's elements."""

    def __init__(self) -> None:
        super().__init__()
        self.found: set[str] = set()

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.found.add(tag)


EVIL = """</pre><script src=//evil></script><img src=x onerror="alert('1')">&amp;"""


def test_names_of_a_foreign_plan_and_controller_are_text(tmp_path: Path) -> None:
    """A plan and a capture may come from strangers, and the page goes to others."""
    judge = judged(differing(EVIL), SceneVerdict(EVIL, ConformVerdict.OPEN, 3, 9, EVIL))
    rule = judge.result.rules["PRO-03"]
    rule.verdict, rule.why = ConformVerdict.DIFFERS, EVIL
    plan = replace(recorded(EVIL, EVIL), controller=EVIL, date=EVIL, firmware=EVIL)
    save_report(tmp_path / "r.html", plan, judge.result, {}, name=EVIL)
    page, reader = (tmp_path / "r.html").read_text("utf-8"), Elements()
    reader.feed(page)
    assert "section" in reader.found
    assert not reader.found & {"script", "img"}
    assert page.count("&lt;script src=//evil&gt;") >= 7


def test_a_page_of_many_differences_shows_the_first_ones(tmp_path: Path) -> None:
    names = [f"scene {number}" for number in range(MOST_DIFFERENCES + 2)]
    result = judged(*map(differing, names)).result
    save_report(tmp_path / "r.html", recorded("", *names), result, {}, "june.json")
    page = (tmp_path / "r.html").read_text("utf-8")
    assert page.count("12.3 ms after the words") == MOST_DIFFERENCES
    assert "2 more scenes differ; june.json has them." in page
    assert "<li>Send june.json: it has" in page
    save_report(tmp_path / "r.html", recorded("", *names), result, {})
    page = (tmp_path / "r.html").read_text("utf-8")
    assert "2 more scenes differ; --out FILE writes them." in page
    assert ".json" not in page


@pytest.mark.parametrize(
    ("scene", "plan", "scan_ns", "says"),
    [
        (
            differing("a"),
            "mine",
            0,
            "a: no known alternative explains it. Play it again with --scene 'a'. Check whether a program",
        ),
        (differing("a", rules=["MC-01"]), "mine", 0, "Send june.json: it has"),
        (
            differing("a", scales=[FittedScale("speed", 0.9, 0.95)]),
            "mine",
            0,
            "A long move at constant rates",
        ),
        (
            SceneVerdict("a", ConformVerdict.OPEN, 1, 1),
            "mine",
            1,
            "a counter of scans in the program settles",
        ),
    ],
)
def test_each_result_has_its_next_step(scene: SceneVerdict, plan: str, scan_ns: int, says: str) -> None:
    steps = next_steps(recorded(plan, "a", scan_ns=scan_ns), judged(scene).result, "june.json")
    assert says in next(steps)


def test_scenes_that_need_wiring_are_suggested() -> None:
    plan = load_plan("hour")
    plain = [each.name for each in plan.scenes if not each.needs]
    steps = list(next_steps(recorded("hour", *plain), judged().result, ""))
    wired = [each.name for each in plan.scenes if "inputs" in each.needs]
    assert steps[0] == f"To play {', '.join(wired)}: wire inputs and use --wire."
    assert steps[1].endswith("connect an encoder that does not turn, and use --encoder.")
    whole = recorded("hour", *(each.name for each in plan.scenes))
    assert list(next_steps(whole, judged().result, "")) == []


def test_scenes_that_agree_give_one_factor() -> None:
    scenes = [differing(str(low), scales=[FittedScale("speed", low, low + 0.1)]) for low in (0.9, 0.95, 1.3)]
    assert fitted_scales(judged(*scenes).result) == [
        FittedScale("speed", 0.95, 1.0),
        FittedScale("speed", 1.3, 1.3 + 0.1),
    ]


def test_the_text_speaks_of_interpretations() -> None:
    said = list(lines(judged(differing("a", readings=["A-102"])).result, 0))
    assert sum(each.startswith("    explained by another interpretation: A-102: ") for each in said) == 1
    assert sum(each.startswith("interpretations: ") for each in said) == 1
    assert "reading" not in " ".join(said)
