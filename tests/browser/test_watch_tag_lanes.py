"""Tags in the timing strip: every change, live and in the past, as the bench has it."""

from scanrack.jobs import open_bench
from watched_page import until, watching

EDGES = """
const rows = [...document.querySelectorAll(".edges li")];
return rows.map(each => [Number(each.dataset.scan), each.dataset.value]);
"""
OPEN = "document.querySelector('.edges').closest('details').open = true"


def chosen(page, tag):
    """Put a tag into the strip, by the controls."""
    page.watch(tag)
    page.click(f"//section[@id='watch']//button[text()='{tag}']", "xpath")
    page.press("Strip")


def listed(page, tag):
    """The edges that the strip has of a tag, the earliest first."""
    page.run(OPEN)
    until(lambda: tag in page.run("return [...document.querySelectorAll('option')].map(each => each.value)"))
    page.choose("Signal", tag)
    return [(scan, value) for scan, value in page.run(EDGES)[::-1]]


def until_listed(page, tag, expected):
    until(lambda: listed(page, tag) == expected)


def changes(rack, tag, scans):
    """Each value of a tag of the feeder, and the scan behind which it has it first."""
    bench = open_bench(rack)
    found: list[tuple[int, str]] = []
    for scan in range(scans):
        bench.scan(1)
        value = str(int(bench.program.tags[tag]))
        if not found or found[-1][1] != value:
            found.append((scan, value))
    return found


def test_edges_of_the_past_are_those_of_the_bench(page, paused, feeder_rack):
    page.open(paused.link, paused=True)
    page.step(2480)
    page.until_scan(2479, "paused")
    for tag in ("OutGo", "Out.Done", "Strokes.ACC"):
        chosen(page, tag)
        expected = changes(feeder_rack, tag, 2480)
        until_listed(page, tag, expected)


def test_edges_of_a_rack_that_runs_are_all_there(page, running_rack):
    with watching(running_rack) as session:
        page.open(session.link)
        chosen(page, "OutGo")
        until(lambda: len(listed(page, "OutGo")) > 3)
        page.press("Pause")
        page.until_handle("state", "paused")
        scans = int(page.handle("scan")) + 1
        there = changes(running_rack, "OutGo", scans)
        until(lambda: listed(page, "OutGo")[-1] == there[-1])
        first, *later = listed(page, "OutGo")  # the lane begins where the strip did when the tag was chosen
        assert later == [each for each in there if each[0] > first[0]]
        assert first[1] == [value for scan, value in there if scan <= first[0]][-1]


def test_a_python_program_has_its_steps_in_the_strip(page):
    with watching("examples/three_stations/line.toml") as session:
        page.open(session.link)
        page.until_there("[data-name='line.step'][data-value]")
        page.click("//button[contains(@class, 'chip')]/span[text()='line.step']", "xpath")
        page.press("Strip")
        until(lambda: "move" in [value for _, value in listed(page, "line.step")])
