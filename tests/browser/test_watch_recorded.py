"""What is clicked on the page is recorded with its scan, and acts at once."""

from scanrack.io_images.amci3601 import StatusLsw
from scanrack.traces import open_trace
from watched_page import until, watching

CLICKS = 6
ENTER = "\ue007"
ESTOP = StatusLsw.IN_ESTOP.value


def test_a_click_is_recorded_and_its_edge_follows_within_two_scans(page, tmp_path, running_rack):
    trace = tmp_path / "session.mcap"
    with watching(running_rack, "--record", trace) as session:
        page.open(session.link)
        until(lambda: int(page.handle("scan")) > 100)
        for click in range(CLICKS):
            page.control("Press E-stop").send_keys(ENTER)  # a slow click would be a hold
            page.until_value("1.IN_ESTOP", str((click + 1) % 2))
        session.end()
    with open_trace(trace) as recorded:
        orders = [event.scan for event in recorded.events() if event.topic == "/orders"]
        levels = [scan.inputs(1)[1] & ESTOP for scan in recorded.scans()]
    assert len(orders) == CLICKS
    edges = [scan for scan in range(101, len(levels)) if levels[scan] != levels[scan - 1]]
    assert len(edges) == CLICKS
    assert [edge - order in (0, 1, 2) for order, edge in zip(orders, edges, strict=True)] == [True] * CLICKS
