"""What `scanrack check` says where a proof decides: true for all inputs, and for numbers of any value."""

import pytest
from check_programs import SOUND, check
from scanrack.jobs.prove.serving import judging
from scanrack.jobs.prove.serving.judging import verdicts

pytestmark = pytest.mark.extra("prove")

PROGRAM = """\
PROGRAM line
ALIAS Start : Local:2:I.Data.0
ALIAS Jog : Local:2:I.Data.1
ALIAS Lamp : Local:3:O.Data.0
ALIAS Horn : Local:3:O.Data.1
TAG Memory : BOOL
TAG Toggle : BOOL
TAG Step : DINT
TAG Count : DINT
TAG Total : DINT := 100
TAG Mean : DINT

ROUTINE Main
{}
XIC(Toggle)OTE(Lamp);
END
"""

TOGGLE = "XIC(Jog)ONS(Memory)[XIO(Toggle)OTL(Toggle),XIC(Toggle)OTU(Toggle)];"
"""The second leg sees what the first one has done: the bit is never on at the end of a scan."""

TOGGLE_RIGHT = "XIC(Jog)ONS(Memory)OTE(Horn);\n[XIC(Horn)XIO(Toggle),XIO(Horn)XIC(Toggle)]OTE(Toggle);"

TOO_LATE = f"""\
{TOGGLE_RIGHT}
EQU(Step,0)XIC(Start)MOV(10,Step);
EQU(Step,10)XIO(Start)MOV(0,Step);
EQU(Step,10)XIO(Start)ADD(Count,1,Count);
GRT(Count,9)CLR(Count);"""
"""The step has gone on before the rung that counts asks for it; so the count never exceeds 9."""

IN_TIME = TOO_LATE.replace("MOV(0,Step)", "ADD(Count,1,Count)", 1).replace(
    "XIO(Start)ADD(Count,1,Count);\nGRT", "XIO(Start)MOV(0,Step);\nGRT"
)

DIVIDES = f"""\
{TOGGLE_RIGHT}
XIC(Start)ADD(Count,1,Count);
GRT(Count,99)CLR(Count);
DIV(Total,Count,Mean);
GRT(Mean,5)OTL(Local:3:O.Data.3);
LES(Mean,5)OTU(Local:3:O.Data.3);"""
"""Nothing is counted before Start."""


def found(folder, rungs):
    """Return what only a proof finds: rule and line, counted from the first rung."""
    text = PROGRAM.format(rungs)
    first = text.splitlines().index("ROUTINE Main") + 2
    alone = check(folder, "line.rung", text).findings
    report = check(folder, "line.rung", text, prover=verdicts)
    return [
        (each.rule, each.place.line - first)
        for each in report.findings
        if each not in alone and "(proved)" in each.text
    ]


@pytest.mark.parametrize(
    ("rungs", "expected"),
    [
        (TOGGLE, [("constant-condition", 0), ("unreachable", 1)]),
        (TOGGLE_RIGHT, []),
        (TOO_LATE, [("unreachable", 4), ("unreachable", 5)]),
        (IN_TIME, []),
        (DIVIDES, [("division-by-zero", 4)]),
        (DIVIDES.replace("DIV(", "NEQ(Count,0)DIV("), []),
    ],
    ids=["toggle", "toggle right", "too late", "in time", "divides", "divides if it can"],
)
def test_what_a_proof_finds(tmp_path, rungs, expected):
    assert sorted(found(tmp_path, rungs), key=lambda each: each[1]) == expected


def test_a_program_that_is_too_large_is_not_asked(tmp_path, monkeypatch):
    monkeypatch.setattr(judging, "MOST_TERMS", 3)
    assert found(tmp_path, TOGGLE) == []


def test_a_bit_that_the_program_only_clears_is_set_from_outside(tmp_path):
    rungs = f"{TOGGLE_RIGHT}\nXIC(Request)MOV(1,Step)OTU(Request);\nEQU(Step,1)OTE(Local:3:O.Data.3);"
    text = PROGRAM.format(rungs).replace("TAG Step", "TAG Request : BOOL\nTAG Step")
    assert not [
        each for each in check(tmp_path, "line.rung", text, prover=verdicts).findings if "proved" in each.text
    ]


LONG = {
    *("two_axes.rung", "blend.rung", "drill.rung", "blocks_st.rung", "boolsteps.rung"),
    *("jog.rung", "label.rung", "blocks.rung", "bits.rung", "regulator.rung"),
}
"""Programs that take ten seconds or more."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.long] if name in LONG else [])
        for name in SOUND
        if not name.endswith(".py")
    ],
)
def test_nothing_is_proved_of_a_sound_program(name, tmp_path):
    assert check(tmp_path, name, SOUND[name], prover=verdicts).findings == ()
