"""Steps with edited rungs between scans, without a monitor: what is refused, and what runs afterwards.

Broken on purpose: a step with an edit that its page has not seen, an edit of nothing that is accepted, a Save
without the file, a state that no new monitor hears, an error of our own that ends the editor, a Save over
another program's file, a stage that a refused Save drops, an answer before the exchange, a step that is
judged by the program before; a copy that follows a link, a file that takes the place of its link.
"""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from live_sessions import LiveSession
from scanrack.jobs import load_job
from scanrack.jobs.record.program_versions import ProgramVersions, version_of
from scanrack.runtime.live.actions import Online, Source
from scanrack.runtime.live.ring import REQUESTS
from scanrack.watch import edited_programs, online
from scanrack.watch.edited_programs import EditedPrograms
from scanrack.watch.editor import EditManner, Editor
from scanrack.watch.history.program_file import digest, save, why_not_editable

RACK = 'name = "small"\nprogram = "line.rung"\nscan_ms = 2\nwatchdog_ms = 0\n'
RACK += '[[slot]]\nnumber = 1\nmodule = "1769-IQ16"\n'
RUNGS = "PROGRAM Line\nTAG Lamp : BOOL\nTAG N : DINT\nROUTINE Main\nADD(N,1,N);\nEND\n"
ADDS_TWO = (("Main", 0, ("ADD(N,2,N);",)),)
PATIENCE_S = 60


class EditedSession:
    """A session whose scans and orders the test carries out."""

    def __init__(self, folder: Path) -> None:
        self.file, rack = folder / "line.rung", folder / "rack.toml"
        self.file.write_text(RUNGS, encoding="utf-8")
        rack.write_text(RACK, encoding="utf-8")
        job = load_job(str(rack))
        self.versions = ProgramVersions(folder / "copies", str(rack))
        self.versions.keep(0, self.versions.with_copy(version_of(job)), job)
        self.live = LiveSession(rack=rack, editions=self.versions)
        manner, hand_over = EditManner(preview=True), self.live.session.takeovers.append
        run, tell = self.live.run, self.live.tell
        self.editor = Editor(job, str(rack), run, self.versions, hand_over, tell, manner)

    @property
    def runs(self) -> str:
        return self.versions[self.live.run.program.edits].files["line.rung"].decode()

    def attend(self) -> None:
        """Do what is done between two scans."""
        self.live.session.obey_all(self.live.run.cpu.now_ns, self.live.run.cpu.scan)

    def asked(self, order: Any) -> list[Any]:
        """Ask; the returned list gets the answer when it is attended to."""
        answers: list[Any] = []
        self.editor.request(order, answers.append)
        return answers

    def until(self, wanted: Callable[[], Any], *, attended: bool = True) -> None:
        """Wait until a condition holds; between two looks is the end of a scan if it is `attended`."""
        end = time.monotonic() + PATIENCE_S
        while not wanted():
            assert time.monotonic() < end
            time.sleep(0.002)
            if attended:
                self.attend()

    def until_told(self, key: str) -> None:
        self.until(lambda: any(key in each for each in self.live.told))

    def ask(self, order: Any) -> Any:
        answers = self.asked(order)
        self.until(lambda: answers)
        return answers[0]

    def step(self, step: str) -> Any:
        answer = self.ask(Online(step))
        return answer.get("stage", answer.get("refused"))

    def accept(self) -> None:
        base = digest(self.runs.encode())
        assert self.ask(Online("accept", base, ADDS_TWO))["stage"] == "accepted"


@pytest.fixture
def session(tmp_path):
    made = EditedSession(tmp_path)
    with made.live.ports, made.live.run.cpu:
        made.editor.start()
        yield made
        made.editor.end()


def test_an_error_of_our_own_is_refused_and_the_editor_goes_on(session, monkeypatch, capsys):
    def breaks(*_given):
        raise SyntaxError("on purpose")

    with monkeypatch.context() as patched:
        patched.setattr(online, "why_not_editable", breaks)
        assert session.step("test") == "it can't be carried out: SyntaxError: on purpose"
    assert "on purpose" in capsys.readouterr().err
    with monkeypatch.context() as patched:
        patched.setattr(EditedPrograms, "from_disk", breaks)
        session.editor.load_soon()
        session.until_told("mistake")
    assert session.ask(Source())["text"] == RUNGS


def test_save_never_replaces_what_another_program_has_written(session):
    session.accept()
    assert session.step("assemble") == "assembled"
    session.file.write_text("PROGRAM Other\n", encoding="utf-8")
    session.until_told("preview")
    assert "changed by another program" in session.step("save")
    assert session.file.read_text(encoding="utf-8") == "PROGRAM Other\n"
    session.file.write_text(RUNGS, encoding="utf-8")
    assert session.step("save") == ""
    assert session.file.read_text(encoding="utf-8") == RUNGS.replace("N,1", "N,2")


def test_a_refused_save_leaves_the_edit_assembled(session, monkeypatch):
    def full(*_given):
        raise OSError(28, "No space left on device")

    session.accept()
    session.step("assemble")
    with monkeypatch.context() as patched:
        patched.setattr(edited_programs, "save", full)
        assert "No space left" in session.step("save")
    assert session.step("reopen") == "testing"


def test_an_exchange_that_fails_is_refused_and_the_old_rungs_stay(session, monkeypatch):
    def fails(*_given):
        raise ValueError("on purpose")

    session.accept()
    with monkeypatch.context() as patched:
        patched.setattr(session.live.run.program, "planned", fails)
        assert "could not be replaced" in session.step("test")
    assert session.runs == RUNGS
    assert session.step("test") == "testing"
    assert "N,2" in session.runs


def test_a_step_waits_for_the_exchange_before_it(session):
    session.accept()
    takeovers = session.live.session.takeovers
    tested, cancelled = session.asked(Online("test")), session.asked(Online("cancel"))
    session.until(lambda: len(takeovers) >= 4, attended=False)  # exchange, its outcome, and two answers
    session.until(lambda: cancelled)
    assert tested[0]["stage"] == "testing"
    assert "being replaced" in cancelled[0]["refused"]
    assert session.step("cancel") == ""
    assert session.runs == RUNGS


def test_the_accepted_edit_has_its_page_and_another_page_does_not_test_it_unseen(session):
    base, others = digest(session.runs.encode()), (("Main", 0, ("ADD(N,3,N);",)),)
    mine = session.ask(Online("accept", base, ADDS_TWO, by="page 1"))
    assert (mine["by"], mine["rungs"], mine["of"], mine["base"]) == ("page 1", ADDS_TWO, base, base)
    theirs = session.ask(Online("accept", base, others, by="page 2"))
    assert (theirs["by"], theirs["rungs"]) == ("page 2", others)
    assert theirs["edit"] == digest(RUNGS.replace("N,1", "N,3").encode()) != mine["edit"]
    for step in ("test", "assemble", "cancel"):
        refused = session.ask(Online(step, mine["edit"]))["refused"]
        assert "page 2 has accepted another edit" in refused
    assert session.ask(Online("test", theirs["edit"]))["stage"] == "testing"
    assert "N,3" in session.runs


def test_an_edit_that_changes_nothing_is_not_accepted(session):
    base = digest(session.runs.encode())
    same = session.ask(Online("accept", base, (("Main", 0, ("ADD(N, 1, N);",)),)))
    assert "are the same as the running ones" in same["refused"]
    assert session.step("test") == "test: no edit has been accepted"


@pytest.mark.parametrize(
    ("file", "why"),
    [
        ("a.rung", ""),
        ("a.L5X", ""),
        ("a.slc", ""),
        ("a.py", "edit the Python code"),
        ("a.st", "a .st file"),
    ],
)
def test_a_page_says_why_rungs_are_not_edited_in_their_picture(file, why):
    said = why_not_editable(Path(file))
    assert why in said
    assert bool(why) == bool(said)


def test_save_writes_a_file_that_is_gone(session):
    session.accept()
    session.step("assemble")
    session.file.unlink()
    assert session.step("save") == ""
    assert session.file.read_text(encoding="utf-8") == RUNGS.replace("N,1", "N,2")


def test_a_new_monitor_is_told_the_state_of_the_edit(session):
    session.until_told("online")
    assert session.live.told[-1]["online"] == {
        "stage": "", "base": digest(RUNGS.encode()), "unsaved": False
    }  # fmt: skip
    session.accept()
    live = session.live
    live.tap.lasting = session.editor.lasting
    at = live.ring.messages.read(0)[1]
    live.ring.head[REQUESTS] += 1
    live.tap.attend()
    told = [json.loads(each) for each in live.ring.messages.read(at)[0]]
    assert [each["online"]["stage"] for each in told if "online" in each] == ["accepted"]
    live.tap.send_values()  # asked for once, told once
    assert not any("online" in json.loads(each) for each in live.ring.messages.read(at)[0][len(told) :])


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such modes, and seldom links")
def test_a_file_is_saved_as_a_whole_where_its_link_leads(tmp_path):
    (tmp_path / "far").mkdir()
    target, link, foreign = tmp_path / "far" / "a.rung", tmp_path / "a.rung", tmp_path / "foreign"
    target.write_bytes(b"old")
    target.chmod(0o640)
    foreign.write_bytes(b"foreign")
    link.symlink_to(target)
    (target.parent / "a.rung.bak").symlink_to(tmp_path / "nowhere")
    (target.parent / "a.rung.new").symlink_to(foreign)
    kept = save(link, b"new")
    assert (kept, kept.read_bytes()) == (target.parent / "a.rung.bak2", b"old")
    assert (link.is_symlink(), target.read_bytes(), foreign.read_bytes()) == (True, b"new", b"foreign")
    assert [each.stat().st_mode & 0o777 for each in (target, kept)] == [0o640] * 2
    assert not (tmp_path / "nowhere").exists()
