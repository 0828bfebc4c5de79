"""Recorded tags on the page, in a real browser: drawn, named, read under the pointer, within the window."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from struct import pack

import pytest
from chromium import BROWSER, Chromium
from contrast import contrast
from made_tags import MadeTags
from scanrack.traces import ScanRecorder, SlotInfo, Tag, open_trace
from scanrack.traces.plot import save_page

pytestmark = pytest.mark.slow

SCANS = 3000
TAGS = [
    Tag("Level", "LREAL"),
    Tag("Signed", "LINT"),
    Tag("Unsigned", "ULINT"),
    Tag(r"\Main.a_very_long_name_of_a_counter_that_nobody_wants_to_type", "DINT"),
    Tag("Step", "ENUM", 0, ("IDLE", "FILL", "HOLD")),
    Tag("Lamp", "BOOL"),
]


def row(scan: int) -> bytes:
    wide = scan - 2**63, 2**64 - 1 - scan  # no double has these
    return pack("<dqQiH?", scan * 1e-6, *wide, scan * 700_000, scan // 1000, scan % 100 < 50)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder, memory = tmp_path_factory.mktemp("page"), bytearray(32)
    slots = [SlotInfo(1, "amci3601", "4.1")]
    recorder = ScanRecorder(
        folder / "a.mcap", memory, slots, scan_period_ns=2_000_000, tags=MadeTags(memory, TAGS, row)
    )
    for scan in range(SCANS):
        recorder.scan(scan, scan * 2_000_000, 1)
    recorder.close()
    with open_trace(folder / "a.mcap") as trace:
        save_page(trace, folder / "a.html")
    return folder / "a.html"


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chromium]:
    if BROWSER is None:
        pytest.skip("no Chromium is installed")
    browser = Chromium(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()


DRAWN = """(() => {
  const drawn = [], before = pen.fillText;
  pen.fillText = (says, x, y) => {
    const wide = pen.measureText(says).width;
    const left = { left: x, right: x - wide, center: x - wide / 2 }[pen.textAlign];
    drawn.push([says, left, left + wide]);
    before.call(pen, says, x, y);
  };
  draw();
  pen.fillText = before;
  return drawn;
})()"""


@pytest.mark.parametrize("wide", [420, 1300])
def test_steps_and_names_are_drawn_within_the_chart(page: Path, browser: Chromium, wide: int) -> None:
    browser.look(wide, 900)
    browser.open(page.as_uri())
    drawn = browser.evaluate(DRAWN)
    says = [text for text, _, _ in drawn]
    assert [text for text in says if text in ("IDLE", "FILL", "HOLD")] == ["IDLE", "FILL", "HOLD"]
    assert {"program", "6 tags", "Level", "Lamp", "Step"} <= set(says)
    (long,) = [text for text in says if text.startswith("…") and text.endswith("type")]
    assert r"\Main.a_very_long_name_of_a_counter_that_nobody_wants_to_type".endswith(long[1:])
    edge = browser.evaluate("canvas.clientWidth")
    assert all(left >= 0 and right <= edge + 15 for _, left, right in drawn)
    browser.look(1300, 800)


def test_the_readout_has_the_tags_of_the_scan_under_the_pointer(page: Path, browser: Chromium) -> None:
    browser.open(page.as_uri() + "#from=2.49&to=2.51")
    x, y = browser.evaluate(
        "(box => [box.left + xOf(2.501e9), box.top + 60])(canvas.getBoundingClientRect())"
    )
    browser.mouse("mouseMoved", x, y)
    text = browser.evaluate("readout.textContent")
    assert "scan1,250" in text
    assert "Level0.00125" in text
    assert "875,000,000" in text  # 1,250 * 700,000
    assert "Signed-9,223,372,036,854,774,558" in text
    assert "Unsigned18,446,744,073,709,550,365" in text
    assert "StepFILL" in text
    assert "on: –" in text  # 1250 % 100 is 50
    assert browser.evaluate("readout.scrollWidth <= readout.clientWidth")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_letters_on_a_band_are_readable(page: Path, browser: Chromium, scheme: str) -> None:
    browser.look(1300, 800, scheme)
    browser.open(page.as_uri())
    ink = browser.evaluate("ink()")
    for place in range(6):
        assert contrast(ink, browser.evaluate(f"bandColor({place})")) >= 4.5  # WCAG 2, 1.4.3
    browser.look(1300, 800)
