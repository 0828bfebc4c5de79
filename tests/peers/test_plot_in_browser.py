"""The page in a real browser: it shows what was recorded, and zooms."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from chromium import BROWSER, Chromium
from contrast import contrast
from made_traces import PERIOD_NS, idle, record
from scanrack.traces import open_trace
from scanrack.traces.plot import save_page

pytestmark = pytest.mark.slow

SCANS = 5000


def write_page(folder: Path) -> Path:
    words = idle(SCANS)
    words[1000:4000, 8] |= 1  # MOVING_CW
    words[2500, 8] |= 0x1000  # COMMAND_ERROR, for one scan
    position = np.clip(np.arange(SCANS) - 999, 0, 3000) * 3
    words[:, 10], words[:, 11] = position // 1000, position % 1000
    words[4900:, 8] = -31_682  # configuration mode
    name = {"name": "</script><b>& a rack"}
    path = record(folder / "a.mcap", words, metadata=name, chunk_scans=700)
    with open_trace(path) as trace:
        save_page(trace, folder / "a.html")
    return folder / "a.html"


def test_the_page_asks_nothing_of_a_network(tmp_path: Path) -> None:
    text = write_page(tmp_path).read_text(encoding="utf-8")
    assert not re.findall(r"https?:|src=|href=|@import|fetch\(", text)
    assert "<h1>&lt;/script&gt;&lt;b&gt;&amp; a rack</h1>" in text
    assert text.count("</script>") == 2


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_page(tmp_path_factory.mktemp("page"))


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chromium]:
    if BROWSER is None:
        pytest.skip("no Chromium is installed")
    browser = Chromium(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()


def test_every_scan_is_in_the_page_as_it_was_recorded(page: Path, browser: Chromium) -> None:
    rows = [0, 999, 1000, 2000, 4500, 4899, 4950]
    missing = -(2**31)
    browser.open(page.as_uri())
    assert browser.evaluate("time.length") == SCANS
    assert browser.evaluate(f"{rows}.map(row => time[row])") == [row * PERIOD_NS for row in rows]
    assert browser.evaluate(f"{rows}.map(row => scan[row])") == rows
    positions = browser.evaluate(f"{rows}.map(row => data.panels[0].curves[0].curve.values[row])")
    assert positions == [0, 0, 3, 3003, 9000, 9000, missing]
    assert browser.evaluate("data.panels[0].curves[1].curve.values[2000]") == 1500  # 3 steps in 2 ms
    lane = "data.panels[0].lanes.find(lane => lane.name === 'COMMAND_ERROR')"
    assert browser.evaluate(f"[2499, 2500, 2501].map(row => valueAt({lane}, row))") == [0, 1, 0]


def shown(browser: Chromium) -> tuple[float, float]:
    """Return what part of the time the chart was last drawn for."""
    start, end = browser.evaluate("[Number(canvas.dataset.start), Number(canvas.dataset.end)]")
    return start, end


def test_wheel_drag_and_double_click(page: Path, browser: Chromium) -> None:
    browser.open(page.as_uri())
    end = (SCANS - 1) * PERIOD_NS
    assert shown(browser) == (0, end)
    x, y = browser.evaluate(
        "(box => [box.left + LEFT + width() / 2, box.top + 60])(canvas.getBoundingClientRect())"
    )
    browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-600)
    zoomed = shown(browser)
    assert zoomed[1] - zoomed[0] == pytest.approx(end * 1.0015**-600)
    assert sum(zoomed) / 2 == pytest.approx(end / 2, rel=0.01)  # around the pointer
    browser.mouse("mousePressed", x, y, button="left", clickCount=1)
    browser.mouse("mouseMoved", x - 100, y, button="left", buttons=1)
    browser.mouse("mouseReleased", x - 100, y, button="left", clickCount=1)
    moved = shown(browser)
    assert moved[0] > zoomed[0]  # dragged to the left: what is later comes in
    assert moved[1] - moved[0] == pytest.approx(zoomed[1] - zoomed[0])
    assert browser.evaluate("location.hash").startswith("#from=")
    for count in (1, 2):
        browser.mouse("mousePressed", x, y, button="left", clickCount=count)
        browser.mouse("mouseReleased", x, y, button="left", clickCount=count)
    assert shown(browser) == (0, end)


def test_shift_and_drag_zooms_into_what_was_drawn(page: Path, browser: Chromium) -> None:
    browser.open(page.as_uri())
    left, top = browser.evaluate("(box => [box.left, box.top])(canvas.getBoundingClientRect())")
    first, last = browser.evaluate("[xOf(2e9), xOf(3e9)]")
    browser.mouse("mousePressed", left + first, top + 60, button="left", clickCount=1, modifiers=8)
    browser.mouse("mouseMoved", left + last, top + 60, button="left", buttons=1, modifiers=8)
    browser.mouse("mouseReleased", left + last, top + 60, button="left", clickCount=1, modifiers=8)
    assert shown(browser) == pytest.approx((2e9, 3e9), rel=0.02)


def test_the_readout_tells_the_scan_under_the_pointer(page: Path, browser: Chromium) -> None:
    browser.open(page.as_uri() + "#from=4.99&to=5.01")
    x, y = browser.evaluate(
        "(box => [box.left + xOf(5.001e9), box.top + 60])(canvas.getBoundingClientRect())"
    )
    browser.mouse("mouseMoved", x, y)
    text = browser.evaluate("readout.textContent")
    assert "time5.000000 sscan2,500" in text
    assert "position4,503" in text
    assert "constant speed" in text
    assert "status: MOVING_CW MODULE_OK" in text
    assert "error: COMMAND_ERROR" in text


@pytest.fixture
def sized(browser: Chromium) -> Iterator[Chromium]:
    """A browser whose size and colors are put back."""
    yield browser
    browser.look(1300, 800)


LABELS = """(() => {
  const said = [], before = pen.fillText;
  pen.fillText = (...given) => { said.push(given[0]); before.apply(pen, given); };
  draw();
  pen.fillText = before;
  return said;
})()"""


@pytest.mark.parametrize(
    ("least", "most"), [(-8000, 8000), (0, 0), (-1, 1), (0, 999_999), (7, 7), (-950, 30)]
)
def test_a_curve_has_two_labels_at_least(page: Path, browser: Chromium, least: int, most: int) -> None:
    browser.open(page.as_uri())
    pad = max(1, (most - least) * 0.08)
    values = browser.evaluate(f"labeled({least - pad}, {most + pad}, SPEED / 28)")
    assert len(values) >= 2
    assert all(least - pad <= value <= most + pad for value in values)
    assert len(values) <= 8  # and they do not run into each other
    assert sum(says == "0" for says in browser.evaluate(LABELS)) >= 1


@pytest.mark.parametrize(
    "asked", ["#from=abc", "#from=abc&to=def", "#from=&to=2", "#from=3&to=1", "#to=1", "#from=1"]
)
def test_an_address_that_asks_for_nothing_shows_all(page: Path, browser: Chromium, asked: str) -> None:
    browser.open(page.as_uri() + asked)
    assert shown(browser) == (0, (SCANS - 1) * PERIOD_NS)


def test_a_changed_address_is_followed(page: Path, browser: Chromium) -> None:
    browser.open(page.as_uri())
    browser.evaluate("location.hash = '#from=2&to=3', new Promise(done => setTimeout(done, 100))")
    assert shown(browser) == pytest.approx((2e9, 3e9))


def test_a_narrow_window_shows_the_chart_above_the_readout(page: Path, sized: Chromium) -> None:
    sized.look(420, 900)
    sized.open(page.as_uri())
    assert sized.evaluate("canvas.clientWidth") == 420
    assert sized.evaluate("width()") > 240
    assert sized.evaluate("document.documentElement.scrollWidth") <= 420
    assert sized.evaluate("readout.getBoundingClientRect().top >= canvas.getBoundingClientRect().bottom")


def test_a_tall_window_is_used_to_its_full_height(page: Path, sized: Chromium) -> None:
    sized.look(1300, 1600)
    sized.open(page.as_uri())
    assert sized.evaluate("canvas.getBoundingClientRect().bottom") == pytest.approx(1600, abs=2)
    sized.look(1300, 400)
    sized.open(page.as_uri())
    assert sized.evaluate("POSITION") == sized.evaluate("LEAST_POSITION")


def test_a_dark_scheme_is_dark_and_readable(page: Path, sized: Chromium) -> None:
    sized.look(1300, 800, "dark")
    sized.open(page.as_uri())
    assert sized.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(22, 24, 27)"
    names = "[ink(), soft(), ...Object.values(data.colors.lanes).map(shade), shade(data.colors.curve)]"
    for color in sized.evaluate(names):
        assert contrast(color, "#16181b") >= 4.5, color  # WCAG 2, 1.4.3
    sized.look(1300, 800)
    sized.open(page.as_uri())
    for color in sized.evaluate(names):
        assert contrast(color, "#ffffff") >= 4.5, color


def test_the_line_beside_the_chart_is_as_high_as_the_chart(page: Path, sized: Chromium) -> None:
    for scheme in ("light", "dark"):
        sized.look(1300, 1600, scheme)
        sized.open(page.as_uri())
        edge = sized.evaluate("getComputedStyle(canvas).borderRight")
        assert edge.startswith("1px solid rgb")
        assert sized.evaluate("style('--edge')").startswith("#")
