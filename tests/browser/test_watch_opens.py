"""The page opens: rungs, bits and rail are there, everything comes from this machine, nothing complains."""

import pytest
from watched_page import until

SHOWS = {
    "rungs": "svg.rung [data-element]",
    "bits": "[data-name='1.MOVE_COMPLETE'][data-value]",
    "rail": "svg.rail .cart",
    "strip": "canvas.chart",
}


@pytest.fixture
def opened(page, feeder):
    page.open(feeder.link)
    for selector in SHOWS.values():
        page.until_there(selector)
    return page


def test_everything_is_there_and_the_scans_go_on(opened):
    before = int(opened.handle("scan"))
    until(lambda: int(opened.handle("scan")) > before + 10)
    assert opened.handle("mode") == "run"
    assert opened.handle("state") == "live"
    assert int(opened.handle("time-ns")) % 2_000_000 == 0  # scans of 2 ms
    assert opened.run("return document.querySelectorAll('svg.rung').length") == 14
    assert opened.value("Awake") in ("0", "1")


def test_all_requests_are_ours_and_the_console_is_silent(opened, feeder):
    requested = opened.run("return performance.getEntriesByType('resource').map(each => each.name)")
    assert set(requested) - {f"{feeder.base}/icon.svg"} == {f"{feeder.base}/page.js"}
    policy = opened.run("return fetch('/').then(answer => answer.headers.get('content-security-policy'))")
    assert "default-src 'none'" in policy  # what is not ours is not loaded, and the console says so
    assert opened.messages() == []


def test_a_link_without_the_key_shows_why(page, feeder):
    page.browser.get(f"{feeder.base}/#key=00")
    until(lambda: "key" in page.run("return document.getElementById('notice').textContent"))
    assert page.handle("state") == "lost"
    assert page.handle("scan") is None


def test_a_link_opens_at_its_scan_and_rung(page, feeder):
    page.open(feeder.link)
    until(lambda: int(page.handle("scan")) > 200)
    page.open(f"{feeder.link}&scan=123&rung=Main.6")
    page.until_scan(123, "past")
    current = "return document.querySelector('[data-at][aria-current]')?.dataset.at"
    until(lambda: page.run(current) == "Main.6")
