"""Sessions: orders between scans, pauses, steps, speeds, breakpoints; and the same session run again.

Broken on purpose: orders that act one scan late, orders that are not announced, a step that counts the scans
before it: each turns a test red.
"""

import random

import pytest
from live_sessions import FEEDER, LiveSession
from scanrack.commands import build
from scanrack.runtime import CpuFault
from scanrack.runtime.live.actions import Online, action_of
from scanrack.traces import open_trace, read_columns
from typer.testing import CliRunner


def scans_of(path):
    with open_trace(path) as trace:
        return read_columns(trace)


@pytest.mark.slow
def test_a_session_without_orders_is_a_run(tmp_path):
    LiveSession(trace=tmp_path / "live.mcap").play(2000)
    done = CliRunner().invoke(
        build(), ["run", str(FEEDER), "--scans", "2000", "--record", str(tmp_path / "run.mcap"), "-q"]
    )
    assert done.exit_code == 0
    live, run = scans_of(tmp_path / "live.mcap"), scans_of(tmp_path / "run.mcap")
    assert (live.words == run.words).all()
    assert (live.flags == run.flags).all()


def test_an_order_acts_before_the_scan_that_its_answer_names(tmp_path):
    path = tmp_path / "live.mcap"
    order = {"do": "force", "tag": "Local:1:I.Data[7]", "value": 77}
    session = LiveSession([(100, order)], path).play(200)
    (answer,) = session.answers
    column = scans_of(path).words[:, 15].tolist()  # input word 7 of slot 1
    assert answer == {"id": 100, "ok": True, "scan": column.index(77)}
    assert set(column[answer["scan"] :]) == {77}


def test_a_pressed_button_is_seen_by_the_scan_after_its_tick(tmp_path):
    """The module looks at its inputs every 250 µs: pressed before scan n, the level shows in scan n."""
    path = tmp_path / "live.mcap"
    press = {"do": "press", "slot": 1, "name": "estop", "on": True}
    release = {**press, "on": None}
    session = LiveSession([(3000, press), (3001, release)], path).play(3100)
    first, second = (each["scan"] for each in session.answers)
    levels = scans_of(path).words[100:, 9] >> 3 & 1  # status LSW, IN_ESTOP, behind the configuration
    assert (levels.nonzero()[0] + 100).tolist() == [first]
    assert second == first + 1


def test_a_pause_ends_behind_the_scan_and_steps_run_as_many_as_wanted():
    orders = [(50, {"do": "pause"}), (0, {"do": "step", "scans": 7}), (58, {"do": "step"})]
    session = LiveSession(orders).play()
    assert [answer["scan"] for answer in session.answers] == [51, 51, 58]
    assert session.run.cpu.scan == 59


def test_press_step_release_is_a_pulse_though_all_three_come_at_once(tmp_path):
    """A module looks at its inputs every 250 µs: scan 3000 sees what was pressed before it."""
    path = tmp_path / "live.mcap"
    press = {"do": "press", "slot": 1, "name": "estop", "on": True}
    orders = [(3000, {"do": "pause"}), (0, press), (0, {"do": "step"}), (0, {**press, "on": None})]
    LiveSession([*orders, (0, {"do": "go"})], path).play(3100)
    levels = scans_of(path).words[100:, 9] >> 3 & 1
    assert levels.sum() == 1


def test_a_step_is_answered_when_its_scans_are_done_or_something_else_ends_it():
    orders = [(0, {"do": "step", "scans": 20}), (5, {"do": "speed", "factor": 2}), (9, {"do": "pause"})]
    session = LiveSession(orders).play(paused=True)
    told = [each["answer"]["id"] for each in session.told if "answer" in each]
    assert told == [5, 0, 9]  # the pause ends the step, and is answered itself


def test_a_session_may_begin_with_a_pause():
    session = LiveSession([(0, {"do": "step", "scans": 3})]).play(paused=True)
    assert session.run.cpu.scan == 3


def test_a_breakpoint_on_a_tag_pauses_behind_the_scan_in_which_it_changes():
    orders = [(0, {"do": "breakpoint", "at": "Homing"})]
    session = LiveSession(orders).play()
    states = [each["state"] for each in session.told if "state" in each]
    assert "Homing was 0 and is 1" in states[-1]["met"][0]
    assert session.program.tags["Homing"] is True


def test_a_breakpoint_on_a_rung_is_met_and_can_be_taken_away():
    orders = [
        (0, {"do": "breakpoint", "at": "Main.0"}),
        (0, {"do": "unbreak", "at": "Main.0"}),
        (0, {"do": "step", "scans": 5}),
    ]
    session = LiveSession(orders).play()
    assert not session.refusals
    assert session.session.state.breakpoints == []


def test_a_removed_breakpoint_sets_no_other_again(monkeypatch):
    """Main.0 and main.0 are one breakpoint: it goes with the last of its names."""
    set_at = ("Main.0", "main.0", "Main.1 changes", "Homing")
    orders = [(0, {"do": "breakpoint", "at": at}) for at in set_at]
    session = LiveSession([*orders, (0, {"do": "unbreak", "at": "main.0"})])
    calls = []
    for name in ("break_at", "break_on", "clear_breakpoints", "remove_breakpoint"):
        monkeypatch.setattr(session.program, name, lambda *at, name=name: calls.append((name, *at)))
    with session.ports:
        session.session.obey_all(0, 0)
        assert session.session.state.breakpoints == ["Main.0", "Main.1 changes", "Homing"]
        assert [name for name, *_at in calls] == ["break_at", "break_at", "break_at", "break_on"]
        calls.clear()
        for at in ("Main.0", "Main.1 changes", "Homing"):
            session.session.obey(action_of({"do": "unbreak", "at": at}), 0, 0)
    assert calls == [
        ("remove_breakpoint", "Main", 0, "true"),
        ("remove_breakpoint", "Main", 1, "changes"),
        ("remove_breakpoint", "Homing", None, "true"),
    ]


REFUSED = [
    ({"do": "press", "slot": 9, "name": "home", "on": True}, "slot 9 is empty: modules sit in 1"),
    ({"do": "press", "slot": 1, "name": "door", "on": True}, "no input 'door'"),
    ({"do": "write", "tag": "Nothing", "value": 1}, "no tag Nothing"),
    ({"do": "write", "tag": "Homing", "value": "yes"}, "Homing"),
    ({"do": "write", "tag": "Local:1:O.Data[0]", "value": 1}, "force it instead"),
    ({"do": "force", "tag": "Local:1:I.Data[0]", "value": 70_000}, "a word is -32768 to 65535"),
    ({"do": "force", "tag": "Local:1:I.Data[0].3", "value": 0.5}, "must be a whole number"),
    ({"do": "unforce", "tag": "Homing"}, "Homing is not forced"),
    ({"do": "breakpoint", "at": "Main.99"}, "has no rung 99"),
    ({"do": "breakpoint", "at": "Nowhere.1"}, "no routine Nowhere"),
    ({"do": "unbreak", "at": "Main.1"}, "no breakpoint at Main.1"),
    (
        {"do": "incident", "slot": 1, "kind": "line-down"},
        "line-down does not apply to Amci3601",
    ),
    ({"do": "incident", "slot": 1, "kind": "torn-update"}, "late_words and torn-update go together"),
    ({"do": "reload"}, "can't be edited while it runs"),
    ({"do": "nonsense"}, "no action 'nonsense'"),
]


@pytest.mark.parametrize(("order", "says"), REFUSED, ids=lambda each: str(each)[:50])
def test_what_cannot_be_carried_out_is_answered_and_the_scans_go_on(order, says):
    session = LiveSession([(10, order)]).play(30)
    (refusal,) = session.refusals
    assert says in refusal
    assert session.run.cpu.scan == 30
    assert session.run.cpu.fault is None


@pytest.mark.parametrize("text", [b"", b"{", b"[]", b"null", b'{"id":1}', b'{"order":{}}', b"\xff", b"1e999"])
def test_nonsense_from_the_monitor_is_answered(text):
    session = LiveSession([(10, text)]).play(30)
    assert len(session.refusals) == 1
    assert session.run.cpu.scan == 30


@pytest.mark.parametrize("order", [{"do": "pause"}, {"do": "step"}, {"do": "speed", "factor": 2}])
def test_with_real_ports_there_is_no_pause_no_step_and_no_speed(order):
    session = LiveSession([(10, order)], live=True).play(30)
    assert "a real controller does not wait" in session.refusals[0]


def fifty_orders(seed):
    """Return orders that a person may give: each with the scan that has to be reached first."""
    dice = random.Random(seed)
    kinds = [
        lambda: {"do": "press", "slot": 1, "name": dice.choice(["estop", "home", "capture"]), "on": True},
        lambda: {"do": "press", "slot": 1, "name": dice.choice(["estop", "home", "capture"]), "on": None},
        lambda: {"do": "mode", "mode": dice.choice(["run", "program", "test", "run"])},
        lambda: {"do": "pause"},
        lambda: {"do": "go"},
        lambda: {"do": "step", "scans": dice.randrange(1, 40)},
        lambda: {"do": "speed", "factor": dice.choice([300, 1000, "max"])},
        lambda: {"do": "write", "tag": "Homing", "value": dice.choice([True, False])},
        lambda: {"do": "force", "tag": dice.choice(["Awake", "Homing"]), "value": dice.choice([0, 1])},
        lambda: {"do": "force", "tag": "Local:1:I.Data[0].7", "value": dice.choice([0, 1])},
        lambda: {"do": "unforce", "tag": "all"},
        lambda: {"do": "incident", "slot": 1, "kind": "power-cycle"},
        lambda: {"do": "incident", "slot": 1, "kind": "link-lost", "for_ms": 30},
        lambda: {"do": "incident", "slot": 1, "kind": "torn-update", "late_words": [1, 2]},
        lambda: {"do": "breakpoint", "at": "Homing"},
        lambda: {"do": "unbreak", "at": "all"},
    ]
    at = sorted(dice.randrange(1, 3000) for _ in range(50))
    return [(scan, dice.choice(kinds)()) for scan in at]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_session_of_fifty_orders_runs_again_byte_for_byte(tmp_path, seed):
    path, again = tmp_path / "live.mcap", tmp_path / "again.mcap"
    orders = [*fifty_orders(seed), (3000, {"do": "unbreak", "at": "all"}), (3000, {"do": "go"})]
    session = LiveSession(orders, path).play(4000)
    assert session.run.cpu.scan == 4000
    assert effects_before_their_order(path) == []
    late = scans_of(path).flags >> 5 & 1
    done = CliRunner().invoke(
        build(), ["replay", "--into", "session", str(path), "--record", str(again), "-q"]
    )
    assert done.exit_code == 0, done.output
    if not late.any():
        assert path.read_bytes() == again.read_bytes()


def effects_before_their_order(path):
    """Return what a recording stamps earlier than an order of the same scan."""
    with open_trace(path) as trace:
        told = [(each.scan, each.now_ns, each.topic, each.fields) for each in trace.events()]
    given = {scan: now_ns for scan, now_ns, topic, _ in told if topic == "/orders"}
    return [each for each in told if each[1] < given.get(each[0], 0)]


def test_a_switch_that_is_pressed_changes_at_the_time_of_the_order(tmp_path):
    path = tmp_path / "live.mcap"
    LiveSession([(1711, {"do": "press", "slot": 1, "name": "estop", "on": True})], path).play(1720)
    with open_trace(path) as trace:
        told = {each.topic: (each.scan, each.now_ns) for each in trace.events() if each.scan == 1712}
    assert told["/orders"] == told["/stimuli"] == (1712, 1711 * 2_000_000)


def test_orders_are_recorded_with_the_scan_before_which_they_act(tmp_path):
    path = tmp_path / "live.mcap"
    orders = [(10, {"do": "force", "tag": "Homing", "value": 1}), (20, {"do": "pause"}), (0, {"do": "go"})]
    session = LiveSession(orders, path).play(40)
    with open_trace(path) as trace:
        told = [(each.scan, each.fields["name"]) for each in trace.events() if each.topic == "/orders"]
    answered = [answer["scan"] for answer in session.answers]
    assert told == list(zip(answered, ["force", "pause", "go"], strict=True))


def test_a_refused_order_is_not_recorded(tmp_path):
    path = tmp_path / "live.mcap"
    LiveSession([(10, {"do": "write", "tag": "Nothing", "value": 1})], path).play(40)
    with open_trace(path) as trace:
        assert [each for each in trace.events() if each.topic == "/orders"] == []


def test_a_fault_of_the_cpu_is_shown_until_the_session_ends(tmp_path):
    rack = tmp_path / "bad.toml"
    rack.write_text(
        'program = "bad.py"\nscan_ms = 2\n[[slot]]\nnumber = 1\nmodule = "amci3601"\nfirmware = "4.1"\n',
        encoding="utf-8",
    )
    (tmp_path / "bad.py").write_text(
        "def logic(scan):\n    assert scan.number < 5, 'on purpose'\n", encoding="utf-8"
    )
    orders = [(6, {"do": "go"}), *((0, {"do": "online", "step": each}) for each in ("test", "save"))]
    session, steps = LiveSession(orders, rack=rack), []
    session.session.edit = lambda order, _reply: steps.append(order)
    with pytest.raises(CpuFault, match="on purpose"):
        session.play()
    assert steps == [Online("save")]
    states = [each["state"] for each in session.told if "state" in each]
    assert "on purpose" in states[-1]["fault"]
    assert ["the CPU has faulted" in each for each in session.refusals] == [True, True]
