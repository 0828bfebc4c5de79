"""A long run ends in a state from which another one has gone on to its end."""

from scanrack.jobs import ContactPress
from scanrack.jobs.fuzz import Scenario, TrialBench, eventually, never
from scanrack.jobs.fuzz.aim.edges import Edges
from scanrack.jobs.fuzz.aim.explored_states import CALM, ExploredStates
from scanrack.jobs.fuzz.aim.probe import Probe
from scanrack.runtime import RackSpec

MS = 1_000_000
CARD = {"number": 1, "module": "1769-IQ16", "options": {"inputs": {"start": 0}}}
SPEC = RackSpec.model_validate({"program": "none.py", "slot": [CARD]})
LONG = 4 * CALM


class Counts:
    """It counts presses up to three."""

    def __init__(self):
        self.count = 0
        self.before = False

    def __call__(self, scan):
        pressed = bool(scan.slot[1].inputs[0] & 1)
        self.count = min(3, self.count + (pressed and not self.before))
        self.before = pressed


def behind(press_ms):
    return (press_ms + 20) // 2 + 2


def run(explored, *presses_ms, asked=(), scans=LONG):
    pushes = tuple(ContactPress(1, "start", at * MS, 20 * MS) for at in presses_ms)
    bench = TrialBench(SPEC, Counts, asked, scans)
    return bench.run(Scenario(pushes=pushes), probe=Probe(Edges()), explored=explored)


def test_a_run_ends_where_another_has_been():
    explored = ExploredStates()
    assert run(explored).scans == LONG, "nothing is known yet"
    assert run(explored, 100).scans == LONG, "a press has been counted"
    assert run(explored, 500).scans == behind(500) + CALM, "the run before has gone on from there"
    assert run(explored, 50).scans == behind(50) + 2 * CALM, "it was there only later"
    assert run(explored, 50).scans == behind(50) + CALM
    assert run(explored, 100, 200).scans == LONG


def test_a_short_run_never_ends_early():
    explored = ExploredStates()
    for _ in range(2):
        assert run(explored, scans=CALM).scans == CALM


def test_a_running_clock_goes_on():
    @eventually("1000 s", after=lambda now: True)
    def comes(now):
        return False

    explored = ExploredStates()
    for _ in range(2):
        assert run(explored, 100, asked=[comes]).scans == LONG


def test_what_has_broken_something_is_no_state_to_end_in():
    @never
    def late(now):
        return now.scan == LONG - 1

    explored = ExploredStates()
    for _ in range(2):
        verdict = run(explored, asked=[late])
        assert verdict.broken is not None
        assert verdict.scans == LONG
