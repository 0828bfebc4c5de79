"""The terms of a scan give what the interpreter computes."""

import re
from pathlib import Path
from random import Random
from typing import Any

import pytest
from amounts import amount
from relation import Relation
from relation_programs import drawn
from scanrack.ladder import instructions
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove.algebra.evaluation import evaluate
from scanrack.ladder.prove.algebra.terms import FALSE, forget
from scanrack.ladder.prove.relation.machine import ScanMachine
from slc_bench import imported

HEAD = """PROGRAM small
TAG A : BOOL
TAG B : BOOL
TAG T : TIMER
TAG C : COUNTER
TAG X : DINT
TAG R : REAL
TAG Arr : DINT[5]
TAG Text : STRING
TAG Most : DINT
ROUTINE Main
"""


def relation(*rungs: str, more: str = "") -> Relation:
    return Relation(parse_program(f"{HEAD}{chr(10).join(rungs)}\nEND\n{more}"))


def test_a_program_of_common_instructions_equals_the_interpreter() -> None:
    found = relation(
        "XIC(A)XIO(B)OTE(B);",
        "XIC(A)TON(T,100,0)XIC(T.DN)CTU(C,5,0);",
        "GRT(X,2)ADD(X,1,X);",
        "MOV(X,Arr[X]);",
        "[XIC(T.TT),LIM(2,X,9)]MUL(R,2.5,R);",
        "JSR(Sub,1,X,X);",
        "XIC(A)CPT(X,X*3+Arr[2]/X);",
        more="ROUTINE Sub\nSBR(Arr[1])XIC(B)ADD(Arr[1],1,Arr[1]);\nRET(Arr[1]);\nEND\n",
    )
    assert found.differences(Random(1), 40) == []
    assert found.machine.cut == []


@pytest.mark.parametrize("seed", range(3))
def test_a_drawn_program_equals_the_interpreter(seed: int) -> None:
    assert Relation(parse_program(drawn(seed))).differences(Random(seed), 6) == []


@pytest.mark.slow
def test_drawn_programs_equal_the_interpreter() -> None:
    for seed in range(3, 3 + amount(15)):
        found = Relation(parse_program(drawn(seed))).differences(Random(seed), 8)
        assert found == [], f"program {seed}"


def test_what_is_not_modeled_is_unknown_and_named() -> None:
    found = relation("SIN(R,R);", "XIC(A)RTOS(R,Text);", "GRT(R,1.0)OTE(B);", more="")
    assert {str(site.rung) for site in found.machine.unmodeled.values()} == {"0", "1"}
    assert [name for _, name, _ in found.machine.cut] == ["RTOS"]
    assert found.differences(Random(1), 10) == []


def test_a_loop_without_a_known_end_is_deep_from_its_sixty_fifth_pass_on() -> None:
    found = relation("FOR(Sub,X,0,Most,1);", more="ROUTINE Sub\nADD(Arr[1],1,Arr[1]);\nEND\n")
    machine = found.machine
    deep = [evaluate([machine.deep], {"MOST[0]": most})[0] for most in (0, 63, 64, 100)]
    assert deep == [False, False, True, True]


@pytest.mark.parametrize(
    "rungs",
    [
        ("LBL(Again)XIC(A)JMP(Again);",),
        ("XIC(A)SSV(WallClockTime,,DateTime,Arr[0]);",),
    ],
)
def test_what_writes_elsewhere_or_leaves_the_rung_is_deep_where_it_acts(rungs: tuple[str, ...]) -> None:
    deep = relation(*rungs).machine.deep
    assert [evaluate([deep], {"A[0]": a})[0] for a in (False, True)] == [False, True]


def test_a_minor_fault_is_noted_where_it_happens() -> None:
    log: Any = relation("XIC(A)STOD(Text,X);").machine.fault_log
    found = [t for (_, kind), t in log.minor.items() if kind.startswith("minor fault")]
    assert [evaluate(found, {"A[0]": a, "TEXT.LEN[0]": 1, "TEXT.DATA[0]": 120}) for a in (True, False)]


TASKS = """CONTROLLER plant
TAG Count : DINT
TASK Fast : PERIODIC 20 ms PRIORITY 3 RUNS Filter
PROGRAM Filter
ROUTINE Step
ADD(Count,1,Count);
END
END PROGRAM
"""


@pytest.mark.parametrize(("dt", "may_run", "counts"), [(20, False, 1), (5, False, 0), (5, True, 1)])
def test_a_periodic_task_may_run_and_does_if_its_period_is_over(dt: int, may_run: bool, counts: int) -> None:
    forget()
    machine = ScanMachine(parse_program(TASKS).build())
    machine.scan_terms()
    values = {"~dt": dt, "?0": may_run, "COUNT[0]": 7}
    assert evaluate([machine.state["COUNT", 0]], values) == [7 + counts]


def test_a_claim_is_asked_wherever_the_scan_has_ended() -> None:
    """TND of an SLC ends the scan; what is asked behind it is asked all the same."""
    program = imported("XIC I:1/0 OTL B3:0/1", "XIC I:1/0 TND", "XIC B3:0/1 OTU B3:0/1").program
    assert not program.prove(never="B3:0/1")
    assert program.prove(never="B3:0/1 AND NOT I:1/0")


def test_what_is_not_modeled_may_write_the_status_file_of_an_slc() -> None:
    rungs = ("OTU S:5/0", "XPY N7:0 3 N7:1", "XIC S:5/0 OTE B3:0/1", "OTU S:5/0")
    program = imported(*rungs, data=["B3:0 0", "N7:0 40 0"]).program
    assert not program.prove(never="B3:0/1")


def test_inputs_that_rungs_write_come_anew_with_each_scan() -> None:
    program = imported("OTU I:1/2", "XIC I:1/0 OTE B3:0/1", data=["B3:0 0"]).program
    assert not program.prove(never="B3:0/1")


def test_a_case_whose_selector_is_not_modeled_may_take_any_choice() -> None:
    text = f"{HEAD}XIC(A)JSR(Pick);\nEND\nROUTINE Pick ST\nCASE SQR(X) OF\n3: B := 1;\nEND_CASE;\nEND\n"
    machine = Relation(parse_program(text)).machine
    assert [name for _, name, _ in machine.cut] == ["CASE"]
    (choice,) = [name for name in machine.unmodeled if machine.state["B", 0] is not FALSE][-1:]
    found = [evaluate([machine.state["B", 0]], {"A[0]": True, choice: taken})[0] for taken in (False, True)]
    assert found == [False, True]


def test_a_loop_under_a_condition_has_a_known_end() -> None:
    found = relation(
        "XIC(A)FOR(Sub,X,0,3,1);",
        more="ROUTINE Sub\nADD(Arr[X],1,Arr[X]);\nXIC(B)BRK();\nEND\n",
    )
    assert found.machine.cut == []
    assert found.differences(Random(1), 20) == []


def test_rows_take_numbers_and_truths_by_the_machine() -> None:
    """`int` and `bool` of a symbol are refused: what a row asks that way would not be modeled."""
    refused = re.compile(r"\b(?:int|bool|float)\((?:self\._)?machine\.(?:get|memory\.read)\(")
    rows = Path(instructions.__file__).parent.rglob("*.py")
    found = [
        f"{each.name}: {line.strip()}"
        for each in rows
        if "motion" not in each.parts
        for line in each.read_text(encoding="utf-8").splitlines()
        if refused.search(line)
    ]
    assert found == []
