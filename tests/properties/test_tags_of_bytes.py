"""Structures in bytes: the layout of a controller's memory, and both back ends in lockstep on them."""

import struct
from unittest.mock import patch

import pytest
from amounts import amount
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ladder_lockstep import check_debugged, check_lockstep, check_observed
from ladder_programs import programs, stimuli
from scanrack.ladder.files import parse_program
from scanrack.ladder.lowering import storage

HEAD = """PROGRAM bytes
ALLOW repeated coils
TYPE Part (Size : INT, Good : BOOL, Bad : BOOL, Weight : REAL, Marks : SINT[3], Flags : BOOL[40], Long : LINT)
TYPE Name (LEN : DINT, DATA : SINT[7])
TYPE Tray (Number : USINT, Parts : Part[3], Word : UINT, Label : Name, Delay : TIMER, Fine : LREAL, \
Sum : UDINT)
TAG Tray0 : Tray
TAG Trays : Tray[4] := [{"Number": 200, "Label": "abc", "Delay": {"PRE": 25}}, {"Sum": 4294967295}]
TAG Part0 : Part := {"Size": -2, "Bad": true, "Weight": -0.0}
TAG Names : Name[3] := ["xyz", "1234567", "-7.5"]
TAG Text : STRING := "Station 4"
TAG Raw : DINT[12] := [7, -1, 65536, 2147483647]
TAG Codes : INT[9] := [1, 2, 3, 4]
TAG Shorts : USINT[30] := [255, 1, 2]
TAG Reals : REAL[6] := [1.5, 1e38, -0.0]
TAG Lamps : BOOL[8] := [true, false, true]
TAG I : DINT := 1
TAG J : DINT
TAG Len : DINT := 2
TAG Start : DINT := 1
TAG On : BOOL := true
INSTRUCTION Sorter
INPUT Number : DINT REQUIRED
INOUT Item : Part
INOUT Shelf : Tray[2]
INOUT Title : Name
INOUT Size : INT
INOUT Bit : BOOL
INOUT Row : SINT[3]
LOCAL Kept : Part
LOCAL Last : Name
LOCAL Own : INT[4]
ROUTINE Logic
COP(Item,Kept,1);
COP(Shelf[0].Parts[Number],Item,1);
XIC(Bit)OTE(Kept.Flags[Number]);
XIC(Kept.Flags[Number])OTE(Item.Good);
CONCAT(Title,Last,Last);
MOV(Last,Title);
ADD(Size,1,Size);
FLL(0,Shelf[1].Label,1);
COP(Row[0],Own[0],2);
TON(Shelf[1].Delay,?,?);
XIC(Shelf[1].Delay.TT)OTE(Bit);
END
END INSTRUCTION
TAG Sort0 : Sorter
TAG Sorts : Sorter[2]
"""

LINES = (
    "COP(Tray0,Trays[I],1);",
    "COP(Trays[0],Trays[1],2);",
    "COP(Trays[1],Trays[0],9);",
    "COP(Trays[I],Raw[0],Len);",
    "CPS(Raw[J],Trays[2],Len);",
    "COP(Raw[0],Part0,1);",
    "COP(Part0,Trays[I].Parts[J],Len);",
    "COP(Trays[I].Parts[0],Tray0.Parts[1],5);",
    "COP(Trays[0].Parts[0].Marks[J],Shorts[3],Len);",
    "COP(Shorts[I],Text,1);",
    "COP(Text,Codes[1],20);",
    "COP(Names[0],Names[1],Len);",
    "COP(Names[I],Text,1);",
    "COP(Reals[0],Trays[I].Fine,1);",
    "COP(Codes[0],Reals[J],Len);",
    "FLL(0,Trays[I],Len);",
    "FLL(Len,Tray0.Parts[0],2);",
    "FLL(-1.5,Part0,1);",
    "FLL(300,Shorts[2],4);",
    "FLL(0,Raw[3],Len);",
    "XIC(Part0.Flags[I])OTE(Trays[J].Parts[1].Flags[39]);",
    "XIC(On)OTE(Tray0.Parts[I].Flags[Len]);",
    "XIO(Trays[I].Parts[J].Bad)OTL(Part0.Good);",
    "ADD(Trays[I].Sum,1,Trays[J].Sum);",
    "SUB(Tray0.Number,7,Tray0.Number);",
    "MUL(Part0.Weight,1.5,Trays[I].Fine);",
    "MOV(Trays[I].Word,Part0.Size);",
    "MOV(Len,Names[I].LEN);",
    "MOV(Names[I],Tray0.Label);",
    "MOV('ab$00c',Trays[I].Label);",
    "CONCAT(Names[0],Text,Names[I]);",
    "MID(Text,Len,Start,Tray0.Label);",
    "DELETE(Text,Len,Start,Names[J]);",
    "INSERT(Names[I],Tray0.Label,Start,Text);",
    "FIND(Text,'t',Start,Trays[I].Word);",
    "FIND(Text,Names[0],Start,Trays[I].Number);",
    "DTOS(Trays[I].Sum,Names[J]);",
    "RTOS(Part0.Weight,Text);",
    "STOD(Names[J],Trays[I].Number);",
    "STOR(Text,Part0.Weight);",
    "UPPER(Text,Names[J]);",
    "DTOS(Len,Text)CONCAT('n ',Text,Names[0])CONCAT(Names[0],Text,Names[1]);",
    "XIC(On)MID(Text,Len,Start,Names[0])CONCAT(Names[0],Names[0],Text)STOD(Text,Raw[1]);",
    "CONCAT(Names[0],Names[2],Names[0])STOD(Names[0],Names[0].LEN)UPPER(Names[0],Text);",
    "DTOS(Len,Names[0])DTOS(Trays[I].Sum,Names[J])LOWER(Names[0],Text)FIND(Text,'1',1,Names[1].LEN);",
    "EQU(Names[I],Tray0.Label)ADD(J,1,J);",
    "GRT(Text,Names[J])MOV(0,J);",
    "TON(Trays[I].Delay,?,?);",
    "XIC(On)Sorter(Sort0,J,Part0,Trays,Names[I],Codes[I],Lamps[J],Part0.Marks);",
    "Sorter(Sorts[I],1,Trays[J].Parts[2],Trays,Trays[I].Label,Part0.Size,Part0.Flags[J],Part0.Marks);",
    "XIC(Sort0.Kept.Good)OTE(On);",
    "COP(Sort0.Kept,Part0,1);",
)
"""Rungs on structures, strings and arrays; I, J, Len and Start may be out of range."""


def text_of(lines):
    return HEAD + "\n".join(["ROUTINE Main", *lines, "END"]) + "\n"


scans = st.lists(
    st.tuples(
        st.sampled_from((1.0, 30.0)),
        st.dictionaries(st.sampled_from(("I", "J")), st.integers(0, 2)),
        st.dictionaries(st.sampled_from(("Len", "Start")), st.integers(-2, 12)),
        st.dictionaries(st.sampled_from(("I", "J")), st.integers(-1, 4), max_size=1),
    ),
    min_size=1,
    max_size=4,
)
SETTINGS = settings(
    max_examples=amount(5),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


def all_in_bytes():
    """Lay out as bytes whatever may be: no use of a single value counts."""
    return patch.multiple(storage, _VALUE_NS=-1)


def none_in_bytes():
    return patch.multiple(storage, _VALUE_NS=1 << 40)


def in_bytes(program):
    return program.build().layout.in_bytes


@SETTINGS
@given(st.lists(st.sampled_from(LINES), min_size=1, max_size=10), scans)
def test_both_back_ends_in_lockstep_on_structures(lines, scans):
    check_lockstep(text_of(lines), scans)


@SETTINGS
@given(st.lists(st.sampled_from(LINES), min_size=1, max_size=10), scans)
def test_both_back_ends_in_lockstep_with_everything_in_bytes(lines, scans):
    with all_in_bytes():
        check_lockstep(text_of(lines), scans)


@pytest.mark.slow
@SETTINGS
@given(programs(), stimuli())
def test_any_program_in_lockstep_with_everything_in_bytes(text, scans):
    with all_in_bytes():
        check_lockstep(text, scans)


@settings(SETTINGS, max_examples=amount(3))
@given(st.lists(st.sampled_from(LINES), min_size=2, max_size=8), scans, st.data(), st.booleans())
def test_forces_breakpoints_and_scans_again_with_everything_in_bytes(lines, scans, data, watched):
    with all_in_bytes():
        check_observed(text_of(lines), scans, lambda choices: data.draw(st.sampled_from(choices)))
        check_debugged(text_of(lines), scans, watched=watched)


@SETTINGS
@given(st.lists(st.sampled_from(LINES), min_size=1, max_size=6), scans)
def test_bytes_and_variables_hold_the_same(lines, scans):
    """A program with its tags in bytes, and in variables and lists; only bytes keep what is in a gap."""
    lines = [
        each for each in lines if "Raw" not in each and "Shorts" not in each and "Codes[1],20" not in each
    ]
    found = []
    for mode in (all_in_bytes, none_in_bytes):
        with mode():
            engine = parse_program(text_of(lines)).compile()
        for ms, *groups in scans:
            for name, value in (pair for group in groups for pair in group.items()):
                engine.tags[name] = value
            try:
                engine.step(ms)
            except Exception as fault:
                found.append(str(fault))
                break
        found.append(repr(engine.memory.snapshot()))
    half = len(found) // 2
    assert found[:half] == found[half:]


# --- the layout: formats of `struct` written down from 1756-PM020, "Data types"

PART = "<hBxf3sx8s4xq"  # SIZE, two bits, WEIGHT, MARKS, 40 bits in two DINTs, LONG at a multiple of 8
REST = "<H2xi7sx3I4xdI4x"  # of a tray after its parts: UINT, a STRING of 7, a TIMER, an LREAL, a UDINT


def part_of(tags, name):
    data = tags[name]
    flags = sum(on << number for number, on in enumerate(data["Flags"]))
    bits = data["Good"] | data["Bad"] << 1
    marks = bytes(each & 255 for each in data["Marks"])
    return struct.pack(
        PART, data["Size"], bits, data["Weight"], marks, flags.to_bytes(8, "little"), data["Long"]
    )


def test_a_structure_has_the_bytes_of_a_controller():
    program = parse_program(text_of(["COP(Part0,Trays[1].Parts[2],1);", "COP(Part0,Tray0,1);"]))
    engine = program.compile()
    value = {
        "Size": -513,
        "Good": True,
        "Bad": False,
        "Weight": 2.5,
        "Marks": [1, -1, 127],
        "Long": -(1 << 40),
    }
    engine.tags["Part0"] = value | {"Flags": [number % 3 == 0 for number in range(40)]}
    engine.step(1)
    assert "PART0" in in_bytes(program)
    raw = engine.memory.cells["Part0"].cell_contents.saved()[0]
    size = struct.calcsize(PART)
    assert raw[:size] == part_of(engine.tags, "Part0")
    assert engine.tags["Trays[1].Parts[2]"] == engine.tags["Part0"]
    # Trays[1] begins after one tray: USINT, 3 parts from 8 on, the rest
    tray = struct.calcsize("<B7x") + 3 * size + struct.calcsize(REST)
    trays = engine.memory.cells["Trays"].cell_contents.saved()[0]
    assert len(trays) == 4 * tray
    assert trays[tray + 8 + 2 * size :][:size] == raw[:size]


def test_not_a_number_keeps_its_bits():
    lines = ["COP(Raw[0],Part0,2);", "COP(Part0,Trays[0].Parts[0],1);", "COP(Trays[0].Parts[0],Raw[6],6);"]
    engine = parse_program(text_of(lines)).compile()
    engine.tags["Raw"] = [0, 0x7F80_0001, 3, 4, 5, 6, 0, 0, 0, 0, 0, 0]  # the second is a signaling NaN
    engine.step(1)
    assert engine.tags["Raw"][6:9] == [0, 0x7F80_0001, 3]


@pytest.mark.parametrize(
    ("line", "after"),
    [
        ("COP(Names[0],Names[1],2);", ["a", "a", "b"]),  # onto itself, as if by way of a copy
        ("COP(Names[1],Names[0],2);", ["b", "c", "c"]),
        ("COP(Names[2],Names[1],5);", ["a", "c", "c"]),  # up to the end of the source
        ("COP(Names[0],Names[2],5);", ["a", "b", "a"]),  # up to the end of the destination
        ("COP(Names[0],Names[1],0);", ["a", "b", "c"]),
        ("COP(Names[0],Names[1],Minus);", ["a", "b", "c"]),
        ("FLL(0,Names[1],9);", ["a", "", ""]),
        ("FLL(0,Names[1],Minus);", ["a", "b", "c"]),
    ],
)
def test_ends_of_copies(line, after):
    text = HEAD.replace('["xyz", "1234567", "-7.5"]', '["a", "b", "c"]') + "TAG Minus : DINT := -1\n"
    program = parse_program(text + f"ROUTINE Main\n{line}\nEND\n")
    for engine in (program.compile(), program.interpret()):
        engine.step(1)
        assert engine.tags["Names"] == after
    assert "NAMES" in in_bytes(program)


def test_len_out_of_range_of_a_string():
    """RM003, ASCII string instructions: a LEN above the size of DATA is fault 4/51; below 0 it is empty."""
    program = parse_program(text_of(["MOV(Len,Names[0].LEN);", "CONCAT(Names[0],'x',Names[1]);"]))
    for engine in (program.compile(), program.interpret()):
        engine.tags["Len"] = 8
        engine.step(1)
        assert (engine.tags["Names[1]"], [each.code for each in engine.minor_faults]) == ("1234567", [51])
        engine.tags["Len"] = -1
        engine.step(1)
        assert engine.tags["Names[1]"] == "x"


def test_what_no_instruction_uses_as_a_whole_is_no_bytes():
    program = parse_program(text_of(["XIC(Part0.Good)OTE(Part0.Bad);", "MOV(Raw[0],Trays[I].Word);"]))
    assert in_bytes(program) & {"PART0", "TRAYS", "RAW"} == set()


def test_a_small_structure_with_many_single_uses_stays_variables():
    head = "PROGRAM p\nTYPE Pair (One : DINT, Two : DINT)\nTAG A : Pair\nTAG B : Pair\nROUTINE Main\n"
    program = parse_program(head + "COP(A,B,1);\nMOV(A.One,B.Two);\nMOV(A.Two,B.One);\nEND\n")
    assert in_bytes(program) == set()
    assert "B_One = A_One" in program.source()
