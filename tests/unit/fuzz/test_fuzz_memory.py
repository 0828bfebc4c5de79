"""What a campaign keeps on disk: recipes, finds before they are shrunk, and what is left out by name."""

from __future__ import annotations

import errno
import json
import os
from hashlib import sha256

import pytest
from live_sessions import FEEDER, LiveSession
from scanrack.commands import build
from scanrack.commands.programs import fuzz_session
from scanrack.io_images.amci3601 import InputBit
from scanrack.jobs import load_job, read_state
from scanrack.jobs.fuzz import Press, Scenario
from scanrack.jobs.fuzz.campaign.memory import MOST_NAMED, Memory
from scanrack.jobs.fuzz.campaign.recipes import MOST_BYTES, Origin, Recipe, RecipeFolder, read_recipe
from typer.testing import CliRunner

MS = 1_000_000
ORIGIN = Origin(50, "0123456789abcdef", "fedcba9876543210", "0.2.0")
ESTOP = Scenario(presses=(Press(1, InputBit.ESTOP, True, 60 * MS, 20 * MS),))
HOME = Scenario(presses=(Press(1, InputBit.HOME, True, 40 * MS, 10 * MS),))

PROGRAM = """
from scanrack.io_images.amci3601 import Configuration, Idle, StatusView

WORDS = Configuration(inputs_used=0x3E, step_and_direction=True, starting_speed=500).to_image()

def logic(scan):
    status = StatusView(scan.slot[1].inputs)
    scan.slot[1].outputs.load(Idle().to_image() if status.MODE_CONFIG or scan.number > 5 else WORDS)
    if status.IN_ESTOP:
        raise RuntimeError("nobody thought of this")
"""
RACK = 'program = "line.py"\nrun_for_s = 0.1\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'


@pytest.fixture
def rack(tmp_path):
    (tmp_path / "line.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
    return tmp_path / "line.toml"


def fuzz(rack, *words, runs=1):
    out = rack.parent / "out"
    words = ("--only", "inputs", "--jobs", "1", "--out", out, "--runs", runs, *words)
    return CliRunner().invoke(build(), ["fuzz", str(rack), *map(str, words)])


def state_in(rack):
    return read_state(rack.parent / "out" / "state.json", "../line.toml")


def put(folder, text):
    """Write a text under its hash, as a recipe is."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{sha256(text.encode()).hexdigest()[:16]}.json"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_recipe_is_small_is_read_again_and_decides_its_name(tmp_path):
    folder = RecipeFolder(tmp_path, ORIGIN)
    for scenario in (Scenario(), ESTOP):
        file = tmp_path / folder.put(scenario, "no-fault")
        assert 100 <= file.stat().st_size <= 600
        assert read_recipe(file) == Recipe(scenario, ORIGIN, "no-fault")
        assert folder.put(scenario, "no-fault") == file.name
    assert len(list(tmp_path.iterdir())) == 2
    folder.remove(ESTOP, "no-fault")
    folder.remove(ESTOP, "no-fault")
    assert len(list(tmp_path.iterdir())) == 1


GOOD = Recipe(ESTOP, ORIGIN).text()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[" * 60, "Expecting value"),
        (" " * 65_537, "more than 65,536 bytes"),
        ("[" * 65, "brackets"),
        ("[]", "[]: must be a JSON object"),
        ("nothing", "Expecting value"),
        ("{}", "scans = None: must be 1 to 1,000,000,000,000,000"),
        (GOOD.replace("50,", "true,"), "scans = True"),
        (GOOD.replace("50,", "1e400,"), "scans = inf"),
        (GOOD.replace('"0.2.0"', "[1]"), "version = [1]: must be a text"),
        (GOOD.replace("presses", "presents"), "unknown key presents"),
        (GOOD.replace('"slot":1', '"slot":9'), "no slot 9; the rack has 1"),
        (GOOD.replace("60000000", "-1"), "presses.0.at_ns = -1"),
    ],
    ids=lambda text: text[:12] if len(text) < 40 else "",
)
def test_a_hostile_file_is_left_out_by_name(rack, text, says):
    file = put(rack.parent / "corpus", text)
    told: list[str] = []
    memory = Memory(rack.parent, ORIGIN, load_job(str(rack)).spec, told.append)
    assert memory.known() == ()
    (left,) = told
    assert left.startswith(f"ignored: {file}: ")
    assert says in left
    memory.keep([], [])
    assert file.exists()  # it is not ours


def test_a_torn_file_a_folder_and_a_stranger_are_left_out_and_the_others_are_read(rack):
    folder = RecipeFolder(rack.parent / "corpus", ORIGIN)
    folder.folder.mkdir()
    whole, torn = (folder.folder / folder.put(each) for each in (HOME, ESTOP))
    torn.write_bytes(torn.read_bytes()[:-20])
    (folder.folder / "notes.txt").write_text("mine", encoding="utf-8")
    (folder.folder / "more").mkdir()
    told: list[str] = []
    memory = Memory(rack.parent, ORIGIN, load_job(str(rack)).spec, told.append)
    assert memory.known() == (HOME,)
    assert len(told) == 3
    assert any(
        f"{torn}: the name is not the hash of the text: the file is incomplete" in each for each in told
    )
    memory.keep([], [])
    assert whole.exists()  # it has not been run again yet
    memory.all_were_run()
    memory.keep([Scenario()], [])
    assert not whole.exists()
    assert torn.exists()


def test_a_thousand_files_that_are_none_are_named_ten_times(rack):
    for number in range(MOST_NAMED + 5):
        put(rack.parent / "corpus", f"[{number}]")
    told: list[str] = []
    assert Memory(rack.parent, ORIGIN, load_job(str(rack)).spec, told.append).known() == ()
    assert len(told) == MOST_NAMED + 1
    assert MOST_BYTES == 65_536


@pytest.mark.slow
def test_what_a_killed_session_has_found_is_shrunk_by_the_next(rack):
    origin = Origin.of(load_job(str(rack)), 50)
    finds = RecipeFolder(rack.parent / "out" / "finds", origin)
    finds.folder.mkdir(parents=True)
    (rack.parent / "out" / ".lock").touch()  # of the session that was killed
    both = Scenario(presses=(*ESTOP.presses, *HOME.presses))
    finds.put(both, "no-fault")
    result = fuzz(rack)
    assert result.exit_code == 1, result.output
    (found,) = state_in(rack).found.values()
    assert [each.input for each in found.scenario.presses] == [InputBit.ESTOP]
    assert (rack.parent / "out" / "no-fault" / "report.txt").exists()
    assert not list(finds.folder.iterdir())


@pytest.mark.slow
def test_a_find_that_holds_now_is_tried_again_and_one_of_another_invariant_stays(rack):
    (rack.parent / "line.py").write_text(PROGRAM.replace("IN_ESTOP", "STOPPED"), encoding="utf-8")
    finds = RecipeFolder(rack.parent / "out" / "finds", Origin.of(load_job(str(rack)), 50))
    finds.folder.mkdir(parents=True)
    (rack.parent / "out" / ".lock").touch()
    finds.put(HOME, "no-fault")
    other = finds.put(HOME, "must_not_be")
    assert fuzz(rack, runs=2).exit_code == 0
    assert [file.name for file in finds.folder.iterdir()] == [other]
    assert state_in(rack).runs == 3  # it was run again before the two


@pytest.mark.slow
def test_a_corpus_is_run_again_by_the_next_session_and_begins_that_of_another_build(rack, tmp_path):
    folder = RecipeFolder(tmp_path / "theirs" / "corpus", ORIGIN)
    folder.folder.mkdir(parents=True)
    folder.put(ESTOP)  # the other build held it
    result = fuzz(rack, "--corpus", tmp_path / "theirs")
    assert result.exit_code == 1, result.output
    (found,) = state_in(rack).found.values()
    assert [each.input for each in found.scenario.presses] == [InputBit.ESTOP]
    before = state_in(rack)
    own = len(list((tmp_path / "out" / "corpus").iterdir()))
    assert fuzz(rack).exit_code == 1
    after = state_in(rack)
    assert after.runs == before.runs + own + 1
    assert fuzz(rack, "--corpus", rack).exit_code == 2


def test_a_session_of_watch_is_an_entry(tmp_path):
    press = {"do": "press", "slot": 1, "name": "estop", "on": True}
    path = tmp_path / "session.mcap"
    LiveSession([(100, press), (200, {**press, "on": None})], path, rack=FEEDER).play(300)
    job = load_job(str(FEEDER))
    memory = Memory(tmp_path, ORIGIN, job.spec, print)
    (scenario,) = memory.known([path])
    (pressed,) = scenario.presses
    assert (pressed.slot, pressed.input) == (1, InputBit.ESTOP)


@pytest.mark.slow
def test_a_full_disk_ends_the_search_with_the_recipe_on_the_terminal(rack, monkeypatch, tmp_path):
    def full(state, file):
        if state.found:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(file))

    monkeypatch.setattr(fuzz_session, "write_state", full)
    result = fuzz(rack, runs=40)
    assert result.exit_code == 2, result.output
    first, recipe = result.stderr.splitlines()
    assert "state.json: No space left on device; " in first
    given = json.loads(recipe)
    assert given["broken"] == "no-fault"
    (tmp_path / "it.json").write_text(recipe, encoding="utf-8")
    monkeypatch.undo()
    assert fuzz(rack, "--scenario", tmp_path / "it.json").exit_code == 1
    assert len(list((tmp_path / "out" / "finds").iterdir())) == 1  # as it was found


def test_the_rack_file_says_how_it_is_searched_and_the_options_come_first(rack):
    text = rack.read_text(encoding="utf-8")
    rack.write_text(text + '\n[fuzz]\nseed = 7\nonly = ["weather"]\n', encoding="utf-8")
    wrong = CliRunner().invoke(build(), ["fuzz", str(rack)])
    assert wrong.exit_code == 2
    assert "unknown kind 'weather'; choose from inputs" in wrong.stderr
    rack.write_text(text + "\n[fuzz]\nsed = 7\n", encoding="utf-8")
    assert "sed" in CliRunner().invoke(build(), ["fuzz", str(rack)]).stderr
    rack.write_text(text + '\n[fuzz]\nonly = ["power"]\nwithout = ["power"]\n', encoding="utf-8")
    nothing = CliRunner().invoke(build(), ["fuzz", str(rack)])
    assert "--without power: nothing random remains" in nothing.stderr
    assert fuzz(rack).exit_code == 0  # --only inputs


@pytest.mark.slow
def test_another_seed_is_another_search_and_the_same_is_the_same(rack):
    steps = []
    for number, seed in enumerate((0, 7, 7)):
        rack.write_text(f"{RACK}\n[fuzz]\nseed = {seed}\n", encoding="utf-8")
        words = ("--only", "power", "--out", str(rack.parent / str(number)), "--json")
        told = CliRunner().invoke(build(), ["fuzz", str(rack), "--runs", "5", "--jobs", "1", *words])
        steps.append(json.loads(told.stdout)["steps"])
    assert steps[0] != steps[1] == steps[2]


@pytest.mark.slow
def test_a_budget_that_is_used_up_ends_the_search_after_the_task_at_work(rack):
    told = fuzz(rack, "--processor", "1 us", "--scans", 10**9, "--for", "20 ms")
    assert told.exit_code in (0, 1), told.output
    assert state_in(rack).tasks == 1
