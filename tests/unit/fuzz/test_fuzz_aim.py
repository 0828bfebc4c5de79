"""The search knows where a run changes, aims there, and does the same under any hash seed."""

from __future__ import annotations

import hashlib
import pickle
from random import Random
from textwrap import dedent

import pytest
from planted_programs import version_of
from scanrack.io_images.amci3601 import Configuration, Idle, InputBit, PresetPosition
from scanrack.jobs import Kind, State, kinds_for, load_program
from scanrack.jobs.fuzz import Scenario, SearchReport, TrialBench, search
from scanrack.jobs.fuzz.aim.branches import NAME, branches_noted
from scanrack.jobs.fuzz.aim.corpus import Corpus, Entry, trim
from scanrack.jobs.fuzz.aim.draws import Draws
from scanrack.jobs.fuzz.aim.edges import NEAR, TOGETHER, Edges
from scanrack.jobs.fuzz.aim.probe import Probe
from scanrack.jobs.fuzz.aim.sweep import Sweep
from scanrack.jobs.fuzz.aim.times import times_of
from scanrack.jobs.fuzz.campaign.campaign import _search_tasks
from scanrack.jobs.fuzz.campaign.fresh import run_in_fresh_process
from scanrack.jobs.fuzz.explain.changes import changes_in
from scanrack.jobs.fuzz.scenarios.parts import timed_parts
from scanrack.jobs.fuzz.scenarios.scenario import Press
from scanrack.runtime import RackSpec, SlotSpec

SPEC = RackSpec(program=lambda scan: None, slot=(SlotSpec(number=1, module="amci3601"),))


def probed(bench):
    edges = Edges()
    bench.run(Scenario(), probe=Probe(edges))
    edges.close()
    return edges


def test_a_timer_of_700_scans_is_an_edge_and_its_done_bit_a_thin_state(tmp_path):
    """1.4 s at 2 ms a scan: done in scan 700, for one scan; timed again from 701 on, done in 1402."""
    edges = probed(version_of("lost_request", tmp_path / "it", with_mistake=False).bench)
    done = [scans for (_, _, value), scans in edges.groups["state"].items() if value is True]
    assert [700, 1402] in done
    assert [700, 1402] in edges.groups["thin"].values()
    assert [700, 1402] in edges.groups["path"].values(), "the rungs that ask for it"


def a_preset(scan):
    """Configure the module in scans 0 to 3, and preset its position to 3,000 in scan 10."""
    used = InputBit.HOME | InputBit.CW_LIMIT
    words = Configuration(inputs_used=used, step_and_direction=True, starting_speed=500)
    command = PresetPosition(3_000) if scan.number == 10 else Idle()
    scan.slot[1].outputs.load((words if scan.number < 4 else command).to_image())


PRESETTING = TrialBench(SPEC, lambda: a_preset, (), 40)


def test_the_thousands_of_a_position_take_a_step_in_the_scan_after_its_preset():
    """3,000 is 3 in the upper word and 0 in the lower one, before it is 0 in both."""
    assert probed(PRESETTING).groups["number"] == {0: [11]}


def test_a_scan_is_told_by_what_began_came_on_and_went_off_in_it():
    """The home input is on for 4 scans of 2 ms; the module shows each level one scan later."""
    held = Scenario(presses=(Press(1, InputBit.HOME, True, 20 * SPEC.scan_ns, 4 * SPEC.scan_ns),))
    told = {scan: changes_in(PRESETTING, held, scan) for scan in range(19, 27)}
    assert {scan: lines for scan, lines in told.items() if lines} == {
        20: ("0.04 s: input home of slot 1 is on for 8 ms",),
        21: ("IN_HOME of slot 1 came on",),
        25: ("IN_HOME of slot 1 went off",),
    }


def test_times_are_aimed_at_edges():
    edges = Edges()
    for scan in (3_000, 5_000):
        edges.add("state", "it", scan)
    draws = Draws(SPEC, 10_000, frozenset(Kind), Random(1))
    starts = [
        part.at_ns // SPEC.scan_ns for _ in range(300) for part in timed_parts(draws.scenario(edges))[:1]
    ]
    near = {edge + distance for edge in (3_000, 5_000) for distance in NEAR}
    assert sum(scan in near for scan in starts) > len(starts) / 4  # by chance one in 500
    assert len(set(starts) - near) > 50


def test_no_part_is_impossible():
    """A scenario of each kind alone fits the rack, and no event begins after the run."""
    for kind in Kind:
        draws = Draws(SPEC, 100, {kind}, Random(7))
        for _ in range(50):
            drawn = draws.scenario()
            drawn.check(SPEC)
            assert all(part.at_ns < 100 * SPEC.scan_ns for part in timed_parts(drawn))
            assert Scenario.from_json(drawn.to_json()) == drawn


def test_a_python_program_notes_its_branches_and_keeps_its_lines(tmp_path):
    (tmp_path / "it.py").write_text(
        dedent('''\
            """A program."""
            from __future__ import annotations
            steps = {"step": 0}
            def logic(scan):
                if scan.number == 10:
                    steps["step"] = 1
                elif scan.number == 12:
                    steps["step"] = 2
                for place in range(scan.number == 20):
                    pass
                if scan.number == 30:
                    raise ValueError("here")
            '''),
        encoding="utf-8",
    )
    with branches_noted():
        logic = load_program(str(tmp_path / "it.py")).function
    assert len(logic.__globals__[NAME]) == 6  # if, elif, no else; for; if, no else
    bench = TrialBench(SPEC, lambda: logic, (), 40)
    broken = bench.run(Scenario()).broken
    assert broken is not None
    assert broken.cause == "it.py:12"
    logic.__globals__["steps"]["step"] = 0
    edges = probed(bench)
    # each path begins in its scan; in the next one it is the usual path again
    assert sorted(edges.groups["path"].values()) == [[0, 11, 13, 21], [10], [12], [20], [30]]
    assert [10] in edges.groups["state"].values()


def steps_of_a_search(count: int) -> str:
    """Return a digest of what is drawn, for another process."""
    edges = Edges()
    for scan, name in enumerate(("b", "a", ("c", 1), None, True)):
        edges.add("state", name, 10 * scan)
    edges.close()
    draws = Draws(SPEC, 1_000, kinds_for(SPEC), Random(3))
    digest = hashlib.sha256()
    scenario = Scenario()
    for number in range(count):
        scenario = draws.scenario(edges, scenario if number % 3 else None)
        digest.update(repr(scenario.to_json()).encode())
    return digest.hexdigest()


@pytest.mark.slow
def test_a_thousand_steps_are_the_same_under_another_hash_seed():
    assert run_in_fresh_process(steps_of_a_search, 1_000) == steps_of_a_search(1_000)


def test_the_first_run_is_undisturbed_and_counts(tmp_path):
    version = version_of("lost_request", tmp_path / "it", with_mistake=True)
    report = search(version.bench, version.kinds, examples=3)
    assert report.runs == 3
    assert report.found == []


def press(bit, scan):
    return Press(1, bit, True, scan * SPEC.scan_ns, 2 * SPEC.scan_ns)


def shown(**scans):
    """The edges of a run in which steps were reached, by name and scan."""
    edges = Edges()
    for name, scan in scans.items():
        edges.add("state", (0, name, 1), scan)
    edges.close()
    return edges


def test_what_is_new_is_kept_up_to_where_it_was_new():
    corpus = Corpus()
    early, late = press(InputBit.HOME, 20), press(InputBit.HOME, 90)
    scenario = Scenario(presses=(early, late))
    entry = corpus.take(scenario, shown(a=50), SPEC.scan_ns)
    assert entry is not None
    assert entry.scenario == Scenario(presses=(early,))
    assert entry.points == [50]
    assert corpus.take(scenario, shown(a=10), SPEC.scan_ns) is None
    assert len(corpus.entries) == 1


def test_trimming_leaves_what_the_new_thing_needs_and_makes_it_early():
    """Step b needs the home input; the press of the estop and the wait before are left out."""
    needed, other = press(InputBit.HOME, 400), press(InputBit.ESTOP, 300)

    def run(scenario):
        starts = [each.at_ns // SPEC.scan_ns for each in scenario.presses if each.input is InputBit.HOME]
        return shown(**{"b": starts[0] + 10} if starts else {})

    corpus = Corpus()
    entry = corpus.take(Scenario(presses=(other, needed)), shown(b=410), SPEC.scan_ns)
    assert entry is not None
    trim(entry, run, SPEC.scan_ns)
    (left,) = entry.scenario.presses
    assert left.input is InputBit.HOME
    assert left.at_ns // SPEC.scan_ns <= 30
    assert entry.points == [left.at_ns // SPEC.scan_ns + 10]


def test_two_searches_with_a_share_each_do_not_keep_the_same_twice():
    corpus = Corpus()
    corpus.take(Scenario(), shown(a=5), SPEC.scan_ns)
    shared = corpus.share(12)
    one, two = shared.for_task(0, 2), shared.for_task(1, 2)
    for each, more in ((one, {"b": 9}), (two, {"b": 7, "c": 8})):
        each.take(Scenario(presses=(press(InputBit.HOME, 5),)), shown(a=5, **more), SPEC.scan_ns)
        corpus.merge(each)
    assert [entry.points for entry in corpus.entries] == [[5], [9], [7, 8]]
    three = corpus.share(12)
    three.take(Scenario(), shown(c=8), SPEC.scan_ns)
    corpus.merge(three)
    assert len(corpus.entries) == 3


def test_every_fault_and_button_meets_a_thin_state_once():
    edges = Edges()
    for scan in (50, 52, 90):
        edges.add("state", ("step", scan), scan)
    edges.close()
    sweep = Sweep(SPEC, frozenset({Kind.POWER, Kind.INPUTS}), Random(1), Corpus())
    sweep.take(Entry(Scenario(), edges, [50], 6.0))
    tried = []
    while (scenario := sweep.next()) is not None:
        tried.append(scenario)
    assert {each.incidents[0].at_ns // SPEC.scan_ns for each in tried if each.incidents} == {49, 50, 51}
    assert {each.presses[0].input for each in tried if each.presses} == set(InputBit)
    sweep.take(Entry(Scenario(), edges, [50], 6.0))
    assert sweep.next() is None


def test_a_number_that_runs_through_its_values_is_no_thin_state():
    edges = Edges()
    for scan in range(40, 60):
        edges.add("state", (0, "position", scan - 40), scan)
    edges.add("size", (0, "position", 52), 61)
    for scan, step in ((40, 10), (55, 20), (57, 30), (90, 10)):
        edges.add("state", (0, "step", step), scan)
    edges.add("size", (0, "step", 53), 95)
    edges.close()
    assert edges.groups["thin"] == {(0, "step", 20): [55]}


def test_inputs_change_before_every_rung_where_a_number_takes_a_step_until_it_has_taken_many():
    edges = Edges()
    edges.add("number", 0, 50)
    rungs = ("Main", 0), ("Main", 3), ("Main", 7)
    sweep = Sweep(SPEC, frozenset({Kind.TORN}), Random(1), Corpus(), rungs)

    def tried():
        sweep.take(Entry(Scenario(), edges, [50], 6.0))
        scenarios = iter(sweep.next, None)
        return sorted(
            (tear.rung, tear.at_ns // SPEC.scan_ns) for each in scenarios if each for tear in each.tears
        )

    assert tried() == [(3, 49), (7, 49)]
    assert tried() == []
    edges.add("number", 0, 80)
    assert tried() == [(3, 49), (3, 79), (7, 49), (7, 79)]
    for scan in range(100, 110):
        edges.add("number", 0, scan)
    assert {scan for rung, scan in tried()} == {49, 79, *range(99, 105)}
    edges.add("number", 0, 120)
    assert tried() == []


def steps_of_a_hunt(folder, examples):
    version = version_of("lost_request", folder, with_mistake=False)
    report = search(version.bench, version.kinds, examples=examples, start=5, corpus=Corpus(runs=150))
    kept = [(each.scenario.to_json(), each.points, each.chosen) for each in report.corpus.entries]
    found = [each.scenario.to_json() for each in report.found]
    return hashlib.sha256(repr((kept, found, report.scans)).encode()).hexdigest()


@pytest.mark.slow
def test_a_hunt_with_a_corpus_is_the_same_under_another_hash_seed(tmp_path):
    here = steps_of_a_hunt(tmp_path / "it", 25)
    assert run_in_fresh_process(steps_of_a_hunt, tmp_path / "there", 25) == here


def test_the_next_task_of_a_campaign_gets_what_the_last_one_has_found():
    done, state = SearchReport(runs=40, shrinking=10), State()
    done.corpus.take(Scenario(), shown(a=5), SPEC.scan_ns)
    state.add(done)
    (task,) = _search_tasks(state, 1, 50)
    assert task.corpus is not None
    assert task.corpus.runs == 30
    assert [each.points for each in task.corpus.entries] == [[5]]
    again = pickle.loads(pickle.dumps(task.corpus))
    assert again.take(Scenario(), shown(a=5), SPEC.scan_ns) is None
    assert again.take(Scenario(), shown(a=5, b=6), SPEC.scan_ns) is not None


def times_in(tmp_path, name, text):
    (tmp_path / name).write_text(text, encoding="utf-8")
    return times_of(load_program(str(tmp_path / name)).function, 2_000_000, 1_000)


def test_times_of_a_python_program_are_its_texts_and_what_it_compares(tmp_path):
    """10 that is compared are scans, 20 ms; 760 ms is between them and 1.5 s; 5 s is too long."""
    text = 'WAIT = "5 s"\ndef logic(scan):\n    return scan.number > 10 or "1.5 s" or "no time"\n'
    assert times_in(tmp_path, "it.py", text) == (20_000_000, 760_000_000, 1_500_000_000)


def test_times_of_a_ladder_program_are_presets_of_its_timers(tmp_path):
    """The menu has timers of 400 ms and 1 s: 700 ms lies between."""
    logic = version_of("service_menu", tmp_path / "it", with_mistake=False).bench.fresh_logic()
    assert times_of(logic, 2_000_000, 1_000) == (400_000_000, 700_000_000, 1_000_000_000)


def test_a_torn_update_leaves_some_of_the_words_late_that_change():
    edges = Edges()
    edges.add(TOGETHER, (0, (2, 3)), 70)
    draws = Draws(SPEC, 1_000, {Kind.TORN}, Random(2))
    drawn = [part for _ in range(200) for part in draws.scenario(edges).incidents]
    aimed = [part for part in drawn if part.late_words in ((2,), (3,))]
    assert len(aimed) > len(drawn) / 2
    assert {part.at_ns // SPEC.scan_ns for part in aimed} >= {69, 70, 71}


def test_a_rhythm_presses_a_button_again_and_again():
    draws = Draws(SPEC, 1_000, {Kind.INPUTS}, Random(1))
    draws.times = (400_000_000,)
    rhythms = [
        presses
        for _ in range(200)
        if len(presses := draws.scenario().presses) > 3
        and len({(press.input, press.for_ns) for press in presses}) == 1
    ]
    assert rhythms
    assert any(press.for_ns >= 398_000_000 for presses in rhythms for press in presses)
