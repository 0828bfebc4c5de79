"""The folder of a campaign: one campaign at a time, and a damaged state names its file."""

from __future__ import annotations

import errno
import json
import os
from collections import Counter

import pytest
from scanrack.commands import build
from scanrack.io_images.amci3601 import InputBit
from scanrack.jobs import State, read_state, write_state
from scanrack.jobs.fuzz import BrokenInvariant, Counterexample, Press, Scenario, folder_lock
from scanrack.jobs.fuzz.campaign.state import CampaignError
from scanrack.jobs.fuzz.folder_lock import locked
from scanrack.runtime import FaultKind, InjectedFault
from typer.testing import CliRunner

PROGRAM = "def logic(scan):\n    pass\n"
RACK = 'program = "line.py"\nrun_for_s = 0.02\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'


def test_a_second_campaign_is_refused_and_the_folder_is_free_afterwards(tmp_path):
    (tmp_path / "line.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
    out = tmp_path / "out"
    out.mkdir()
    command = ["fuzz", str(tmp_path / "line.toml"), "--runs", "1", "--jobs", "1", "--out", str(out)]
    with locked(out):
        refused = CliRunner().invoke(build(), command)
    assert refused.exit_code == 2
    assert refused.stderr.startswith(f"scanrack: {out}: another campaign (process ")
    assert not (out / "state.json").exists()
    assert CliRunner().invoke(build(), command).exit_code == 0


def test_a_full_disk_is_told_with_the_file(tmp_path, monkeypatch):
    def full(_number, _data):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(folder_lock.os, "write", full)
    with pytest.raises(OSError, match="No space left on device") as told, locked(tmp_path):
        pass
    assert told.value.filename == str(tmp_path / ".lock")


@pytest.fixture
def state(tmp_path):
    """A file with a state in which every kind of value occurs."""
    scenario = Scenario(
        ((1, "3.1"),),
        (Press(1, InputBit.HOME, True, 2_000_000, 2_000_000),),
        (InjectedFault(2_000_000, FaultKind.TORN_UPDATE, 1, 0, (1, 2)),),
    )
    broken = BrokenInvariant(
        "name", "It holds.", 3, 6_000_000, "it is false", ("slot 1: idle",), ("a [CMD-01]",), "CMD-01"
    )
    state = State("line.toml", 2, {"CMD-01": scenario}, runs=10, scans=500, rules=Counter({"CMD-01": 2}))
    state.note([Counterexample(scenario, broken, 7)])
    write_state(state, tmp_path / "state.json")
    return tmp_path / "state.json"


def refused(file):
    """Whether a state is refused with its file; the message if it is refused without."""
    try:
        read_state(file, "line.toml")
    except CampaignError as error:
        return str(file) in str(error) or str(error)
    return False


def test_a_state_that_ends_early_is_refused(state):
    data = state.read_bytes()
    for length in range(0, len(data) - 2, 37):
        state.write_bytes(data[:length])
        assert refused(state) is True, length


def test_a_state_with_a_flipped_bit_is_refused_or_read(state):
    data = state.read_bytes()
    for place in range(0, len(data), 5):
        state.write_bytes(data[:place] + bytes([data[place] ^ 1 << place % 8]) + data[place + 1 :])
        assert refused(state) in (True, False)  # nothing else is raised


WRONG: tuple[object, ...] = (None, True, -1, 1.5, "text", [], [1], {}, {"a": 1}, [[1]], {"1": "9.9"})


def changed(value, path=()):
    """Yield the paths of all values in a document."""
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, each in items:
        yield from changed(each, (*path, key))


@pytest.mark.slow
def test_a_value_of_another_type_is_refused_or_of_no_consequence(state):
    """What is read can be searched with: it is written again, and its scenarios can be laid over a rack."""
    text = state.read_text(encoding="utf-8")
    for path in changed(json.loads(text)):
        for wrong in WRONG:
            document = json.loads(text)
            if path:
                place = document
                for key in path[:-1]:
                    place = place[key]
                place[path[-1]] = wrong
            else:
                document = wrong
            state.write_text(json.dumps(document), encoding="utf-8")
            if refused(state) is not True:
                again = read_state(state, "line.toml")
                assert {each.broken.key for each in again.found.values()} <= set(again.folders)
                assert State.from_json(json.loads(json.dumps(again.to_json()))) == again
                assert all(name == str(name) and "/" not in name for name in again.folders.values())


def failure(parts, after):
    """Return a failure whose scenario has a number of presses."""
    presses = tuple(Press(1, InputBit.HOME, True, 2_000_000 * at, 2_000_000) for at in range(parts))
    broken = BrokenInvariant("name", "It holds.", 3, 6_000_000, "it is false")
    return Counterexample(Scenario(presses=presses), broken, after)


def test_a_known_failure_is_news_again_only_with_a_smaller_scenario():
    state = State()
    first, equal, larger, smaller = failure(2, 1), failure(2, 5), failure(3, 6), failure(1, 7)
    assert state.note([first]) == [first]
    assert state.note([equal, larger]) == []
    assert list(state.found.values()) == [first]
    assert state.note([smaller]) == [smaller]
    assert list(state.found.values()) == [smaller]
    assert list(state.folders.values()) == ["name"]
