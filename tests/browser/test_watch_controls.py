"""The page changes the run: key, transport, inputs, forces, breakpoints; all of it also by keyboard."""

from functools import partial

from watched_page import until, watching

ENTER = "\ue007"
NOTICE = "return document.getElementById('notice').textContent"


def keys(page, text):
    page.browser.switch_to.active_element.send_keys(text)


def body(page):
    page.run("document.activeElement.blur()")
    return page.browser.find_element("css selector", "body")


def test_pause_step_and_go_on(page, feeder):
    page.open(feeder.link)
    page.press("Pause")
    page.until_handle("state", "paused")
    scan = int(page.handle("scan"))
    page.press("Step")
    page.until_scan(scan + 1, "paused")
    body(page).send_keys(".")
    page.until_scan(scan + 2, "paused")
    body(page).send_keys(",")
    page.until_scan(scan + 1, "past")
    page.press("Live")
    page.until_scan(scan + 2, "paused")
    body(page).send_keys(" ")
    page.until_handle("state", "live")


def test_space_pauses_also_after_a_click_and_presses_what_tab_has_reached(page, feeder):
    page.open(feeder.link)
    page.until_handle("state", "live")
    page.until_drawn()
    page.press("Zoom out")
    page.until_drawn()
    keys(page, " ")
    page.until_handle("state", "paused")
    page.until_drawn()
    scan = int(page.handle("scan"))
    page.press("Step")
    page.until_scan(scan + 1, "paused")
    keys(page, " ")
    page.until_handle("state", "live")
    page.press("Pause")
    page.until_handle("state", "paused")
    page.run("arguments[0].focus()", page.control("Zoom in"))
    keys(page, "\ue004")  # Tab
    page.run("arguments[0].focus()", page.control("Continue"))
    keys(page, " ")
    page.until_handle("state", "live")


def test_the_key_is_turned(page, feeder):
    page.open(feeder.link)
    for mode in ("Program", "Test", "Run"):
        until(page.control(mode).is_enabled)
        page.until_drawn()  # what still moves is clicked beside
        page.press(mode)
        page.until_handle("mode", mode.lower())
        assert page.control(mode).get_attribute("aria-pressed") == "true"


def test_speed(page, feeder):
    page.open(feeder.link)
    chosen = "return document.querySelector('[aria-label=Speed]').value"
    expected = "return import('/state.js').then(({ run }) => run.speed.requested === arguments[0])"
    for factor in (2, 1):  # what a busy machine reaches is another matter
        page.choose("Speed", str(factor))
        until(partial(page.run, expected, factor))
        assert page.run(chosen) == str(factor)
        assert float(page.handle("speed")) > 0


def test_an_input_is_pressed(page, feeder):
    page.open(feeder.link)
    assert page.value("1.IN_EXTERNAL") == "0"
    page.control("Press External").send_keys(ENTER)  # by mouse a slow click would be a hold
    until(lambda: page.value("1.input.external") == "1")
    assert page.control("Press External").get_attribute("aria-pressed") == "true"
    page.control("Press External").send_keys(ENTER)
    until(lambda: page.value("1.input.external") == "0")


def test_a_switch_is_held_against_the_machine_and_given_back(page, feeder):
    page.open(feeder.link)
    page.control("Press CW limit").send_keys(ENTER)
    until(lambda: page.value("1.IN_CW_LIMIT") == "1")
    assert page.control("Press CW limit").get_attribute("aria-pressed") == "true"
    page.control("Press CW limit").send_keys(ENTER)
    until(lambda: page.value("1.IN_CW_LIMIT") == "0")


def test_a_tag_is_forced_and_released(page, feeder):
    page.open(feeder.link)
    page.until_there("[data-element='Main.2.1']")
    page.click("[data-element='Main.2.1']")  # OTE(Trouble)
    until(lambda: page.value("Trouble") == "0")  # the feeder recovers from the test before
    page.press("Force")
    until(lambda: page.value("Trouble") == "1")
    forced = (
        "return [...document.querySelectorAll('[data-forced][data-name]')].map(each => each.dataset.name)"
    )
    until(lambda: set(page.run(forced)) == {"Trouble"})
    page.press("Remove force")
    until(lambda: page.value("Trouble") == "0" and page.run(forced) == [])
    body(page).send_keys("f")
    until(lambda: page.run(forced) != [])
    body(page).send_keys("f")
    until(lambda: page.run(forced) == [])


def test_a_value_is_written_and_nonsense_refused(page, feeder):
    page.open(feeder.link)
    page.watch("Strokes.ACC")
    page.click("//section[@id='watch']//tbody//button[text()='Strokes.ACC']", "xpath")
    page.control("New value").send_keys("16#40")
    page.press("Write")
    until(lambda: 64 <= int(page.value("Strokes.ACC") or 0) < 70)
    field = page.control("New value")
    field.clear()
    field.send_keys("many")
    page.press("Write")
    until(lambda: "many is not a value" in page.run(NOTICE))


def test_a_breakpoint_on_a_rung_pauses(page, paused):
    page.open(paused.link, paused=True)
    page.press("Step")
    page.until_there("[data-at='Main.9']")
    page.press("Breakpoint on rung 9")  # BackGo
    page.until_there("[data-at='Main.9'][data-breakpoint]")
    page.press("Continue")
    until(lambda: "rung 9 is true" in page.run(NOTICE))
    assert page.handle("state") == "paused"
    until(lambda: page.power()["Main.9.2"] == "1")
    body(page).send_keys("b")
    until(lambda: "Select a rung" in page.run(NOTICE))
    page.click("[data-at='Main.9']")
    body(page).send_keys("b")
    until(lambda: not page.run("return document.querySelector('[data-breakpoint]')"))
    page.press("Continue")
    page.until_handle("state", "live")


def test_the_watch_table_is_kept(page, feeder):
    page.open(feeder.link)
    page.watch("Axis.State")
    page.control("Radix of Axis.State").send_keys("hex")
    shown = "return document.querySelector('#watch td.value').textContent"
    until(lambda: page.run(shown).startswith("16#0000_"))
    page.open(feeder.link)
    until(lambda: page.run(shown).startswith("16#0000_"))
    page.press("Remove Axis.State")
    assert page.run("return document.querySelectorAll('#watch tbody tr').length") == 0


def test_help_shows_every_key(page, feeder):
    page.open(feeder.link)
    body(page).send_keys("?")
    shown = page.run(
        "return [...document.querySelectorAll('dialog[open] kbd')].map(each => each.textContent)"
    )
    assert shown == ["space", *".,[]←→↑↓mt10rwgulakbBxfpn+-ceEdD/", "F6", "Esc", "?"]
    page.press("Close help")
    assert not page.run("return document.querySelector('dialog[open]')")


def test_what_a_read_only_session_shows_can_be_looked_at_only(page, running_rack):
    with watching(running_rack, "--read-only") as session:
        page.open(session.link)
        for name in ("Run", "Program", "Test", "Pause", "Step", "Speed", "Press External"):
            assert not page.control(name).is_enabled()
        refused = page.run("return import('/orders.js').then(orders => orders.pause())")
        assert refused is None
        assert "read-only" in page.run(NOTICE)


EDGES = """
const rows = [...document.querySelectorAll("#strip .edges li")];
return rows.map(each => [Number(each.dataset.scan), each.dataset.value]);
"""


def test_pulses_of_one_scan_are_in_the_strip(page, tmp_path):
    """An input is pressed for one scan of 2 ms, every tenth scan, a hundred times."""
    scans = [10 * number for number in range(5, 105)]
    presses = "".join(f'  {{ at_ms = {2 * scan}, input = "pulse", for_ms = 2 }},\n' for scan in scans)
    (tmp_path / "idle.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    (tmp_path / "rack.toml").write_text(
        'name = "pulses"\nprogram = "idle.py"\nscan_ms = 2\nwatchdog_ms = 0\n'
        '[[slot]]\nnumber = 1\nmodule = "1769-IQ16"\n'
        f"[slot.options]\ninputs = {{ pulse = 0 }}\ntimeline = [\n{presses}]\n",
        encoding="utf-8",
    )
    with watching(tmp_path / "rack.toml", "--paused", "--time-scale", "2") as session:
        page.open(session.link, paused=True)
        page.press("Continue")
        until(lambda: int(page.handle("scan") or 0) > scans[-1] + 20)
        page.run("document.querySelector('#strip .edges').parentElement.open = true")
        until(lambda: len(page.run(EDGES)) > 2 * len(scans))
        shown = sorted(tuple(each) for each in page.run(EDGES))
        rises = [scan for scan, value in shown if value == "1"]
        assert rises == scans
        assert [scan for scan, value in shown if value == "0"][-len(scans) :] == [scan + 1 for scan in scans]
