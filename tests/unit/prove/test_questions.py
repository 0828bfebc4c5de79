"""The questions of every program: each rule finds what it names, and is silent where it is not so."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove import ProgramSystem, ScanBounds
from scanrack.ladder.prove.induction import VerdictKind
from scanrack.ladder.prove.questions import LIMITS, RULES, Answers, Finding, Listener, ask, deciding
from scanrack.ladder.prove.system import System

pytestmark = pytest.mark.extra("prove")

TAGS = [f"TAG {name} : BOOL" for name in ("A", "B", "C", "X", "Y", "Z")]
TAGS += ["TAG N : DINT", "TAG M : DINT", "TAG List : DINT[4]", "TAG T : TIMER", "TAG K : COUNTER"]


def answers(*rungs: str, bounds: ScanBounds = ScanBounds()) -> Answers:  # noqa: B008
    head = ["PROGRAM p", "ALLOW repeated coils", *TAGS, "ROUTINE Main"]
    text = "\n".join([*head, *rungs, "END", ""])
    return ask(ProgramSystem(parse_program(text), bounds))


def found(*rungs: str) -> list[tuple[str, int | None]]:
    """Return rule and rung of each finding."""
    return [(each.rule, each.site.rung) for each in answers(*rungs).findings]


ROWS: dict[str, tuple[str, ...]] = {
    "dead-rung": ("XIC(A)OTE(X);", "XIC(X)XIO(A)OTE(Y);"),
    "never-on": ("XIC(X)XIC(A)OTE(X);",),
    "stuck": ("XIC(A)OTL(X);",),
    "conflict": ("XIC(A)OTE(X);", "XIC(B)OTE(X);"),
    "never-done": ("XIC(A)XIO(A)TON(T,100,0);",),
    "fault": ("XIC(A)DIV(7,N,M);", "XIC(A)ADD(N,1,N);"),
}


@pytest.mark.parametrize("rule", ROWS)
def test_each_rule_finds_what_it_names(rule: str) -> None:
    assert rule in RULES
    assert rule in [name for name, _ in found(*ROWS[rule])]


SILENT: dict[str, tuple[str, ...]] = {
    "dead-rung": ("XIC(A)JMP(End);", "XIC(B)OTE(X);", "LBL(End)NOP();"),
    "dead-leg": ("[XIC(A),XIC(B)]XIO(C)OTE(X);", "EQU(N,3)OTE(Y);"),
    "never-on": ("XIC(A)OTE(X);",),
    "stuck": ("XIC(A)OTL(X);", "XIC(B)OTU(X);"),
    "conflict": ("XIC(A)OTE(X);", "XIC(A)OTE(X);"),
    "never-done": ("XIC(A)TON(T,3000,0);", "XIC(B)CTU(K,2,0);"),
    "fault": ("XIC(A)MOV(3,N);", "XIC(A)XIC(B)MOV(2,N);", "XIC(A)DIV(7,N,M);", "XIC(A)MOV(5,List[N]);"),
}


@pytest.mark.parametrize("rule", SILENT)
def test_each_rule_is_silent_where_it_is_not_so(rule: str) -> None:
    result = answers(*SILENT[rule])
    assert rule not in [each.rule for each in result.findings]
    assert result.counts[rule]
    assert result.open[rule] == 0


def test_a_contact_that_decides_nothing_and_one_that_never_passes() -> None:
    texts = [
        each.text
        for each in answers(
            "XIC(A)[XIC(B),XIC(B)XIC(C)]XIC(A)OTE(X);", "XIC(A)[XIO(A),XIC(C)]OTE(Y);"
        ).findings
        if each.rule == "dead-leg"
    ]
    assert texts == [
        "the leg of XIC(B) decides nothing: another leg also has power",
        "XIC(A) decides nothing: it passes power whenever power reaches it",
        "XIO(A) never passes",
    ]


def test_a_fault_comes_with_the_run_that_has_it() -> None:
    (finding,) = answers("XIC(A)ADD(N,1,N);", "MOV(1,List[N]);").findings
    assert (finding.rule, finding.site.rung, finding.verdict.kind) == ("fault", 1, VerdictKind.REFUTED)
    assert len(finding.verdict.scans) == 4


def test_a_fault_in_a_loop_is_found_once() -> None:
    """Passes 4 to 9 are beyond the array."""
    lines = "ROUTINE Main ST\nFOR N := 0 TO 9 DO\nIF A THEN List[N] := 1; END_IF;\nEND_FOR;\nEND\n"
    program = parse_program("\n".join(["PROGRAM p", *TAGS, lines]))
    assert [each.rule for each in ask(ProgramSystem(program), ("fault",)).findings] == ["fault"]


def test_a_loop_without_end_is_found() -> None:
    looping = "LBL(Again)XIC(A)JMP(Again);"
    rules = [each.rule for each in answers(looping).findings]
    assert "endless" in rules


def test_what_is_found_is_the_same_again() -> None:
    rungs = [each for rows in ROWS.values() for each in rows]
    assert answers(*rungs) == answers(*rungs)


AWAKE = """PROGRAM p
TAG Awake : BOOL
TAG Start : BOOL
TAG Held : BOOL
ROUTINE Main
XIO(S:FS)OTE(Awake);
[XIC(Start),XIC(Held)]OTE(Held);
END
"""


def test_a_coil_that_is_off_in_each_first_scan_is_not_stuck() -> None:
    found = ask(ProgramSystem(parse_program(AWAKE))).findings
    assert [each.text for each in found if each.rule == "stuck"] == ["Held is never off again once it is on"]


SLOW = (
    "XIC(A)ADD(N,1,N);",
    "GRT(N,5)MOV(0,N);",
    "LES(N,-3)OTE(X);",
    "GRT(N,900)OTE(Y);",
    "XIC(A)XIO(A)OTE(Z);",
)


class Heard(Listener[Finding]):
    """Notes what it hears."""

    def __init__(self) -> None:
        self.said: list[str] = []

    def begun(self, count: int) -> None:
        self.said.append(f"asked {count}")

    def found(self, answer: Finding) -> None:
        self.said.append(answer.text)

    def left(self, count: int) -> None:
        self.said.append(f"left {count}")


def test_what_takes_little_is_answered_first_and_invariants_are_found_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sought = []

    def invariants(system: System, *given: Any) -> Any:
        sought.append(system)
        return found_by(system, *given)

    found_by = deciding.invariants
    monkeypatch.setattr(deciding, "invariants", invariants)
    heard = Heard()
    head = ["PROGRAM p", *TAGS, "ROUTINE Main"]
    result = ask(ProgramSystem(parse_program("\n".join([*head, *SLOW, "END", ""]))), listener=heard)
    at = next(place for place, each in enumerate(heard.said) if each.startswith("left"))
    assert heard.said[0] == f"asked {sum(result.counts.values())}"
    assert "Z is never on" in heard.said[1:at]
    assert len(sought) == len(set(map(id, sought))) <= 2
    assert [each.text for each in result.findings if each.rule == "never-on"][-1] == "Z is never on"


def test_invariants_are_for_questions_of_few_states_times_the_work() -> None:
    problem = ProgramSystem(parse_program("\n".join(["PROGRAM p", *TAGS, "ROUTINE Main", *SLOW, "END", ""])))
    one = replace(LIMITS, states=1)
    left = [ask(problem, limits=one.times(work)).open["stuck"] for work in (1, 2)]
    assert left == [1, 0]  # N and Y decide whether Y is never off again
