"""Pictures of sequential function charts: what stands where, what a page lights."""

import re

from charts import BATCH, program_of
from lxml import etree
from scanrack.ladder.draw import live_chart, routine_text, routines_svg
from scanrack.ladder.model.chart_layout import layout_of
from scanrack.watch.history.catalog import Catalog


def made():
    return program_of(BATCH, tags="Full : BOOL; Valve : BOOL")


def test_branches_stand_side_by_side_and_what_follows_them_below_the_first():
    cells = layout_of(made().routines[0].chart)
    rows = {name: row for name, (_, row) in cells.steps.items()}
    assert rows == {"IDLE": 0, "FILL": 2, "HEAT": 2, "DRAIN": 4, "DONE": 6}
    assert cells.steps["HEAT"][0] > cells.steps["FILL"][0] == 0
    assert cells.steps["DRAIN"][0] == cells.steps["FILL"][0]
    assert cells.jumps == {(2, "IDLE")}
    places = [*cells.steps.values(), *cells.transitions]
    assert len(set(places)) == len(places)


def test_a_page_lights_steps_actions_and_transitions_by_their_tags():
    live = live_chart(made().routines[0].chart, "Seq")
    root = etree.fromstring(live.svg)
    lit = {each.get("data-at"): each.get("data-lit") for each in root.iter("{*}g")}
    assert lit == {
        "Seq.0": "Idle.X",
        "Seq.1": "Fill.X",
        "Seq.2": "Open.A",
        "Seq.3": "Stir.A",
        "Seq.4": "Heat.X",
        "Seq.5": "Drain.X",
        "Seq.6": "Drain.X",  # R is on with its step
        "Seq.7": "Done.X",
        "Seq.8": "T0",
        "Seq.9": "T1",
        "Seq.10": "T2",
        "Seq.11": "T3",
    }
    assert {"Fill.T", "Idle.X", "T3"} <= set(live.names)


def test_a_page_gets_a_chart_with_its_tags_and_notes():
    catalog = Catalog(made())
    assert catalog.routines() == [{"name": "Seq", "kind": "sfc", "comment": "", "lines": 12, "calls": []}]
    shown, answer = catalog.show("seq", 100)
    assert answer["notes"] == ["Makes <one> batch"]
    assert answer["chart"].startswith("<svg")
    assert "Stir.A" in shown.names
    assert shown.power({}) == {}


def test_a_search_finds_elements_and_uses_of_a_tag():
    catalog = Catalog(made())
    assert {"Seq.9"} <= {each["rung"] for each in catalog.find("Fill.DN")}
    uses = {(each["rung"], each["text"].split(":")[0]) for each in catalog.mentions("Fill.DN")}
    assert "Seq.9" in {rung for rung, _ in uses}


def test_a_chart_as_characters_has_the_numbers_of_its_elements():
    text = routine_text(made().routines[0])
    assert re.search(r"^ +1 │ STEP Fill$", text, re.MULTILINE)
    assert "   9 │   + T1 with Heat: Fill.DN" in text
    assert "│     -> Drain" in text


def test_a_chart_as_svg_is_one_document():
    program = made()
    etree.fromstring(routines_svg([(program.routines[0], program.routines[0].numbers)]).encode())
