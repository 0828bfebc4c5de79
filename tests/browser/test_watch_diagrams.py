"""A function block diagram is drawn on its sheet, with lit wires and the values at its pins.

Broken on purpose: a wire of a number that is lit by 1, a pin with the value of its block's output, a click
that chooses nothing.
"""

import pytest
from l5x_files import block, document, ladder, program, reference, sheets, tag, task, wire
from watched_page import until, watching

RACK = """
name = "small"
program = "machine.L5X"
scan_ms = 2
watchdog_ms = 0
[[slot]]
number = 1
module = "1769-IQ16"
"""
TAGS = {"Start": "BOOL", "Motor": "BOOL", "N": "DINT", "No": "FBD_BOOLEAN_NOT", "Sum": "FBD_MATH"}
CONTENT = (
    reference("IRef", 0, "Start", x=20, y=60)
    + block("BNOT", 1, "No", x=120, y=40, pins="In Out")
    + reference("ORef", 2, "Motor", x=260, y=60)
    + wire(0, "1.In")
    + wire("1.Out", 2)
    + reference("IRef", 3, "N", x=20, y=180)
    + block("ADD", 4, "Sum", x=120, y=160, pins="SourceA SourceB Dest")
    + wire(3, "4.SourceA")
)
TEXT = "return document.querySelector(arguments[0])?.textContent"
WIDTH = "return getComputedStyle(document.querySelector(arguments[0])).strokeWidth"


@pytest.mark.slow
def test_a_diagram_lights_its_wires_and_shows_the_values_of_its_pins(page, tmp_path):
    routines = ladder("Main", "JSR(Blocks,0);"), sheets("Blocks", CONTENT)
    tags = [tag(name, kind) for name, kind in TAGS.items()]
    text = document(tags=tags, programs=[program("P", *routines)], tasks=[task("T", "P")])
    (tmp_path / "machine.L5X").write_text(text, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    with watching(tmp_path / "rack.toml") as session:
        page.open(session.link)
        page.click(r"[data-routine='\\P.Blocks']")
        on, off = ".fbd .wire[data-lit='No.Out']", ".fbd .wire[data-lit='Start']"
        page.until_there(f"{on}[data-value='1']")
        page.until_there(f"{off}[data-value='0']")
        assert page.run(WIDTH, on) > page.run(WIDTH, off)
        assert page.run("return document.querySelectorAll('.fbd .wire:not([data-lit])').length") == 1
        page.click(".fbd .element[data-tag='N']")
        until(lambda: "N" in page.run(TEXT, "#tag"))
        page.control("New value").send_keys("1")
        page.press("Force")
        until(lambda: page.run(TEXT, ".fbd [data-value-of='Sum.SourceA']") == "1")
        until(lambda: page.run(TEXT, ".fbd [data-value-of='Sum.Dest']") == "1")
        assert page.run(TEXT, ".fbd [data-value-of='Sum.SourceB']") == "0"
        assert not page.messages()
