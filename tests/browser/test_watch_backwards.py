"""Backwards: the past of a session, another way from a scan of it, and recordings in the same page."""

import time
from functools import partial

import pytest
from watched_page import steadily, until, watching


def test_a_branch_goes_another_way_from_a_scan_of_the_past(page, paused):
    page.open(paused.link, paused=True)
    page.step(2000)
    page.until_scan(1999, "paused")
    page.run("location.hash += '&scan=1200'")
    page.until_scan(1200, "past")
    power, strokes = page.power(), page.value("Strokes.ACC")
    page.press("Branch from here")
    page.until_scan(1200, "paused")
    page.until_there("svg.rung")
    page.until_power(power)
    assert page.value("Strokes.ACC") == strokes
    assert "scan=" not in page.browser.current_url
    page.press("Step")
    page.until_scan(1201, "paused")


def test_what_stands_beside_a_scan_of_the_past_is_of_that_scan(page, paused):
    page.open(paused.link, paused=True)
    page.step(2000)
    page.until_scan(1999, "paused")
    events = "return [...document.querySelectorAll('.events li')].map(each => Number(each.dataset.scan))"
    cart = "return document.querySelector('.cart').getAttribute('visibility')"
    until(lambda: max(page.run(events), default=0) > 1600)
    before = page.run(events)
    assert page.run(cart) == "visible"
    page.click("[data-element='Main.7.0']")  # Configure.Done
    page.run("location.hash += '&scan=1200'")
    page.until_scan(1200, "past")
    until(lambda: page.run(events) == [each for each in before if each <= 1200])
    assert page.run(cart) == "hidden"  # where the shaft was is not recorded
    assert page.value("1.shaft") == ""
    page.press("Why")
    until(lambda: page.run("return document.querySelector('#tag .answer')?.textContent ?? ''"))
    page.press("Live")
    page.until_scan(1999, "paused")
    assert page.run("return document.querySelector('#tag .answer button').textContent") == "In scan 1,200:"
    page.press("In scan 1,200:")
    page.until_scan(1200, "past")
    page.press("Live")
    until(lambda: page.run(events) == before)


@pytest.fixture
def recording(tmp_path, feeder_rack):
    from scanrack.commands import build
    from typer.testing import CliRunner

    trace = tmp_path / "run.mcap"
    words = ["run", str(feeder_rack), "--record", str(trace), "--for", "15 s"]
    assert CliRunner().invoke(build(), words).exit_code == 0
    return trace


def test_a_recording_is_opened_at_a_scan_and_a_rung(page, recording):
    with watching(recording) as session:
        page.open(f"{session.link}&scan=1700&rung=Main.9")
        page.until_scan(1700, "past")
        until(
            lambda: (
                page.run("return document.querySelector('[data-at][aria-current]')?.dataset.at") == "Main.9"
            )
        )
        until(lambda: page.power().get("Main.9.2") == "1")  # BackGo since scan 1697
        for name in ("Run", "Program", "Force", "Press External"):
            assert not steadily(partial(enabled, page, name))


def enabled(page, name):
    """Return the enabled buttons with an accessible name."""
    controls = page.run("return [...document.querySelectorAll('button')]")
    return [each for each in controls if each.accessible_name == name and each.is_enabled()]


def stands(page):
    """Return whether the page shows the same scan for a while: at this speed it shows 15 in this time."""
    scan = page.handle("scan")
    time.sleep(0.3)
    return page.handle("scan") == scan


def test_a_recording_is_played(page, recording):
    with watching(recording) as session:
        page.open(f"{session.link}&scan=100")
        page.until_scan(100, "past")
        page.choose("Speed", "0.1")  # 148 s, so that a slow machine comes before the end
        page.press("Continue")
        until(lambda: int(page.handle("scan")) > 110)
        page.press("Pause")
        assert page.control("Continue").is_enabled()
        page.until_drawn()  # what it has requested has come
        until(lambda: stands(page))
        before = int(page.handle("scan"))
        page.press("Step")
        page.until_scan(before + 1, "past")


def test_the_slider_and_the_arrows_move_through_the_past(page, paused):
    page.open(paused.link, paused=True)
    page.step(1000)
    page.until_scan(999, "paused")
    drag = "arguments[0].value = 400; arguments[0].dispatchEvent(new Event('input', {bubbles: true}))"
    page.run(drag, page.control("Scan shown"))
    page.until_scan(400, "past")
    page.run("document.activeElement.blur()")
    body = page.browser.find_element("css selector", "body")
    for key, scan in ((".", 401), (",", 400), ("\ue014", 410), ("\ue012", 400), ("]", 900), ("[", 400)):
        body.send_keys(key)  # \ue014 and \ue012 are the arrows to the right and to the left
        page.until_scan(scan, "past")
