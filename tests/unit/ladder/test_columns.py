"""COP and FLL of many elements work on columns of lists; the bytes are those of element by element."""

from scanrack.ladder.files import parse_program
from scanrack.ladder.state import regions

TYPES = "TYPE Part (On : BOOL, Word : DINT, Codes : SINT[6], Level : REAL, Late : TIMER)\n"
TAGS = """\
TAG Parts : Part[9]
TAG Others : Part[9]
TAG Longs : LINT[40]
TAG Words : INT[90]
TAG Bytes : SINT[300]
TAG Grid : DINT[5,6]
TAG Names : STRING[4]
"""
RUNGS = """\
COP(Bytes[0],Parts[1],7);
COP(Parts[1],Others[0],8);
COP(Parts[2].Codes[1],Words[3],3);
COP(Words[0],Longs[2],20);
COP(Longs[0],Grid[1,2],40);
COP(Grid[0,0],Names[0],2);
COP(Names[0].DATA[3],Bytes[7],60);
FLL(77,Words[60],40);
FLL(1.5,Others[5],3);
"""


def values(text, name, count, monkeypatch, one_by_one=False):
    with monkeypatch.context() as patch:
        if one_by_one:
            patch.setattr(regions, "_column", lambda *_: None)
        program = parse_program(text)
        found = []
        for engine in (program.compile(), program.interpret()):
            for number in range(count):
                engine.tags[f"{name}[{number}]"] = number * 37 % 256 - 128
            for _ in range(3):
                engine.step()
            found.append(repr(engine.memory.snapshot()))
        return found


def test_columns_are_what_element_by_element_is(monkeypatch):
    text = f"PROGRAM p\n{TYPES}{TAGS}ROUTINE Main\n{RUNGS}END\n"
    fast, slow = (values(text, "Bytes", 300, monkeypatch, one_by_one=each) for each in (False, True))
    assert fast == slow
    assert fast[0] == fast[1]


ADD_ON = """\
INSTRUCTION Buffer
INOUT Source : SINT[40]
LOCAL Copy : DINT[10]
LOCAL Parts : TIMER[3]
ROUTINE Logic
COP(Source[0],Copy[0],10)COP(Copy[1],Parts[0],3)FLL(5,Copy[8],2)COP(Parts[0],Source[4],36);
END
END INSTRUCTION
TAG Buffers : Buffer[3]
TAG Row : SINT[60]
"""


def test_columns_in_instances_of_add_ons(monkeypatch):
    text = f"PROGRAM p\n{ADD_ON}ROUTINE Main\nBuffer(Buffers[1],Row);\nEND\n"
    fast, slow = (values(text, "Row", 60, monkeypatch, one_by_one=each) for each in (False, True))
    assert fast == slow
    assert fast[0] == fast[1]
