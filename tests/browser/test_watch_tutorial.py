"""Part 1 of the tutorial as a reader does it: what is clicked, and what the machine then does."""

from pathlib import Path

import pytest
from watched_page import until, watching

PANEL = Path(__file__).parents[2] / "examples" / "three_stations_panel"
PLACE = "return document.querySelector(`svg.rail .${arguments[0]}`).getAttribute('transform')"
TARGET = """
const reading = document.querySelector(".machine .reading[title=Target] output").textContent;
return reading === "4,000" && document.querySelector("svg.rail .target").getAttribute("transform");
"""


@pytest.fixture
def panel(tmp_path):
    """The rack of the tutorial; without a watchdog, since a busy machine is not a reason for a fault."""
    text = (PANEL / "line.toml").read_text(encoding="utf-8")
    (tmp_path / "line.rung").write_bytes((PANEL / "line.rung").read_bytes())
    (tmp_path / "line.toml").write_text(f"watchdog_ms = 0\n{text}", encoding="utf-8")
    return tmp_path / "line.toml"


def test_the_line_obeys_the_hand_at_the_panel(page, panel):
    with watching(panel, "--paused", "--time-scale", "3") as session:
        page.open(session.link, paused=True)
        page.press("Press start")
        page.press("Continue")
        flag = until(lambda: page.run(TARGET))  # it homes at -1,300 of the shaft: station 4,000 is at 2,700
        until(lambda: page.value("1.shaft") == "2700" and page.run(PLACE, "cart") == flag)
        until(lambda: page.run(PLACE, "known") == page.run(PLACE, "cart"))
        page.press("Press start")
        until(lambda: page.control("Press start").get_attribute("data-value") == "0")
        until(lambda: int(page.handle("time-ns")) > 10e9)  # the rack file would have pressed stop at 9 s
        moving = page.value("1.shaft")
        until(lambda: page.value("1.shaft") != moving)
        page.press("Press stop")
        until(lambda: page.value("1.shaft") in {"-1300", "2700", "6700"})
        stands, since = page.value("1.shaft"), int(page.handle("time-ns"))
        until(lambda: int(page.handle("time-ns")) > since + 2e9)  # four times the stay at a station
        assert page.value("1.shaft") == stands
