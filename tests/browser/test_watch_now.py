"""What the page says at once: what blocks do, why in view, aliases, what it would take.

Broken on purpose: the seconds of a timer left in ms, the state of a block taken from the last row: red.
"""

from scanrack.jobs import open_bench
from watched_page import until

LINES = """
return [...document.querySelectorAll(`[data-at='${arguments[0]}'] [data-now]`)].map(each => each.textContent);
"""


def at_scan(page, session, scans):
    page.open(session.link, paused=True)
    page.step(scans)
    page.until_scan(scans - 1, "paused")
    page.until_drawn()


def test_blocks_say_what_they_do_and_show_their_parameters_on_request(page, paused):
    at_scan(page, paused, 1500)
    bench = open_bench("examples/feeder/feeder.toml")
    bench.scan(1500)
    position = bench.slot[1].status.position
    until(lambda: page.run(LINES, "Main.10") == ["moving to 6,000", f"at {position:,}, 4,000 steps/s"])
    assert page.run(LINES, "Main.11") == ["idle", ""]
    assert page.run(LINES, "Main.3") == ["0.0 of 1.0 s"]  # TON(Quiet,1000,0)
    box = "return document.querySelector(\"[data-at='Main.10'] svg\").textContent"
    assert "Deceleration" not in page.run(box)
    page.press("Parameters")
    until(lambda: "Deceleration" in page.run(box))
    page.until_drawn()
    assert page.value("OutGo") == "1"
    page.step(3100)  # the emergency stop at 8 s is let go 0.5 s later, in scan 4,250; then Quiet counts
    page.until_scan(4599, "paused")
    bench.scan(3100)
    quiet = bench.program.tags["Quiet.ACC"]
    assert 0 < quiet < 1000
    until(lambda: page.run(LINES, "Main.3") == [f"{quiet / 1000:.1f} of 1.0 s"])
    until(lambda: page.run(LINES, "Main.13")[0].startswith("error "))
    page.press("Parameters")
    until(lambda: "Deceleration" not in page.run(box))
