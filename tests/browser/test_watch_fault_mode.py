"""Fault mode: the page stays at the scan of a fault or an error bit, marks the rung, opens the chain.

Broken on purpose: an error bit that is found a scan late, a page that goes on, a chain that stays closed.
"""

from watched_page import until, watching

RACK = """
name = "fault"
program = "fault.rung"
scan_ms = 2
watchdog_ms = 0
[[slot]]
number = 1
module = "1769-IQ16"
"""

PROGRAM = """\
PROGRAM F
TAG N : DINT
TAG Place : DINT
TAG A : DINT[4]
ROUTINE Main
ADD(N,1,N);
DIV(N,200,Place);
MOV(1,A[Place]);
END
"""
ALERT = "return document.querySelector('[role=alert]').textContent"
ANSWER = "return document.querySelector('#tag .answer').textContent"
CHAIN = "return [...document.querySelectorAll('#tag .chain li')].map(each => each.textContent)"
CAME = """
const error = { scan: 4001, t: 8002000000, slot: 1, bit: "INPUT_ERROR", tag: "Trouble", text: "", rule: "" };
return import("/faultmode.js").then(mode => mode.erred({ ...error, stopped: true }));
"""
SHOWN = "return document.querySelector(arguments[0])?.checkVisibility() ?? false"


def test_a_fault_opens_its_chain_and_a_branch_begins_one_second_before(page, tmp_path):
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "fault.rung").write_text(PROGRAM, encoding="utf-8")
    with watching(tmp_path / "rack.toml", "--time-scale", "max") as session:
        page.open(session.link)
        page.until_handle("mode", "fault")
        page.until_there("[data-at='Main.2'][data-fault][aria-current]")
        until(lambda: page.run(CHAIN))
        assert page.run(CHAIN)[0].startswith("00:01.598Place = 4 (Main rung 1: DIV(N,200,Place)")
        assert "subscript 4 is out of range" in page.run(ALERT)
        page.press("Branch one second before")
        page.until_scan(298, "paused")  # the fault is in scan 799; a second is 500 scans
        assert page.value("N") == "299"


COUNT = '''"""Counts."""


class State:
    count: int = 0


state = State()


def logic(scan):
    state.count += 1
    assert state.count < 9
'''


def test_a_fault_of_python_opens_the_chain_of_what_its_line_has_read(page, tmp_path):
    (tmp_path / "rack.toml").write_text(RACK.replace("fault.rung", "fault.py"), encoding="utf-8")
    (tmp_path / "fault.py").write_text(COUNT, encoding="utf-8")
    with watching(tmp_path / "rack.toml") as session:
        page.open(session.link)
        page.until_there("[data-at='fault.py.13'][data-fault]")
        until(lambda: page.run("return document.querySelector('#tag .name')?.textContent") == "state.count")
        until(
            lambda: (
                "state.count += 1" in page.run("return document.querySelector('#tag .answer').textContent")
            )
        )


def test_the_page_stays_at_the_first_error_bit_and_the_rack_goes_on(page, paused):
    page.open(paused.link, paused=True, stops=True)
    page.step(4100)  # the emergency stop comes at 8 s
    page.until_scan(4001, "past")
    assert page.value("1.INPUT_ERROR") == "1"
    assert "INPUT_ERROR came on at 00:08.002. The emergency stop" in page.run(ALERT)
    until(lambda: page.run(CHAIN))
    assert "IN_ESTOP on" in page.run(CHAIN)[0]
    page.press("Dismiss")
    page.until_scan(4099, "paused")
    assert not page.run(SHOWN, "[role=alert]")


def test_an_error_of_what_is_pressed_here_is_said_and_looked_at_by_hand(page, paused):
    page.open(paused.link, paused=True, stops=True)
    page.step(3100)  # in the middle of a stroke
    page.until_scan(3099, "paused")
    page.control("Press E-stop").send_keys("\ue007")
    page.step(50)
    page.until_scan(3149, "paused")  # it follows the scans
    until(lambda: "INPUT_ERROR came on" in page.run(ALERT))
    page.press("Look at it")
    page.until_handle("state", "past")
    error = int(page.handle("scan"))
    assert 3100 <= error <= 3102
    until(lambda: "the estop input is" in page.run(ANSWER))
    page.press("Branch one second before")
    page.until_scan(error - 501, "paused")


def test_a_page_that_shall_not_stop_follows_the_scans(page, paused):
    page.open(paused.link, paused=True, stops=True)
    page.click("[aria-label='Stop at errors']")
    page.step(4100)
    page.until_scan(4099, "paused")
    assert not page.run(SHOWN, "[role=alert]")
    page.run("return import('/scrub.js').then(scrub => scrub.lookAt(4001))")
    page.until_scan(4001, "past")
    page.run(CAME)  # the error was on its way when the page was told not to stop
    page.until_scan(4099, "paused")
    assert not page.run(SHOWN, "[role=alert]")
