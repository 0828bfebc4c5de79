"""What goes too deep, too far or on for ever gets the room's own error, and what is just allowed runs."""

import pytest
from ladder_bench import both, program_of
from scanrack.ladder import (
    DINT,
    MOV,
    BuildError,
    LadderError,
    LadderFault,
    Program,
    RungTextError,
    parse_rung,
)
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program
from scanrack.ladder.model.expressions import parse_address
from scanrack.ladder.model.tree import BRANCHES, LEVELS, SUBSCRIPT, Address, Operand, Operation, addresses_in
from scanrack.ladder.state import fault_log

TAGS = "TAG N : DINT := 1\nTAG D : DINT[4]\nTAG B : BOOL := true\nTAG T : TIMER"


def nested(depth):
    return "[" * depth + "XIC(B)" + ",AFI()]" * depth + "OTE(N.0);"


def total(terms):
    return f"CPT(N,{'+'.join(['1'] * terms)});"


def subscripts(depth):
    return f"MOV({'D[' * depth}0{']' * depth},N);"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (nested(200), f"at most {BRANCHES} nested branches"),
        (total(500), f"at most {LEVELS} levels of operators and subscripts"),
        (f"CPT(N,{'(' * (LEVELS + 1)}1{')' * (LEVELS + 1)});", f"at most {LEVELS} levels"),
        (f"CPT(N,{'NOT ' * (LEVELS + 1)}1);", f"at most {LEVELS} levels"),
        (f"CPT(N,{'-' * (LEVELS + 2)}1);", f"at most {LEVELS} levels"),
        (f"CPT(N,{'ABS(' * 500}1{')' * 500});", f"at most {LEVELS} levels"),
        (subscripts(200), f"at most {LEVELS} levels"),
        (f"XIC(N.{'[D.' * 200}0);", f"at most {LEVELS} levels"),
        (f"MOV({'9' * 20},N);", "a number of at most 64 bits"),
        (f"MOV(16#1{'0' * 16},N);", "a number of at most 64 bits"),
        (f"XIC(N.{'9' * 20})OTE(B);", "a number of at most 9 digits"),
        (f"XIC(N7:{'9' * 20})OTE(B);", "a number of at most 9 digits"),
        (f"XIC(I:1.0/{'9' * 20})OTE(B);", "a number of at most 9 digits"),
    ],
    ids=lambda text: text[:24],
)
def test_rung_text_that_goes_too_far(text, expected):
    with pytest.raises(RungTextError) as refused:
        parse_rung(text)
    assert expected in str(refused.value)


@pytest.mark.parametrize(
    ("rung", "result"),
    [(nested(BRANCHES), 1), (total(LEVELS + 1), LEVELS + 1), (subscripts(LEVELS // 3), 0)],
    ids=["branches", "operators", "subscripts"],
)
def test_what_is_just_allowed_is_read_built_and_run(rung, result):
    for engine in both(TAGS, rung):
        engine.step()
        assert result == engine.tags.N, engine
    assert str(parse_rung(str(parse_rung(rung)))) == str(parse_rung(rung))


def test_the_deepest_of_all_together():
    """Branches, operators and subscripts at their limits in one rung."""
    index = "D[" * 11 + "0" + "]" * 11
    text = f"{'[' * BRANCHES}CMP({'+'.join([index] * 60)}=0),AFI(){',AFI()'.join(']' * BRANCHES)}OTE(N.3);"
    for engine in both(TAGS, text):
        engine.step()
        assert engine.tags.N == 9, engine


def test_python_rungs_that_go_too_deep_name_their_line():
    program = Program("p")
    n = program.declare("N", DINT)

    def branches(rung):
        inner = n.bit(0)
        for _ in range(200):
            inner = [inner]
        rung(inner)

    def endless(rung):
        inner: list[object] = []
        inner.append(inner)
        rung(inner)

    def terms(rung):
        rung(sum([n] * 500) > 5)

    for function in (branches, endless, terms):
        with pytest.raises(LadderError, match=r"test_ladder_limits\.py:\d+: rung 0: .*deep|levels"):
            program.routine(function)


def test_subroutines_call_each_other_up_to_a_depth():
    def chain(length):
        routines = [f"ROUTINE R{each}\nJSR(R{each + 1},0);\nEND" for each in range(length)]
        return "\n".join(["PROGRAM p\nTAG N : DINT", *routines, f"ROUTINE R{length}\nADD(N,1,N);\nEND\n"])

    for engine in (parse_program(chain(49)).compile(), parse_program(chain(49)).interpret()):
        engine.step()
        assert engine.tags.N == 1
    with pytest.raises(BuildError, match="routine R0: its calls go more than 50 deep"):
        parse_program(chain(50)).build()


def test_python_routines_that_call_for_ever_end_in_a_fault():
    program = Program("p")
    program.declare("N", DINT)

    @program.routine
    def Main(rung):  # noqa: N802
        rung("JSR(Again,0);")

    @program.routine
    def Sub(rung):  # noqa: N802
        rung("JSR(Again,0);")

    @program.function
    def Again(_tags, *, jsr):  # noqa: N802
        jsr("Sub")

    for engine in (program.compile(), program.interpret()):
        with pytest.raises(LadderFault, match="type 4 code 84"):
            engine.step()


def test_a_main_routine_takes_no_inputs():
    with pytest.raises(BuildError, match="a scan passes none to the main routine"):
        program_of(TAGS, "SBR(N);").build()
    for engine in both(TAGS, "SBR()ADD(N,1,N);"):
        engine.step()
        assert engine.tags.N == 2, engine


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (f"TAG Z : DINT := {'[' * 900}", "an initial value in JSON"),
        (f"TAG Z : DINT := {'[' * 1_001}", "brackets that are nested deeper than 1000"),
        ("TAG Z : DINT[,]", "the length of each dimension"),
        (f"TAG Z : DINT[{'9' * 4000}]", "the length of each dimension"),
        ("TAG Z : DINT[999999999]", "has more than 33,554,432 bytes"),
        (f"SLOT z : {'9' * 4000}", "USE, TYPE, INSTRUCTION"),
    ],
    ids=lambda text: text[:20],
)
def test_declarations_that_go_too_far(line, expected):
    with pytest.raises(LadderError) as refused:
        parse_program(f"PROGRAM p\n{line}\nROUTINE Main\nNOP();\nEND\n")
    assert expected in str(refused.value)


def test_presets_are_dints():
    with pytest.raises(BuildError, match="PRE 2147483648 is not a DINT"):
        program_of(TAGS, "TON(T,2147483648,0);").build()


@pytest.mark.parametrize("rung", ["LBL(3);", "LBL(N[1]);", "JMP(1+2);", "SBR(N.99);", "JSR(1,0);"])
def test_a_wrong_operand_of_program_control_is_a_problem_of_its_rung(rung):
    with pytest.raises(LadderError):
        program_of(TAGS, rung).build()


# -- the watchdog


@pytest.mark.parametrize(
    "rungs",
    [("LBL(L)JMP(L);",), ("LBL(L)ADD(N,1,N);", "NOP();", "JMP(L);")],
    ids=["one rung", "three rungs"],
)
def test_a_scan_that_does_not_end_is_stopped(rungs, monkeypatch):
    monkeypatch.setattr(fault_log, "MOST_JUMPS", 1000)
    engines = both(TAGS, *rungs)
    engines.append(Debugger(program_of(TAGS, *rungs)))
    for engine in engines:
        step = engine.scan if isinstance(engine, Debugger) else engine.step
        with pytest.raises(LadderFault, match=r"JMP\(L\).*watchdog: .* \(major fault, type 6 code 1\)"):
            step()
        if len(rungs) == 3:
            assert engine.tags.N == 1002  # the first pass, and one per jump


def test_the_watchdog_counts_per_scan_and_backwards_only(monkeypatch):
    """Three jumps back and one forward in each scan; four would be one too many."""
    monkeypatch.setattr(fault_log, "MOST_JUMPS", 3)
    tags = TAGS + "\nTAG Left : DINT"
    rungs = (
        "MOV(3,Left);",
        "JMP(Over);",
        "NOP();",
        "LBL(Over)NOP();",
        "LBL(L)GRT(Left,0)SUB(Left,1,Left)JMP(L);",
    )
    for engine in both(tags, *rungs):
        for _ in range(5):
            engine.step()
        assert engine.tags.Left == 0, engine


@pytest.mark.parametrize(("depth", "fits"), [(LEVELS // SUBSCRIPT, True), (LEVELS // SUBSCRIPT + 1, False)])
def test_subscripts_made_in_python_have_the_limit_of_text(depth, fits):
    program = Program("p")
    array = program.declare("D", DINT, 4)
    place = array[0]
    for _ in range(depth - 1):
        place = array[place]

    def main(rung):
        rung(MOV(1, place))

    if fits:
        program.routine(main)
        program.build()
    else:
        with pytest.raises(LadderError, match=f"an operand of MOV has more than {LEVELS} levels"):
            program.routine(main)


def test_addresses_of_a_long_sum_are_found_one_by_one():
    """A generator within a generator for each level is quadratic in the terms, and ends at Python's depth."""
    total: Operand = Address("V0")
    for place in range(1, 5_000):
        total = Operation("+", (total, Address(f"V{place}")))
    assert [each.name for each in addresses_in(total)] == [f"V{place}" for place in range(5_000)]
    nested = parse_address("A[B[C],D].[E]")
    assert [each.name for each in addresses_in(nested)] == ["A", "B", "C", "D", "E"]
