"""Members that are other names of parts: packed bits in their host, aliased parameters; tags of modules."""

import pytest
from ladder_bench import Named
from scanrack.io_images.enip.listing import StructuredKind
from scanrack.ladder import LadderError
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program, program_text
from scanrack.ladder.state.listing import listing_of

MEMBERS = (
    "Number : INT, Host : SINT HIDDEN, Ready : BOOL AT Host.0, Late : BOOL AT Host.7, "
    "Words : INT[3], Third : BOOL AT Words[2].15"
)
TAGS = f"""\
TYPE Flags ({MEMBERS})
TAG F : Flags := {{"Number": 3, "Late": true}}
TAG Fs : Flags[2] := [{{}}, {{"Ready": true}}]
TAG Bytes : SINT[12]
TAG I : DINT
TAG Out : BOOL
"""


def engines(rungs, tags=TAGS):
    program = parse_program(f"PROGRAM p\n{tags}ROUTINE Main\n{rungs}\nEND\n")
    assert program_text(parse_program(program_text(program))) == program_text(program)
    return [Named("compiled", program.compile()), Named("interpreted", program.interpret())]


def test_a_packed_bit_is_a_bit_of_its_host_and_is_copied_there():
    for engine in engines("OTE(F.Ready);\nXIC(F.Late)OTE(Fs[I].Third);\nCOP(F,Bytes,12);"):
        engine.tags.I = 1
        engine.step()
        # Number 3 in two bytes, the host with bits 0 and 7, a byte of padding, the words
        assert engine.tags.Bytes == [3, 0, -127, 0, 0, 0, 0, 0, 0, 0, 0, 0], engine
        assert engine.tags["Fs[1].Words[2]"] == -32768, engine


def test_people_see_the_bits_and_not_their_host():
    for engine in engines("NOP();"):
        assert engine.tags.F == {
            "Number": 3,
            "Ready": False,
            "Late": True,
            "Words": [0, 0, 0],
            "Third": False,
        }
        assert engine.tags["Fs[1]"]["Ready"] is True
        engine.tags.F = {"Third": True, "Late": 0}
        assert (engine.tags["F.Words[2]"], engine.tags["F.Host"]) == (-32768, 0), engine


def test_two_coils_on_a_bit_and_its_other_name_are_seen():
    program = parse_program(f"PROGRAM p\n{TAGS}ROUTINE Main\nOTE(F.Ready);\nOTE(F.Host.0);\nEND\n")
    program.build()
    assert "F.Host.0 is written by a coil in routine Main, rung 0 already" in str(program.warnings[0])


def test_a_second_name_of_what_is_not_there_is_refused():
    with pytest.raises(LadderError, match=r"Ready of Bad is at Host\.0, which has no memory of its own"):
        engines("NOP();", "TYPE Bad (Ready : BOOL AT Host.0)\n")


ALIASED = """\
INSTRUCTION Delay
INPUT Time : DINT REQUIRED AT Wait.PRE := 30
INPUT Extra : BOOL AT Word.3
OUTPUT Done : BOOL REQUIRED AT Wait.DN
LOCAL Wait : TIMER
LOCAL Word : DINT
ROUTINE Logic
TON(Wait,?,?);
XIC(Extra)MOV(99,Wait.PRE);
END
END INSTRUCTION
"""


def test_an_aliased_parameter_is_a_part_of_a_local_tag():
    tags = f"{ALIASED}TAG D : Delay\nTAG Ds : Delay[2]\nTAG N : DINT := 10\nTAG Out : BOOL\n"
    for engine in engines("Delay(D,N,Out);", tags):
        assert engine.tags["Ds[1].Wait.PRE"] == 30, "the default of the parameter"
        engine.step()
        assert (engine.tags["D.Wait.PRE"], engine.tags.Out) == (10, False), engine
        engine.step(10)
        assert (engine.tags.Out, engine.tags["D.Done"]) == (True, True), engine
        engine.tags["D.Extra"] = True
        assert engine.tags["D.Word"] == 8
        engine.step(10)
        assert engine.tags["D.Time"] == 99, engine


MODULES = """\
TYPE Channel (Fault : DINT, Data : INT[8])
TAG Rack:3:O : INT[4]
TAG Drive:I : Channel
TAG Local:1:C : Channel := {"Fault": 5}
ALIAS Axis:I : Local:1:I
TAG Copy : Channel
TAG N : DINT
"""


def test_tags_of_modules_are_declared_and_copied_whole():
    rungs = (
        "COP(Local:1:C,Drive:I,1);\nMOV(Drive:I.Fault,Rack:3:O[2]);\n"
        "COP(Axis:I,Copy,1);\nADD(Axis:I.Data[1],1,N);"
    )
    for engine in engines(rungs, MODULES):
        engine.tags["Local:1:I.Data[1]"] = 41
        engine.step()
        assert engine.tags["Rack:3:O"] == [0, 0, 5, 0], engine
        assert (engine.tags["Copy.Data[1]"], engine.tags.N) == (41, 42), engine


def test_a_tag_of_a_module_that_is_not_declared_is_named():
    with pytest.raises(LadderError, match="no tag Rack:4:I"):
        engines("XIC(Rack:4:I.0)OTE(N.0);", MODULES)


def test_why_of_a_packed_bit():
    program = parse_program(f"PROGRAM p\n{TAGS}ROUTINE Main\nXIC(Out)OTE(F.Ready);\nEND\n")
    debugger = Debugger(program)
    debugger.tags.Out = True
    debugger.scan(2)
    assert debugger.why("F.Ready").startswith("F.Ready is 1 since scan 0 (0 s): OTE(F.Ready)")


PLACES = {  # bytes: Arr at 0, T at 16 with 12 each, J at 52 with 12 each (V at 0, W at 10), On at 76
    "All : DINT[4] AT Arr": ((4,), 0, None),
    "One : DINT AT Arr[1]": ((), 4, None),
    "Bit : BOOL AT Arr[2].13": ((), 9, 5),
    "Two : TIMER AT T[2]": ((), 40, None),
    "Acc : DINT AT T[1].ACC": ((), 36, None),
    "Vs : INT[5] AT J[1].V": ((5,), 64, None),
    "W1 : INT AT J[1].W": ((), 74, None),
    "Bits : BOOL[32] AT On": ((32,), 76, None),
    "Bit9 : BOOL AT On[9]": ((), 77, 1),
}


@pytest.mark.parametrize("second", PLACES)
def test_clients_see_a_second_name_at_the_place_of_what_it_names(second):
    """Expected: number of an element times its size; bit n of a DINT is bit n % 8 of byte n / 8."""
    own = "TYPE In (V : INT[5], W : INT)\nTYPE K (Arr : DINT[4], T : TIMER[3], J : In[2], On : BOOL[32], "
    program = parse_program(f"PROGRAM p\n{own}{second})\nTAG X : K\nROUTINE Main\nNOP();\nEND\n")
    (tag,) = listing_of(program.build().layout).tags
    assert isinstance(tag.kind, StructuredKind)
    part = tag.kind.parts[-1]
    assert (part.name, part.dims, part.offset, part.bit) == (second.split()[0], *PLACES[second])


@pytest.mark.parametrize("used", ["", "COP(X,Y,1);"])
def test_an_initial_value_has_a_second_name_also_of_an_element(used):
    kind = "TYPE K (Arr : DINT[4], All : DINT[4] AT Arr, One : DINT AT Arr[1], Bit : BOOL AT Arr[2].13)\n"
    tags = f'{kind}TAG X : K := {{"All": [5], "One": 7, "Bit": true}}\nTAG Y : K\n'
    for engine in engines(used or "NOP();", tags):
        assert engine.tags["X.Arr"] == [5, 7, 1 << 13, 0], engine
