"""A module's image under the names of a declared structure: words, bits, whole copies, in both back ends."""

import pytest
from ladder_bench import both, program_of
from scanrack.ladder import BuildError
from scanrack.ladder.files import parse_program, program_text
from scanrack.runtime import Amci3601, Card, Cpu, Rack

MS = 1_000_000
TAGS = """TYPE Inputs (Fault : DINT, Data : INT[8], Ready : BOOL AT Data[0].3, Position : INT AT Data[2])
TYPE Outputs (Data : INT[8], Go : BOOL AT Data[1].2, Speed : INT AT Data[4])
TYPE Short (Data : INT[4])
ALIAS Drive:I : Local:1:I AS Inputs
ALIAS Drive:O : Local:1:O AS Outputs
ALIAS Second : Drive:I
TAG Copy : Inputs
TAG Order : Outputs := {"Data": [1, 4, 0, 0, 5]}
TAG Ok : BOOL
TAG Word : INT
TAG Last : INT"""


def stepped(*rungs, words=(), tags=TAGS):
    for engine in both(tags, *rungs):
        for word, value in enumerate(words):
            engine.tags[f"Local:1:I.Data[{word}]"] = value
        engine.step()
        yield engine


def test_members_are_bits_and_words_of_the_image():
    rungs = "XIC(Drive:I.Ready)OTE(Ok)MOV(Drive:I.Position,Word);", "MOV(Second.Data[7],Last);"
    for engine in stepped(*rungs, words=(8, 0, 77, 0, 0, 0, 0, -3)):
        assert (engine.tags.Ok, engine.tags.Word, engine.tags.Last) == (True, 77, -3), engine
    for engine in stepped(*rungs, words=(7, 0, 0)):
        assert (engine.tags.Ok, engine.tags.Word) == (False, 0), engine


def test_a_whole_module_is_copied():
    for engine in stepped("COP(Drive:I,Copy,1);", words=(8, 0, 77)):
        assert (engine.tags["Copy.Ready"], engine.tags["Copy.Position"]) == (True, 77), engine
        assert engine.tags["Drive:I"] == engine.tags["Copy"], engine
        assert engine.tags["Drive:I.Ready"] is True


def test_outputs_reach_the_rack():
    rungs = "OTE(Drive:O.Go);", "MOV(9,Drive:O.Speed);"
    for written, expected in ((rungs, [0, 4, 0, 0, 9]), (("COP(Order,Drive:O,1);",), [1, 4, 0, 0, 5])):
        for engine in both(TAGS, *written):
            rack = Rack([Card(1, Amci3601("4.1"), "amci3601", "4.1")])
            Cpu(rack, engine.engine, 2 * MS).run(1)
            assert list(rack.slots[1].outputs) == [*expected, 0, 0, 0], engine


def test_the_text_says_the_type():
    program = program_of(TAGS, "XIC(Drive:I.Ready)OTE(Ok);")
    text = program_text(program)
    assert "ALIAS Drive:I : Local:1:I AS Inputs" in text
    assert text.index("TYPE Inputs") < text.index("ALIAS Drive:I")
    assert program_text(parse_program(text)) == text


@pytest.mark.parametrize(
    ("alias", "message"),
    [
        ("Local:1:I AS Short", "Short has other bytes than Local:1:I"),
        ("Local:1:O AS Inputs", "declare Data : INT[8], and other members AT parts of Data"),
        ("Copy AS Inputs", "Copy is not a module's image"),
        ("Local:1:I.Data[0] AS Inputs", "is not a module's image"),
    ],
)
def test_what_has_other_bytes_is_refused(alias, message):
    with pytest.raises(BuildError) as refused:
        program_of(f"{TAGS}\nALIAS Wrong : {alias}", "MOV(Wrong.Data[0],Word);").build()
    assert message in str(refused.value)
