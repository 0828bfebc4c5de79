"""A session that somebody clicked, as the scenario that `scanrack fuzz` varies."""

from live_sessions import FEEDER, LiveSession
from scanrack.jobs.fuzz.learning import learn
from scanrack.runtime import FaultKind

MS = 1_000_000
PANEL = FEEDER.parents[1] / "three_stations_panel" / "line.toml"


def learned(tmp_path, orders, scans, rack=FEEDER):
    path = tmp_path / "session.mcap"
    answers = LiveSession(orders, path, rack=rack).play(scans).answers
    assert all(answer.get("ok") for answer in answers)
    scans_of = [answer["scan"] for answer in answers]
    return learn(path, tmp_path / "files", trust=True).scenario, [scan * 2 * MS for scan in scans_of]


def test_a_pressed_button_an_incident_and_the_key_are_parts_of_the_scenario(tmp_path):
    press = {"do": "press", "slot": 1, "name": "estop", "on": True}
    orders = [
        (100, press),
        (200, {**press, "on": None}),
        (300, {"do": "incident", "slot": 1, "kind": "link-lost", "for_ms": 40}),
        (400, {"do": "mode", "mode": "program"}),
        (450, {"do": "mode", "mode": "run"}),
    ]
    scenario, at = learned(tmp_path, orders, 600)
    (pressed,) = scenario.presses
    assert (pressed.slot, pressed.input.name, pressed.for_ns) == (1, "ESTOP", at[1] - at[0])
    lost, turned = scenario.incidents
    assert (lost.what, lost.at_ns, lost.for_ns) == (FaultKind.LINK_LOST, at[2], 40 * MS)
    assert (turned.what, turned.at_ns, turned.for_ns) == (FaultKind.PROGRAM_MODE, at[3], at[4] - at[3])


def test_a_contact_of_a_card_is_pushed_while_its_level_is_not_that_of_rest(tmp_path):
    start = {"do": "press", "slot": 2, "name": "start", "on": True}
    stop = {"do": "press", "slot": 2, "name": "stop", "on": False}  # normally closed
    orders = [(10, start), (20, {**start, "on": False}), (30, stop), (50, {**stop, "on": True})]
    scenario, at = learned(tmp_path, orders, 100, PANEL)
    told = [(each.input, each.at_ns, each.for_ns) for each in scenario.pushes]
    assert ("start", at[0], at[1] - at[0]) in told
    assert ("stop", at[2], at[3] - at[2]) in told
