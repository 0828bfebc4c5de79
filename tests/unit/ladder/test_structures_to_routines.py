"""Structures, strings and arrays go to a routine and back by value [1756-RM003N, JSR]."""

import pytest
from scanrack.ladder import BuildError, Program
from scanrack.ladder.files import parse_program

HEAD = """\
PROGRAM p
TYPE Inner (A : INT, B : REAL[2], Name : STRING)
TYPE Rec (Id : DINT, Ok : BOOL, In : Inner[2])
TAG X : Rec := {"Id": 7, "In": [{"A": 3, "B": [1.5, 2.5], "Name": "ab"}, {"A": 9}]}
TAG Y : Rec
TAG Table : Rec[4]
TAG At : DINT := 2
TAG List : INT[5] := [1, 2, 3, 4, 5]
TAG Taken : INT[5]
TAG Back : INT[5]
TAG Long : INT[6]
TAG Said : STRING := "hello"
TAG Heard : STRING
TAG Answer : STRING
TAG N : DINT
TAG M : DINT
ROUTINE Main
"""
SUB = """\
END
ROUTINE Sub
SBR(Y,Taken,Heard,N);
ADD(Y.Id,1,Y.Id)ADD(Taken[4],N,Taken[4])CONCAT(Heard,'!',Heard)ADD(N,1,N);
RET(Y,Taken,Heard,N);
END
"""


def test_they_are_copied_in_and_out():
    """The caller's own tags stay; a second scan begins with them again."""
    program = parse_program(f"{HEAD}JSR(Sub,4,X,List,Said,5,Table[At],Back,Answer,M);\n{SUB}")
    for engine in (program.interpret(), program.compile()):
        for _ in range(2):
            engine.step()
        tags = engine.tags
        assert (tags["Table[2].Id"], tags["Table[2].In[0].B[1]"], tags["Table[2].In[1].A"]) == (8, 2.5, 9)
        assert (tags["Table[2].In[0].Name"], tags.Answer, tags.M) == ("ab", "hello!", 6)
        assert [tags[f"Back[{each}]"] for each in range(5)] == [1, 2, 3, 4, 10]
        assert (tags["X.Id"], tags["List[4]"], tags.Said, tags["Table[1].Id"]) == (7, 5, "hello", 0)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        ("JSR(Sub,4,X,Long,Said,5);", "Sub takes INT[5], INT[6] is passed"),
        ("JSR(Sub,4,Said,List,Said,5);", "Sub takes Rec, STRING is passed"),
        ("JSR(Sub,4,X,List,Said,5,X.In[0]);", "RET in rung 2 of Sub returns Rec; JSR expects Inner"),
        ("JSR(Sub,3,X,List,Said);", "Sub has 4 inputs, but JSR passes 3"),
    ],
)
def test_another_type_or_too_few_are_refused(call, says):
    with pytest.raises(BuildError) as refused:
        parse_program(f"{HEAD}{call}\n{SUB}").build()
    assert says in str(refused.value)


def test_inputs_that_no_sbr_takes_are_left_alone():
    """A JSR may have more of them than its SBR; with fewer a controller faults, 4/31."""
    program = parse_program(
        f"{HEAD}JSR(Sub,5,X,List,Said,5,N);\nJSR(None,1,X);\n{SUB}ROUTINE None\nNOP();\nEND\n"
    )
    for engine in (program.interpret(), program.compile()):
        engine.step()
        assert engine.tags["Y.Id"] == 8


def test_a_routine_in_python_gets_and_returns_bytes():
    program = parse_program(f"{HEAD}JSR(turn,1,List,Back);\nEND\n")
    assert isinstance(program, Program)

    @program.function
    def turn(_tags, data):
        return (data[::-1],)

    for engine in (program.interpret(), program.compile()):
        engine.step()
        assert [engine.tags[f"Back[{each}]"] for each in range(5)] == [5 << 8, 4 << 8, 3 << 8, 2 << 8, 1 << 8]


def test_for_without_a_step_counts_by_one():
    rungs = "FOR(Once,At,0,3);\nEND\nROUTINE Once\nADD(N,1,N);\nEND\n"
    program = parse_program(f"{HEAD}{rungs}")
    for engine in (program.interpret(), program.compile()):
        engine.step()
        assert (engine.tags.N, engine.tags.At) == (4, 4)
