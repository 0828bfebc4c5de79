"""Power and tags that the page shows are those of a bench that was run as far."""

from functools import partial

from scanrack.jobs import open_bench
from scanrack.ladder.draw import power
from watched_page import until

SCANS = [1, 1, 1, 1, 6, 90, 200, 200, 300, 1, 1, 400, 800, 1000, 1000, 40, 60, 500, 3, 1]
"""Steps of a session: 20 pauses, the emergency stop at 8 s among them."""
TAGS = ["Awake", "Trouble", "Homing", "Feeding", "OutGo", "BackGo", "Quiet.ACC", "Strokes.ACC", "Axis.State"]


def expected_power(bench):
    """Power of the feeder's routine in the latest scan, as `scanrack ladder --at` draws it."""
    (routine,) = bench.program.program.routines
    truths = bench.program.truth("Main")
    return {
        f"Main.{number}.{place}": sign
        for number, rung in enumerate(routine.rungs)
        for place, sign in enumerate(power(rung, truths[number]))
    }


def plain(value):
    return str(int(value)) if isinstance(value, bool) else str(value)


LIT = """
const all = element => document.querySelector(`[data-element='${element}']`);
const of = (element, part) => getComputedStyle(all(element).querySelector(part)).stroke;
const green = of("Main.0.0", ".wire");
return arguments[0].map(each => [".sign", ".wire"].map(part => of(each, part) === green));
"""


def test_twenty_paused_scans(page, paused):
    bench = open_bench("examples/feeder/feeder.toml", watched=True)
    page.open(paused.link, paused=True)
    page.until_drawn()
    page.press("Parameters")  # a timer says what it does in place of them
    for scans in SCANS:
        page.step(scans)
        bench.scan(scans)
        page.until_scan(bench.scans - 1, "paused")
        page.until_power(expected_power(bench))
        for tag in TAGS:
            page.until_value(tag, plain(bench.program.tags[tag]))
        page.until_value("1.position", str(bench.slot[1].status.position))
        page.until_value("1.shaft", str(bench.slot[1].shaft))


def test_scans_of_the_past_are_shown_as_they_were(page, paused):
    page.open(paused.link, paused=True)
    page.until_drawn()
    page.press("Parameters")  # a timer says what it does in place of them
    page.step(1500)
    page.until_scan(1499, "paused")
    bench = open_bench("examples/feeder/feeder.toml", watched=True)
    for scan in (0, 1, 500, 1234):
        page.run("location.hash = location.hash.replace(/&scan=.*|$/, `&scan=${arguments[0]}`)", scan)
        page.until_scan(scan, "past")
        bench.scan(scan + 1 - bench.scans)
        page.until_power(expected_power(bench))
        page.until_value("Strokes.ACC", str(bench.program.tags["Strokes.ACC"]))
    page.press("Live")
    page.until_scan(1499, "paused")
    bench.scan(1500 - bench.scans)
    page.until_power(expected_power(bench))
    assert not bench.program.tags["Trouble"]
    # XIC(Trouble) XIO(card.status.IN_ESTOP): the second one is true, and no power comes to it
    until(lambda: page.run(LIT, ["Main.3.0", "Main.3.1"]) == [[False, False], [True, False]])


def test_the_speed_of_an_axis_is_that_of_the_last_fifty_scans(page, paused):
    page.open(paused.link, paused=True)
    bench = open_bench("examples/feeder/feeder.toml")
    shown = "return document.querySelector('.figures [title=\"Steps/s\"] output').textContent"

    def is_shown(speed):
        return page.run(shown) == speed

    for scans in (1000, 400, 2000):  # on the way out, and back; at rest after the stop
        page.step(scans)
        page.until_scan(bench.scans + scans - 1, "paused")
        bench.scan(scans - 50)
        before = bench.slot[1].status.position
        bench.scan(50)
        speed = (bench.slot[1].status.position - before) * 10  # 50 scans of 2 ms
        until(partial(is_shown, f"{speed:,}"))


def test_a_shaft_that_is_read_after_its_scan_is_shown(page, paused):
    """In a pause the machines are read again: a frame of the same time has the shaft alone."""
    page.open(paused.link, paused=True)
    page.step(10)
    page.until_scan(9, "paused")
    page.run("return import('/state.js').then(state => state.take({machine: {1: {shaft: 4321}}}))")
    page.until_value("1.shaft", "4321")
