"""MSG in structured text: a call begins a message, which ends after a scan of its own accord."""

import pytest
from scanrack.ladder.files import parse_program

ONCE = """PROGRAM p
TAG M : MESSAGE
TAG Ms : MESSAGE[3]
TAG Go : BOOL
TAG Began : DINT
STUB MSG : done after 30 ms
STUB Ms : error 16#00CB after 10 ms
ROUTINE Main ST
IF Go AND NOT M.EN THEN MSG(M); MSG(Ms[1]); Began := Began + 1; END_IF;
END
"""

IN_ADD_ON = """PROGRAM p
INSTRUCTION Send
INOUT Msg : MESSAGE
INPUT Go : BOOL REQUIRED
ROUTINE Logic ST
IF Go THEN MSG(Msg); END_IF;
END
END INSTRUCTION
TAG M : MESSAGE
TAG Ms : MESSAGE[3]
TAG Go : BOOL
TAG One : Send
TAG Two : Send
STUB MSG : done after 30 ms
ROUTINE Main
Send(One,M,Go)Send(Two,Ms[1],Go);
END
"""


def engines(text):
    program = parse_program(text)
    return [program.compile(), program.interpret()]


def bits(tags, name):
    return "".join(str(int(tags[f"{name}.{bit}"])) for bit in ("EN", "ST", "DN", "ER"))


@pytest.mark.parametrize("which", [0, 1])
def test_a_message_ends_without_another_call(which):
    engine = engines(ONCE)[which]
    engine.tags.Go = True
    engine.step(10)  # at 0 ms
    engine.tags.Go = False
    seen = [(bits(engine.tags, "M"), bits(engine.tags, "Ms[1]"))]
    for _ in range(3):
        engine.step(10)
        seen.append((bits(engine.tags, "M"), bits(engine.tags, "Ms[1]")))
    assert seen == [("1100", "1100"), ("1100", "0001"), ("1100", "0001"), ("0010", "0001")]
    assert (engine.tags["M.ERR"], engine.tags["Ms[1].ERR"], engine.tags.Began) == (0, 0xCB, 1)
    assert bits(engine.tags, "Ms[0]") == "0000"


@pytest.mark.parametrize("which", [0, 1])
def test_to_stops_a_message_and_a_call_begins_the_next_one(which):
    engine = engines(ONCE)[which]
    engine.tags.Go = True
    engine.step(10)
    engine.tags["M.TO"] = True
    engine.step(10)
    assert (bits(engine.tags, "M"), engine.tags["M.ERR"]) == ("0001", 1)
    engine.step(10)
    assert (bits(engine.tags, "M"), engine.tags.Began, engine.tags["M.ERR"]) == ("1100", 2, 0)


@pytest.mark.parametrize("which", [0, 1])
def test_a_message_that_an_add_on_instruction_gets(which):
    engine = engines(IN_ADD_ON)[which]
    engine.tags.Go = True
    engine.step(10)
    engine.tags.Go = False
    assert (bits(engine.tags, "M"), bits(engine.tags, "Ms[1]")) == ("1100", "1100")
    for _ in range(3):
        engine.step(10)
    assert (bits(engine.tags, "M"), bits(engine.tags, "Ms[1]"), bits(engine.tags, "Ms[2]")) == (
        "0010",
        "0010",
        "0000",
    )
