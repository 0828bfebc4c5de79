"""Cursors A and B of the timing strip: set by key, moved by arrows or dragged, with what is between them.

Broken on purpose: `nearestEdge` always null, the sign of an arrow: the test turns red.
"""

from watched_page import until

RIGHT = "\ue014"
BETWEEN = "return document.querySelector('.between').textContent"
SCAN = "return Number(document.querySelectorAll('.cursor')[arguments[0]].getAttribute('aria-valuenow'))"
DRAG = """
const [to] = arguments, line = document.querySelectorAll(".cursor")[1];
const { left } = line.parentElement.getBoundingClientRect();
const press = (kind, clientX) => line.dispatchEvent(new PointerEvent(kind, { pointerId: 1, clientX }));
line.setPointerCapture = () => {};
line.hasPointerCapture = () => true;
press("pointerdown", 0);
press("pointermove", left + to);
"""
PLACE = """
const { time, left } = (await import("/strip.js")).placeOf("1.MOVING_CW"), found = [];
const edge = arguments[0];
for (let x = left; x < 3000; x += 1) if (time(x) >= edge) return x + 4;
"""
EDGES = """
document.querySelectorAll("#strip details.raw").forEach(each => { each.open = true; });
const signal = document.querySelector("#strip [aria-label='Signal']");
signal.value = "1.MOVING_CW";
signal.dispatchEvent(new Event("change"));
return [...document.querySelectorAll("#strip .edges li")].map(each => Number(each.dataset.scan));
"""


def test_cursors_say_what_is_between_them_and_snap_to_edges(page, paused):
    page.open(paused.link, paused=True)
    page.step(1800)
    page.until_scan(1799, "paused")
    body = page.browser.find_element("css selector", "body")
    body.send_keys("c")
    body.send_keys(",")
    page.until_scan(1798, "past")
    body.send_keys("c")
    until(lambda: page.run(BETWEEN) == "2 ms, 1 scan")
    page.browser.find_elements("css selector", ".cursor")[0].send_keys(RIGHT * 9)
    until(lambda: page.run(BETWEEN) == "20 ms, 10 scans")
    edge = until(lambda: [each for each in page.run(EDGES) if 800 < each < 1799])[0]
    place = page.run(PLACE, edge * 2_000_000)
    page.run(DRAG, place)  # four pixels beside the edge
    until(lambda: page.run(SCAN, 1) == edge)
    page.press("Cursors A B")
    assert page.run("return document.querySelectorAll('.cursor:not([hidden])').length") == 0
