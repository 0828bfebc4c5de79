"""Fault mode: the page stays at the scan of a fault or an error bit, marks the rung, opens the chain.

Broken on purpose: an error bit found a scan late, a page that always stops, a chain that stays closed.
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
LINE = "return document.querySelector('[role=alert]').textContent"
CAUSES = "return [...document.querySelectorAll('#causes li')].map(each => each.textContent)"
OPENED = "return document.getElementById('causes').textContent"
HEADLINE = """
return import("/selection.js").then(({ select }) => select({ tag: arguments[0] }))
  .then(() => document.querySelector("#tag .name").textContent);
"""
CAME = """
const error = { scan: 4001, t: 8002000000, slot: 1, bit: "INPUT_ERROR", tag: "Trouble", text: "", rule: "" };
return import("/causeband.js").then(band => band.erred({ ...error, stopped: true }));
"""
SHOWN = "return document.querySelector(arguments[0])?.checkVisibility() ?? false"


def test_a_fault_opens_its_chain_and_a_branch_begins_one_second_before(page, tmp_path):
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "fault.rung").write_text(PROGRAM, encoding="utf-8")
    with watching(tmp_path / "rack.toml", "--time-scale", "max") as session:
        page.open(session.link)
        page.until_handle("mode", "fault")
        page.until_there("[data-at='Main.2'][data-fault][aria-current]")
        until(lambda: page.run(CAUSES))
        assert page.run(CAUSES)[-1].startswith("2Place = 4 (00:01.598, Main rung 1: DIV(N,200,Place)")
        assert page.run(LINE).startswith("!3MOV(1,A[Place]): A[Place]: subscript 4 is out of range")
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
        until(lambda: "state.count += 1" in page.run(OPENED))


def test_a_page_follows_the_scans_at_an_error_and_stops_there_only_if_it_is_asked_to(page, paused):
    page.open(paused.link, paused=True)
    page.step(4100)  # the emergency stop comes at 8 s
    page.until_scan(4099, "paused")
    line = until(lambda: "IN_ESTOP" in (said := page.run(LINE)) and said)
    assert line.startswith("!INPUT_ERROR came onslot1.status.IN_ESTOP on: The emergency stop input")
    assert page.run("return document.querySelector('.band .when').textContent") == "00:08.002"
    assert not page.run(SHOWN, "#causes")
    page.click(".alert button")
    until(lambda: page.run(CAUSES))
    assert page.run(LINE) == "!2INPUT_ERROR came on"  # the first cause stands in the list alone
    assert [each[:25] for each in page.run(CAUSES)] == ["1slot1.status.IN_ESTOP on"]
    page.until_scan(4099, "paused")  # it is read without leaving the present
    assert page.run(HEADLINE, "Local:1:I.Data[0].11") == "slot1.status.INPUT_ERROR"
    page.press("Branch one second before")
    page.until_scan(3500, "paused")
    page.click("[aria-label='Stop at errors']")
    page.step(600)
    page.until_scan(4001, "past")
    assert page.value("1.INPUT_ERROR") == "1"
    until(lambda: page.run(CAUSES))
    page.press("Dismiss")
    page.until_scan(4100, "paused")
    assert not page.run(SHOWN, "[role=alert]")


def test_an_error_that_comes_while_the_switch_is_turned_off_leaves_the_page_live(page, paused):
    page.open(paused.link, paused=True)
    page.step(20)
    page.until_scan(19, "paused")
    page.run("return import('/scrub.js').then(scrub => scrub.lookAt(10))")
    page.until_scan(10, "past")
    page.run(CAME)
    page.until_scan(19, "paused")
    assert not page.run(SHOWN, "[role=alert]")


def test_late_scans_say_why_and_what_to_do(page, running_rack):
    with watching(running_rack, "--time-scale", "1000") as session:  # 2 µs a scan
        page.open(session.link)
        until(lambda: "More than 5 % of scans begin late" in page.run(LINE))
        page.click(".alert button")
        assert "Use a lower speed, or a slower scan (scan_ms)." in page.run(OPENED)
        page.choose("Speed", "max")  # nothing is late then
        until(lambda: not page.run(SHOWN, ".alert"))


BEHIND = """
return Promise.all([import('/state.js'), import('/causeband.js')]).then(([state, band]) => {
  state.take({ state: 'live' });
  const bit = { slot: 1, bit: 'INPUT_ERROR', tag: 'X', text: '', rule: '' };
  band.erred({ scan: 19, t: 38000000, ...bit, stopped: true });
});
"""
"""An error that stops the page comes before a frame of the present is painted."""


def test_a_frame_from_before_the_stop_does_not_take_the_error_away(page, paused):
    page.open(paused.link, paused=True)
    page.step(20)
    page.until_scan(19, "paused")
    page.click("[aria-label='Stop at errors']")
    page.run(BEHIND)
    until(lambda: page.run("return import('/state.js').then(state => state.isPainted())"))
    assert page.run(SHOWN, "[role=alert]")
    assert page.run(LINE).startswith("!INPUT_ERROR came on")
