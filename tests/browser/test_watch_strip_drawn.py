"""What the timing strip draws is what was, also just behind the present of a rack that runs."""

from scanrack.io_images.amci3601 import StatusLsw
from scanrack.traces import open_trace
from watched_page import until, watching

ENTER = "\ue007"
PERIOD_NS = 2_000_000
PIXEL_NS = 8 * PERIOD_NS
ESTOP = StatusLsw.IN_ESTOP.value
CONFIGURES = 0x8000
"""In word 0: the other words are a configuration, not status [chapter 3]."""
SPY = """
window.bars = [];
const pen = CanvasRenderingContext2D.prototype, { fillRect, clearRect } = pen;
pen.clearRect = function (...box) { bars = []; return clearRect.apply(this, box); };
pen.fillRect = function (...box) { bars.push(box); return fillRect.apply(this, box); };
"""
DRAWN = """
const [strip, { run }] = await Promise.all([import("/strip.js"), import("/state.js")]);
const { top, time } = strip.placeOf(arguments[0]);
const own = bars.filter(([, y]) => y >= top && y < top + 17).map(([x, , wide]) => [time(x), time(x + wide)]);
return { own, view: [time(strip.placeOf(arguments[0]).left), run.t], scan: run.scan, last: run.range[1] };
"""
"""Gives the bars of a lane, ns, of the picture that is on the canvas."""


def with_bars(page):
    """The picture of the strip, once the E-stop has a bar in it."""
    seen = page.run(DRAWN, "1.IN_ESTOP")
    return seen if seen["own"] else None


def test_bars_behind_the_present_are_those_of_the_recording(page, tmp_path, running_rack):
    trace = tmp_path / "session.mcap"
    with watching(running_rack, "--record", trace) as session:
        page.open(session.link)
        page.run(SPY)
        for level in ("1", "0"):
            page.control("Press E-stop").send_keys(ENTER)
            page.until_value("1.IN_ESTOP", level)
        released = int(page.handle("scan") or 0)
        page.control("Press E-stop").send_keys(ENTER)
        page.until_value("1.IN_ESTOP", "1")
        page.run("location.hash += `&scan=${arguments[0]}`", released)
        page.until_scan(released, "past")
        seen = until(lambda: with_bars(page))
        assert max(end for _, end in seen["own"]) <= (seen["last"] + 1) * PERIOD_NS + PIXEL_NS  # no future
        page.control("Press E-stop").send_keys(ENTER)  # let go while the past is looked at
        until(lambda: page.run(DRAWN, "1.IN_ESTOP")["last"] > seen["last"] + 500)
        page.until_drawn()
        seen = page.run(DRAWN, "1.IN_ESTOP")
        session.end()
    with open_trace(trace) as recorded:
        images = [scan.inputs(1) for scan in recorded.scans()]
    levels = [not image[0] & CONFIGURES and bool(image[1] & ESTOP) for image in images]
    first, _ = seen["view"]
    assert seen["own"], "no bar is drawn"
    for begin, end in seen["own"]:
        inside = levels[int((begin + PIXEL_NS) // PERIOD_NS) : int((end - PIXEL_NS) // PERIOD_NS)]
        assert all(inside), (begin, end)
    for scan, on in enumerate(levels[: seen["scan"]]):
        time = scan * PERIOD_NS
        if on and time > first:
            assert any(begin - PIXEL_NS <= time <= end + PIXEL_NS for begin, end in seen["own"]), scan
