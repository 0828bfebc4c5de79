"""Two pages and another program edit the same rungs: whatever comes in which order, pages show what is so.

What a page tests is what it has seen accepted, cancel gives the program before, save writes what runs and
keeps the old file, and an exchange that is refused changes nothing. A page that is late knows an older state.

Broken on purpose: a test of whatever is accepted now, a stage that stays when its exchange is refused, a
cancel that keeps the edited program, a stage that stays when another program runs, an edit that changes
nothing, a save over another program's file.
"""

import tempfile
from collections import deque
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)
from scanrack.jobs.record.program_versions import ProgramVersion
from scanrack.ladder import LadderLogic
from scanrack.ladder.files import parse_program
from scanrack.runtime import Edit, Online
from scanrack.watch import edited_programs
from scanrack.watch import editor as editor_module
from scanrack.watch.edited_programs import EditedPrograms
from scanrack.watch.editor import EditManner, Editor
from scanrack.watch.history.program_file import digest
from scanrack.watch.online import MOVES

RUNGS: tuple[str, ...] = ("XIC(A)OTE(X);", "XIC(B)OTE(Y);")
TEXTS = ("XIC(A)OTE(X);", "XIO(A)OTE(X);", "XIC(B)OTE(X);")
STEPS = ("test", "untest", "assemble", "reopen", "cancel", "save")


def file_of(rungs: tuple[str, ...]) -> str:
    return "\n".join(
        ["PROGRAM Line", *(f"TAG {each} : BOOL" for each in "ABXY"), "ROUTINE Main", *rungs, "END", ""]
    )


def rungs_of(data: bytes) -> tuple[str, ...]:
    return tuple(each for each in data.decode().splitlines() if each.endswith(";"))


@cache
def specs() -> LadderLogic:
    return parse_program(file_of(RUNGS))


class QuickPrograms(EditedPrograms):
    """Programs that nothing compiles: their files are all that counts here."""

    rungs = property(lambda _self: specs())

    def with_file(self, data: bytes) -> Any:
        version = ProgramVersion("rack.toml", self.name, {self.name: data})
        return version, version

    def load(self, copy: ProgramVersion) -> Any:
        return copy

    def from_disk(self) -> Any:
        return ProgramVersion("rack.toml", self.name, {self.name: self.file.read_bytes()})

    def usable(self, job: Any, restart: str = "") -> Any:
        return job


class Versions(dict[int, ProgramVersion]):
    def with_copy(self, version: ProgramVersion) -> ProgramVersion:
        return version

    def keep(self, number: int, version: ProgramVersion, _job: object) -> None:
        self[number] = version


class Page:
    """What a page knows: the state that it heard last."""

    def __init__(self, state: Mapping[str, Any]) -> None:
        self.state = state


class TwoPages(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.folder = tempfile.TemporaryDirectory()
        self.file = Path(self.folder.name) / "line.rung"
        self.file.write_text(file_of(RUNGS), encoding="utf-8", newline="")
        self.takeovers: deque[Any] = deque()
        self.told: list[Mapping[str, Any]] = []
        self.refuses = False
        program = SimpleNamespace(edits=0, planned=self.planned)
        self.run = SimpleNamespace(program=program, cpu=None)
        self.versions = Versions({0: ProgramVersion("rack.toml", "line.rung", {"line.rung": self.on_disk})})
        job: Any = SimpleNamespace(program=self.file, spec=SimpleNamespace(tags=[]))
        self.editor = Editor(
            job, "", cast(Any, self.run), cast(Any, self.versions), self.takeovers.append, self.told.append,
            EditManner(),
        )  # fmt: skip
        self.before = RUNGS  # of the accepted edit
        state = self.editor._online.state(self.editor._programs.running)
        self.pages = [Page(state), Page(state)]

    def teardown(self) -> None:
        self.folder.cleanup()

    @property
    def on_disk(self) -> bytes:
        return self.file.read_bytes()

    @property
    def runs(self) -> tuple[str, ...]:
        return rungs_of(self.versions[self.run.program.edits].files["line.rung"])

    def planned(self, *_given: object) -> None:
        if self.refuses:
            raise ValueError("refused on purpose")

    def scans(self) -> None:
        """Do what is done between scans, and let the editor follow it."""
        while self.takeovers:
            order = self.takeovers.popleft()()
            if isinstance(order, Edit):
                self.run.program.edits = order.number
            if not self.takeovers:
                self.editor._attend()

    def ask(self, page: Page, order: Online, *, refuses: bool = False) -> Mapping[str, Any]:
        answers: list[Mapping[str, Any]] = []
        self.refuses = refuses
        self.editor.request(order, answers.append)
        self.editor._attend()
        self.scans()
        self.refuses = False
        (answer,) = answers
        assert "carried out" not in answer.get("refused", ""), answer  # no error of our own
        if "refused" not in answer:
            page.state = answer
        return answer

    def all_hear(self) -> None:
        for message in self.told:
            if "online" in message:
                for page in self.pages:
                    page.state = message["online"]
        self.told.clear()

    # --- what is done

    @rule(who=st.integers(0, 1), rung=st.integers(0, 1), text=st.sampled_from(TEXTS))
    def accept(self, who: int, rung: int, text: str) -> None:
        page, running = self.pages[who], self.runs
        order = Online("accept", page.state["base"], (("Main", rung, (text,)),), by=f"page {who}")
        answer = self.ask(page, order)
        if "refused" in answer:
            assert self.runs == running
            return
        assert (answer["stage"], answer["by"], answer["of"]) == ("accepted", f"page {who}", answer["base"])
        assert answer["rungs"] == (("Main", rung, (text,)),)
        assert self.runs == running
        self.before = running

    @rule(who=st.integers(0, 1), step=st.sampled_from(STEPS), refuses=st.booleans())
    def any_step(self, who: int, step: str, *, refuses: bool) -> None:
        self.step(who, step, refuses=refuses)

    @rule(who=st.integers(0, 1), data=st.data(), refuses=st.booleans())
    def step_of_a_button(self, who: int, data: st.DataObject, *, refuses: bool) -> None:
        stage = self.pages[who].state["stage"]
        fitting = [step for step in STEPS if stage in MOVES[step].sources]
        self.step(who, data.draw(st.sampled_from(fitting)), refuses=refuses)

    def step(self, who: int, step: str, *, refuses: bool) -> None:
        page, running, file, stage = self.pages[who], self.runs, self.on_disk, self.editor._online.stage
        seen = page.state
        base = seen["base"] if step == "save" else seen.get("edit", "")
        answer = self.ask(page, Online(step, base), refuses=refuses)
        if "refused" in answer:
            assert (self.runs, self.on_disk) == (running, file)
            assert self.editor._online.stage == stage
            return
        if step in ("test", "assemble", "reopen"):
            if base:
                assert self.runs == self.with_edit(seen)
            assert digest(self.versions[self.run.program.edits].files["line.rung"]) == answer["edit"]
        if step in ("untest", "cancel"):
            assert self.runs == self.before
        if step == "save":
            assert stage in ("", "assembled")
            assert rungs_of(self.on_disk) == self.runs == running
            kept = [each.read_bytes() for each in self.file.parent.glob("*.bak*")]
            assert self.on_disk == file or file in kept
        else:
            assert self.on_disk == file

    def with_edit(self, seen: Mapping[str, Any]) -> tuple[str, ...]:
        """Return the rungs with the edit that a page has seen."""
        ((_routine, rung, (text,)),) = seen["rungs"]
        return tuple(text if number == rung else each for number, each in enumerate(self.before))

    @rule()
    def hear(self) -> None:
        self.all_hear()

    @rule(rung=st.integers(0, 1), text=st.sampled_from(TEXTS))
    def another_program_saves(self, rung: int, text: str) -> None:
        """The saved file is taken over at once."""
        rungs = tuple(text if number == rung else each for number, each in enumerate(RUNGS))
        self.file.write_text(file_of(rungs) + "// by hand\n", encoding="utf-8", newline="")
        self.editor.load_soon()
        self.editor._attend()
        self.scans()
        assert self.runs == rungs
        self.all_hear()

    @precondition(lambda self: self.editor._online.stage in ("", "assembled"))
    @rule()
    def another_program_saves_and_it_waits(self) -> None:
        """The saved file is not taken over, so no page may save over it."""
        text = file_of(RUNGS) + "// waits\n"
        self.file.write_text(text, encoding="utf-8", newline="")
        self.editor._programs.look()
        answer = self.ask(self.pages[0], Online("save"))
        assert ("refused" in answer) == (self.editor._programs.seen != digest(text.encode()))
        assert self.on_disk.decode() == text

    # --- what always holds

    @invariant()
    def the_stage_says_what_runs(self) -> None:
        online = self.editor._online
        if online.edit is None:
            assert online.stage == ""
            return
        edited, before = (
            rungs_of(each.files["line.rung"]) for each in (online.edit.edited, online.edit.original)
        )
        assert self.runs == (before if online.stage == "accepted" else edited)
        assert edited != before


@pytest.mark.slow
def test_pages_show_what_is_so(monkeypatch):
    monkeypatch.setattr(editor_module, "EditedPrograms", QuickPrograms)
    monkeypatch.setattr(editor_module, "version_of", lambda version: version)
    monkeypatch.setattr(edited_programs, "program_name", lambda _job: "line.rung")
    run_state_machine_as_test(
        TwoPages,
        settings=settings(
            max_examples=60, stateful_step_count=20, deadline=None, suppress_health_check=[*HealthCheck]
        ),
    )
