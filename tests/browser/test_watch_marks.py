"""A recording as easy as a live rack: its marks, all its events, zoom, plot, readings, since when.

The feeder runs for 40,000 scans; its emergency stop comes at 8 s. Broken on purpose: marks without an axis,
the key not bound, a list that ends at one piece, lights shown at first, a drag that zooms nothing, `since`
requested once, readings without tabs: each turns a test red.
"""

import re

import pytest
from scanrack.commands import build
from selenium.webdriver.common.action_chains import ActionChains
from typer.testing import CliRunner
from watched_page import until, watching, why_not

SCANS = 40_000
ERROR = 4001  # the scan of the first error, by `scanrack show`
TEXTS = "return [...document.querySelectorAll('#events li .what')].map(each => each.textContent)"


@pytest.fixture(scope="module")
def session_trace(tmp_path_factory, request):
    """The recording."""
    missing = why_not()
    if missing is not None:
        pytest.skip(missing)
    path = tmp_path_factory.mktemp("marked") / "run.mcap"
    feeder = request.path.parents[2] / "examples" / "feeder" / "feeder.toml"
    done = CliRunner().invoke(
        build(), ["run", str(feeder), "--scans", str(SCANS), "--record", str(path), "-q"]
    )
    assert done.exit_code == 0, done.output
    return path


@pytest.fixture(scope="module")
def session(session_trace):
    with watching(session_trace) as running:
        yield running


@pytest.fixture
def marked(page, session):
    page.open(session.link)
    until(lambda: page.handle("marks"))
    return page


def key(page, letter):
    page.browser.find_element("css selector", "#program").send_keys(letter)


def test_the_failure_has_its_line_and_keys_lead_from_mark_to_mark(marked):
    assert marked.handle("marks") == "4"  # two rules of the power-up, two of the emergency stop
    until(
        lambda: "INPUT_ERROR came on" in marked.run("return document.querySelector('#bar .band').textContent")
    )
    drawn = "const c = document.querySelector('canvas.mark-axis');"
    drawn += "return c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some(each => each)"
    assert marked.run(drawn)
    key(marked, "E")
    marked.until_scan(ERROR, "past")
    key(marked, "E")
    marked.until_scan(9, "past")
    marked.press("Next mark")
    marked.until_scan(ERROR, "past")
    key(marked, "e")
    until(
        lambda: (
            "There is no mark after scan"
            in marked.run("return document.querySelector('#notice').textContent")
        )
    )
    assert marked.messages() == []


def test_the_list_of_events_is_complete_and_kinds_can_be_hidden(marked):
    until(lambda: marked.run(TEXTS))
    assert not [each for each in marked.run(TEXTS) if each.startswith("Axis OK")]
    marked.press("Moves")
    until(
        lambda: not [each for each in marked.run(TEXTS) if "move" in each and "cut off a motion" not in each]
    )
    marked.press("Moves")
    marked.press("Lights")
    until(lambda: len([each for each in marked.run(TEXTS) if each.startswith("Axis OK")]) > 20)

    def whole():
        marked.run("document.querySelector('#events .end').scrollIntoView()")
        return " events up to here." in marked.run(
            "return document.querySelector('#events .end').textContent"
        )

    until(whole)
    rows = marked.run(TEXTS)
    assert len(rows) > 110  # more than a piece
    assert "has not been configured since it was powered up" in " ".join(rows[-4:])


def test_since_when_is_known_in_the_whole_recording_and_back_leads_there(marked):
    bit = "Local:1:I.Data[0].11"
    marked.run("const [tag] = arguments; import('/selection.js').then(all => all.select({ tag }))", bit)
    until(lambda: "Since 00:09.504" in marked.run("return document.querySelector('#tag .since').textContent"))
    marked.press("Previous change")
    marked.until_scan(4752, "past")
    marked.press("Previous change")
    until(lambda: ERROR <= int(marked.handle("scan")) <= ERROR + 2)


def test_dragging_on_the_axis_zooms(marked):
    marked.until_drawn()
    before = marked.run("return document.querySelector('#strip .tools output:last-of-type').textContent")
    axis = marked.browser.find_element("css selector", ".dragging")
    actions = ActionChains(marked.browser)
    actions.move_to_element_with_offset(axis, -100, 0).click_and_hold().move_by_offset(
        160, 0
    ).release().perform()
    spans = "return [...document.querySelectorAll('#strip .tools output')].at(-1).textContent"
    until(lambda: marked.run(spans) != before)
    number, unit = marked.run(spans).split()
    assert float(number) / {"s": 1, "ms": 1000}[unit] < 3
    marked.press("Zoom out")
    until(lambda: marked.run(spans) in ("1 s", "2 s", "5 s"))


def test_two_lanes_are_plotted_on_one_chart(marked):
    marked.until_drawn()
    marked.press("Plot lanes")
    marked.choose("Second lane", "1.MOVING_CW")
    pixels = "const c = document.querySelector('canvas.plot'), found = new Set();"
    pixels += "const data = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
    pixels += "for (let at = 0; at < data.length; at += 4) if (data[at + 3] > 250)"
    pixels += " found.add(data.slice(at, at + 3).join());"
    pixels += "return [...found]"
    colors = "return ['curve', 'mark'].map(name => {"
    colors += "const c = document.createElement('canvas').getContext('2d');"
    colors += "c.fillStyle = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`);"
    colors += "c.fillRect(0, 0, 1, 1); return c.getImageData(0, 0, 1, 1).data.slice(0, 3).join(); })"
    assert set(marked.run(colors)) <= set(marked.run(pixels))
    marked.press("Close the plot")


def test_readings_between_the_cursors_are_a_table_in_the_clipboard(marked):
    marked.until_drawn()
    marked.run("navigator.clipboard.writeText = text => { window.copied = text; return Promise.resolve(); }")
    marked.press("Cursors A B")
    marked.press("Copy readings")
    text = until(lambda: marked.run("return window.copied"))
    first, second, head, *rows = [line.split("\t") for line in text.split("\n")]
    assert head == ["lane", "at A", "at B", "least", "greatest", "edges"]
    assert (first[0], second[0]) == ("A", "B")
    (position,) = [row for row in rows if row[0] == "1.position"]
    assert int(position[3]) <= int(position[1]) <= int(position[4])
    assert {row[1] for row in rows if row[0].startswith("1.MOVING")} <= {"0", "1"}
    assert {len(row) for row in rows} == {6}


def test_a_branch_says_that_it_runs_and_its_parent_is_marked(page, tmp_path, session_trace):
    trace = tmp_path / "run.mcap"
    trace.write_bytes(session_trace.read_bytes())
    with watching(f"{trace}#scan=500") as session:
        page.open(session.link)
        page.until_scan(500, "past")
        page.press("Branch from here")
        said = "return document.querySelector('#notice').textContent"
        until(lambda: "This is a branch from scan 500: it runs again, at 1×." in page.run(said))
        page.press("Compare with a recording")
        page.until_there("[aria-label='Compare with run.mcap']")
        row = page.run("return document.querySelector('.choices li').textContent")
        assert re.fullmatch(r"run\.mcap \d{4}-\d\d-\d\d \d\d:\d\d the parent of this branch", row)


def test_a_click_at_a_mark_goes_to_its_scan(marked):
    place = (
        "const box = document.querySelector('canvas.mark-axis').getBoundingClientRect();"
        f"return [8 + {ERROR} / {SCANS - 1} * (box.width - 16) - box.width / 2, 0].map(Math.round)"
    )
    axis = marked.browser.find_element("css selector", "canvas.mark-axis")
    ActionChains(marked.browser).move_to_element_with_offset(axis, *marked.run(place)).click().perform()
    until(lambda: marked.handle("scan") == str(ERROR))
