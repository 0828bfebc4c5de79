"""What exported rungs contain beside the plain: numbers, functions, empty rungs, calls without parameters."""

import math

import pytest
from ladder_bench import both, program_of
from scanrack.io_images.image import Image
from scanrack.ladder import LadderFault, RungTextError, parse_rung
from scanrack.ladder.compiler.services import regions_of, services
from scanrack.ladder.files import parse_program
from scanrack.ladder.model.tags import RESERVED
from scanrack.ladder.state.fault_log import MOST_RECURSION

TAGS = """TYPE Part (Size : INT, Good : BOOL, Weight : REAL, Marks : SINT[2])
TAG N : DINT
TAG R : REAL
TAG B : BOOL
TAG T : TIMER
TAG Parts : Part[3]
SLOT axis : 1"""


@pytest.mark.parametrize(
    ("written", "value"),
    [
        (".5", 0.5),
        ("-.25", -0.25),
        ("2.", 2.0),
        ("1.$", math.inf),
        ("-1.$", -math.inf),
        ("1.#INF", math.inf),
        ("1.#QNAN", math.nan),
        ("-1.#IND", math.nan),
    ],
)
def test_numbers_as_exports_print_them(written, value):
    rung = parse_rung(f"MOV({written},R);")
    assert str(rung) == f"MOV({written},R);"
    assert parse_rung(str(rung)) == rung
    for engine in both(TAGS, str(rung)):
        engine.step()
        assert value == engine.tags.R or (math.isnan(value) and math.isnan(engine.tags.R))


@pytest.mark.parametrize(
    ("written", "ms"),
    [
        ("T#5s", 5_000),
        ("t#1m30s", 90_000),
        ("TIME#1h0m0.5s", 3_600_500),
        ("T#250ms", 250),
        ("T#1d", 86_400_000),
    ],
)
def test_times_are_milliseconds(written, ms):
    for engine in both(TAGS, f"TON(T,{written},0);", f"MOV({written},N);"):
        engine.step()
        assert (engine.tags["T.PRE"], engine.tags.N) == (ms, ms)
    assert str(parse_rung(f"TON(T,{written},0);")) == f"TON(T,{written.upper()},0);"


@pytest.mark.parametrize(
    ("written", "expected"),
    [("T#5", "a time such as T#5s"), ("T#1.5ms", "whole milliseconds"), ("1.#HUH", "a number, 1.$")],
)
def test_what_is_no_number(written, expected):
    with pytest.raises(RungTextError) as refused:
        parse_rung(f"MOV({written},R);")
    assert expected in str(refused.value)


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("SIN(0.5)", math.sin(0.5)),
        ("COS(N)", math.cos(2)),
        ("TAN(1)", math.tan(1)),
        ("ASIN(1)", math.pi / 2),
        ("ACOS(0)", math.pi / 2),
        ("ATN(1)*4", math.pi),
        ("LN(N)", math.log(2)),
        ("LOG(1000)", 3.0),
        ("DEG(RAD(180))", 180.0),
        ("SQRT(N*8)", 4.0),
        ("TRUNC(-2.9)", -2.0),
        ("N/3+SIN(0)", 2 / 3),  # a function of REAL makes the whole expression REAL
    ],
)
def test_functions_in_expressions(expression, value):
    for engine in both(TAGS, f"CPT(R,{expression});"):
        engine.tags.N = 2
        engine.step()
        assert pytest.approx(value, abs=1e-6) == engine.tags.R
        assert not engine.minor_faults


@pytest.mark.parametrize(("expression", "result"), [("LN(0)", "-inf"), ("LN(-1)", "nan"), ("ASN(2)", "nan")])
def test_functions_outside_of_their_domain_are_a_minor_fault(expression, result):
    for engine in both(TAGS, f"CPT(R,{expression});"):
        engine.step()
        assert str(engine.tags.R) == result
        assert [each.code for each in engine.minor_faults] == [4]


def test_functions_are_names_that_no_tag_takes_in_the_compiled_program():
    engine = parse_program("PROGRAM p\nTAG B : BOOL\nROUTINE Main\nOTE(B);\nEND\n").compile()
    names = {name for name in services(engine, regions_of(engine.lowered), {}) if name[:7] != "string_"}
    assert names - RESERVED == set()
    assert {"float", "len", "abs", "min", "max", "bytes"} <= RESERVED
    for name in ("converted", "max", "put_text_82", "string_MID"):
        rung = f"ADD({name},1,{name})DTOS({name},T);"
        program = parse_program(f"PROGRAM p\nTAG {name} : DINT\nTAG T : STRING\nROUTINE Main\n{rung}\nEND\n")
        program.step()
        assert (program.tags[name], program.tags["T"]) == (1, "1")


def test_an_empty_rung_does_nothing():
    text = "PROGRAM p\nTAG B : BOOL\nROUTINE Main\n;\n// only a comment\n;\nOTE(B);\nEND\n"
    program = parse_program(text)
    assert program.text("Main") == ";\n;\nOTE(B);"
    program.step()
    assert program.tags.B


def test_a_call_with_zero_parameters_both_ways():
    source = "PROGRAM p\nTAG B : BOOL\nROUTINE Main\nJSR(Sub,0,0);\nEND\nROUTINE Sub\nOTE(B);\nEND\n"
    for engine in (parse_program(source).compile(), parse_program(source).interpret()):
        engine.step()
        assert engine.tags.B


RECURSIVE = """PROGRAM p
TAG N : DINT
TAG Sum : DINT
ROUTINE Main
MOV(0,Sum);
JSR(Down,0);
END
ROUTINE Down
ADD(Sum,N,Sum);
SUB(N,1,N);
GRT(N,0)JSR(Down,0);
END
"""


def test_a_routine_may_call_itself():
    for engine in (parse_program(RECURSIVE).compile(), parse_program(RECURSIVE).interpret()):
        for _ in range(3):
            engine.tags.N = MOST_RECURSION
            engine.step()
            assert engine.tags.Sum == MOST_RECURSION * (MOST_RECURSION + 1) // 2
        engine.tags.N = MOST_RECURSION + 1
        with pytest.raises(LadderFault) as stopped:
            engine.step()
        assert (stopped.value.type, stopped.value.code) == (4, 84)
        assert f"more than {MOST_RECURSION} deep" in str(stopped.value)


def test_fll_fills_structures_member_by_member():
    for engine in both(TAGS, "FLL(N,Parts[1],5);"):
        for number in range(3):
            engine.tags[f"Parts[{number}]"] = {"Size": 9, "Good": True, "Weight": 1.5, "Marks": [1, 2]}
        engine.tags.N = 0
        engine.step()
        zero = {"Size": 0, "Good": False, "Weight": 0.0, "Marks": [0, 0]}
        assert engine.tags["Parts[0].Size"] == 9
        assert [engine.tags["Parts[1]"], engine.tags["Parts[2]"]] == [zero, zero]
        engine.tags.N = 257
        engine.step()
        assert engine.tags["Parts[2]"] == {"Size": 257, "Good": True, "Weight": 257.0, "Marks": [1, 1]}


class Slot:
    def __init__(self):
        self.inputs, self.outputs, self.fault = Image([3]).read_only(), Image(), 0


class Scan:
    def __init__(self):
        self.slot, self.now_ns, self.first, self.updated = {1: Slot()}, 0, True, True


def test_inputs_may_be_written_and_that_is_a_warning():
    rungs = (
        "XIC(B)OTE(Local:1:I.Data[0].4);",
        "MOV(7,Local:1:I.Data[2]);",
        "COP(Local:1:I.Data[0],Local:1:I.Data[4],3);",
        "MOV(Local:1:I.Data[0],Local:1:O.Data[1]);",
    )
    program = program_of(TAGS, *rungs)
    assert "Local:1:I.Data[0].4 is an input: its module writes over it" in str(program.warnings[0])
    for engine in (program.compile(), program.interpret()):
        scan = Scan()
        engine.attach(scan)
        engine.tags.B = True
        engine(scan)
        assert [engine.tags[f"Local:1:I.Data[{word}]"] for word in range(8)] == [19, 0, 7, 0, 19, 0, 7, 0]
        assert list(scan.slot[1].inputs) == [3, 0, 0, 0, 0, 0, 0, 0]  # what the module said
        assert scan.slot[1].outputs[1] == 19
