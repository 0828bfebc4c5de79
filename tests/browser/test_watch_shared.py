"""A shared page from a file: the same page without a server, a request or a word in the console.

Broken on purpose: `connection` allowed in the policy of page_file.py, a scan too early in `placeAt` of
embedded.js: a test turns red.
"""

from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.jobs import open_bench
from scanrack.watch.share.command import ShareOptions, share
from scanrack.watch.share.failure import Failure
from typer.testing import CliRunner
from watched_page import NAMED, until, watching, why_not

FEEDER = Path(__file__).parents[2] / "examples" / "feeder"
SCANS = 3000
LOOKS = [0, 1, 777, 1500, 2999]
LOADED = """
return performance.getEntriesByType("resource").map(each => each.name)
  .filter(each => !each.startsWith("data:"))
"""
"""Gives the addresses that the page has requested."""


@pytest.fixture(scope="module")
def shared(tmp_path_factory, feeder_rack):
    """The page of a recording of the feeder."""
    missing = why_not()
    if missing is not None:
        pytest.skip(missing)
    folder = tmp_path_factory.mktemp("shared")
    for words in (
        ["run", feeder_rack, "--scans", SCANS, "--record", folder / "run.mcap", "-q"],
        ["share", folder / "run.mcap"],
    ):
        done = CliRunner().invoke(build(), [str(each) for each in words])
        assert done.exit_code == 0, done.output
    return folder / "run.html"


def look(page, scan):
    """Look at a scan of a page whose modules have no addresses of their own."""
    page.run(f"{NAMED}return (await named('lookAt'))(arguments[0])", scan)
    page.until_scan(scan, "past")


def test_any_scan_of_a_page_from_a_file_is_that_of_the_bench(page, shared, feeder_rack):
    page.browser.get(shared.as_uri())
    page.until_scan(SCANS - 1, "past")
    bench, ran = open_bench(feeder_rack), 0
    for scan in LOOKS:
        bench.scan(scan + 1 - ran)
        ran = scan + 1
        look(page, scan)
        until(lambda: len(page.power()) > 14)
        inputs = bench.slot[1].inputs
        page.until_value("Feeding", str(int(bench["Feeding"])))
        page.until_value("1.position", str(inputs[2] * 1000 + inputs[3]))
    assert page.messages() == []
    assert page.run(LOADED) == []


SIZED = """name = "sized"
program = "line.rung"
[modules]
small = "sized.py:SMALL"
large = "sized.py:LARGE"
[[slot]]
number = 1
module = "small"
[[slot]]
number = 2
module = "large"
[[slot]]
number = 3
module = "amci3601"
"""
RUNGS = """PROGRAM line
ROUTINE Main
XIO(S:FS)OTE(Local:2:O.Data[30].0);
MUL(Local:2:I.Data[30],7,Local:2:O.Data[29]);
END
"""


def test_a_page_from_a_file_has_all_words_of_modules_of_any_size(page, tmp_path):
    """From scan 1 on 2 ms a scan are counted in the last word of 31; seven times that is sent."""
    (tmp_path / "sized.py").write_bytes((Path(__file__).parents[1] / "support" / "sized.py").read_bytes())
    (tmp_path / "line.rung").write_text(RUNGS, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(SIZED, encoding="utf-8")
    for words in (
        ["run", tmp_path / "rack.toml", "--scans", 100, "--record", tmp_path / "run.mcap", "-q"],
        ["share", tmp_path / "run.mcap", "--trust"],
    ):
        done = CliRunner().invoke(build(), [str(each) for each in words])
        assert done.exit_code == 0, done.output
    page.browser.get((tmp_path / "run.html").as_uri())
    page.until_scan(99, "past")
    look(page, 40)
    shown = page.run(f"{NAMED}return (await named('run')).words")
    counted = 2 * (40 - 1)
    assert [len(shown[slot]) for slot in ("1", "2", "3")] == [4, 62, 16]
    assert (shown["2"][30], shown["2"][31 + 29], shown["2"][61]) == (counted, 7 * counted, 1)
    page.until_value("2.COUNT", "1")
    _, _, lanes = page.run(STEPS, 99, "Local:2:O.Data[30].0")
    assert lanes["Local:2:O.Data[30].0"] == [[0, 0], [2_000_000, 1]]
    assert page.messages() == []


STEPS = f"""
{NAMED}const ask = await named("ask"), [to, ...tags] = arguments;
const {{ unknown, addresses }} = await ask("watch", {{ tags }});
return [unknown, addresses, (await ask("steps", {{ from: 0, to, tags }})).lanes.tags];
"""


def test_a_name_of_a_bit_is_its_address_in_its_strip(page, shared, feeder_rack):
    """The first word of a configuration has its bits, too: they are those of the image."""
    page.browser.get(shared.as_uri())
    page.until_scan(SCANS - 1, "past")
    name, address = "slot1.status.MOVING_CW", "Local:1:I.Data[0].0"
    unknown, addresses, lanes = page.run(STEPS, SCANS - 1, name, "Nothing")
    assert (unknown, addresses) == (["Nothing"], {name: address})
    bench = open_bench(feeder_rack)
    expected: list[list[int]] = []
    for scan in range(SCANS):
        bench.scan()
        level = bench.slot[1].inputs[0] & 1
        if not expected or expected[-1][1] != level:
            expected.append([scan * 2_000_000, level])
    assert lanes == {name: expected}


def test_its_policy_refuses_connections(page, shared):
    page.browser.get(shared.as_uri())
    page.until_scan(SCANS - 1, "past")
    refused = "return fetch(arguments[0]).then(() => 'allowed', () => 'refused')"
    assert page.run(refused, "http://127.0.0.1:1/") == "refused"
    assert any("Content Security Policy" in each for each in page.messages())


def test_the_button_of_a_running_rack_writes_the_page_of_its_scan(page, feeder_rack, tmp_path):
    page.browser.execute_cdp_cmd(
        "Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)}
    )
    trace = tmp_path / "session.mcap"
    with watching(feeder_rack, "--record", trace, "--paused", "--time-scale", "max") as session:
        page.open(session.link, paused=True)
        page.step(SCANS + 2000)
        page.until_scan(SCANS + 1999, "paused")  # the recorder writes about 4,000 at a time
        page.press("Write a page to share")
        until(lambda: list(tmp_path.glob("*.html")))
        session.end()
    page.browser.get((tmp_path / "session.html").as_uri())
    page.until_handle("state", "past")
    assert 4000 <= int(page.handle("scan") or 0) < SCANS + 2000
    assert page.control("Copy link").is_enabled()


def test_the_page_of_a_failed_test_opens_on_what_failed(page, feeder_rack, tmp_path):
    """The second run has a slower stroke: its velocity differs from the first scan on."""
    program = tmp_path / "slow.rung"
    text = (FEEDER / "feeder.rung").read_text(encoding="utf-8")
    slow = tmp_path / "slow.toml"
    program.write_text(text.replace("OutGo,6000,4000,", "OutGo,6000,2000,"), encoding="utf-8")
    old = (FEEDER / "feeder.rung").as_posix()
    slow.write_text(feeder_rack.read_text(encoding="utf-8").replace(old, "slow.rung"), encoding="utf-8")
    for rack, name in ((feeder_rack, "passed.mcap"), (slow, "failed.mcap")):
        with open_bench(rack, record=tmp_path / name) as bench:
            bench.scan(1200)
    failure = Failure(
        "test_line.py::test_stroke", "Homing stays on\nfor ever", "Homing", tmp_path / "passed.mcap"
    )
    wish = ShareOptions(1199, trust=True, tags=["Homing"], failure=failure)
    share(tmp_path / "failed.mcap", tmp_path / "failed.html", wish)
    page.browser.get((tmp_path / "failed.html").as_uri())
    page.until_scan(1199, "past")
    said = page.run("return document.getElementById('failed').innerText")
    assert said.startswith("test_line.py::test_stroke failed")
    assert "Homing stays on\nfor ever" in said
    assert (
        "Differs from the last run that passed since scan 0, 00:00.000: Out.Profile.Velocity, Out.Velocity"
        in said
    )
    until(lambda: page.run("return document.querySelectorAll('#causes li').length") > 0)
    page.press("scan 0, 00:00.000")
    page.until_scan(0, "past")
    assert page.messages() == []
