"""MSG and its stub; the bits as in RM003N p. 156 and the help page "MESSAGE structure"."""

import pytest
from ladder_bench import both
from scanrack.ladder import BuildError, LadderError, Program
from scanrack.ladder.files import parse_program, program_text

TAGS = "TAG Go : BOOL\nTAG M : MESSAGE\nTAG Other : MESSAGE\n"
BITS = ("EN", "ST", "DN", "ER")


def run(stub, *rungs, scans):
    """Return the bits of M after each scan, 10 ms apart, of both back ends, which must agree."""
    engines = both(TAGS + stub, *rungs)
    seen = []
    for values in scans:
        for engine in engines:
            for name, value in values.items():
                engine.tags[name] = value
            engine.step(10)
        compiled, interpreted = (engine.memory.snapshot() for engine in engines)
        assert compiled == interpreted
        seen.append(tuple(int(engines[0].tags[f"M.{name}"]) for name in BITS))
    return seen, engines[0]


ON, OFF = {"Go": True}, {"Go": False}


def test_a_message_is_done_after_its_time():
    seen, engine = run("STUB MSG : done after 20 ms", "XIC(Go)MSG(M);", scans=[ON, ON, ON, ON, OFF, ON])
    assert seen == [(1, 1, 0, 0), (1, 1, 0, 0), (1, 0, 1, 0), (1, 0, 1, 0), (0, 0, 1, 0), (1, 1, 0, 0)]
    assert engine.tags["M.ERR"] == 0


def test_a_false_rung_does_not_stop_a_message():
    seen, _ = run("STUB MSG : done after 15 ms", "XIC(Go)MSG(M);", scans=[ON, OFF, OFF])
    assert seen == [(1, 1, 0, 0), (1, 1, 0, 0), (0, 0, 1, 0)]


def test_a_message_fails_with_the_code_of_its_stub():
    stubs = "STUB MSG : done after 0 ms\nSTUB M : error 16#00CB after 0 ms"
    seen, engine = run(stubs, "XIC(Go)MSG(M);", "XIC(Go)MSG(Other);", scans=[ON, ON])
    assert seen == [(1, 1, 0, 0), (1, 0, 0, 1)]
    assert engine.tags["M.ERR"] == 0xCB
    assert engine.tags["Other.DN"] is True


def test_the_program_stops_a_message_by_its_to_bit():
    seen, engine = run("STUB MSG : done after 1000 ms", "XIC(Go)MSG(M);", scans=[ON, {"M.TO": True}])
    assert seen[-1] == (1, 0, 0, 1)
    assert engine.tags["M.ERR"] == 1


def test_the_rung_of_the_manual_repeats_a_message():
    """XIO of EN in front of it, RM003N p. 156: start, done, and the next one."""
    seen, _ = run("STUB MSG : done after 10 ms", "XIO(M.EN)MSG(M);", scans=[OFF] * 4)
    assert seen == [(1, 1, 0, 0), (0, 0, 1, 0), (1, 1, 0, 0), (0, 0, 1, 0)]


def test_the_bits_lie_in_flags():
    _, engine = run("STUB MSG : done after 1 ms", "XIC(Go)MSG(M);", scans=[ON])
    assert engine.tags["M.FLAGS"] == 1 << 7 | 1 << 6  # EN and ST


def test_a_message_without_a_stub_is_refused():
    with pytest.raises(BuildError, match="no stub for the message M"):
        both(TAGS, "MSG(M);")


@pytest.mark.parametrize(
    "text",
    ["", "done", "done after 20", "error after 20 ms", "error 0 after 20 ms", "error 70000 after 1 ms"],
)
def test_a_stub_that_is_none_is_refused(text):
    with pytest.raises(LadderError, match="is not a stub; write 'done after 20 ms'"):
        Program("line").stub("MSG", text)
    with pytest.raises(LadderError):
        parse_program(f"PROGRAM line\nSTUB MSG : {text}\nROUTINE Main\nNOP();\nEND\n", file="line.rung")


@pytest.mark.parametrize("text", ["done after 20 ms", "error 16#00CB after 500 µs", "done after 100 ms"])
def test_stubs_are_written_and_read(text):
    program = parse_program(f"PROGRAM line\nTAG M : MESSAGE\nSTUB M : {text}\nROUTINE Main\nMSG(M);\nEND\n")
    again = parse_program(program_text(program))
    assert again.stubs == program.stubs
    assert str(again.stubs["M"]) == text


def test_stubs_of_a_controller_name_the_tags_of_its_programs():
    head = "CONTROLLER plant\nSTUB MSG : done after 1 ms\nSTUB \\Main.M : error 5 after 2 ms\n"
    text = f"{head}PROGRAM Main\nTAG M : MESSAGE\nROUTINE Main\nMSG(M);\nEND\nEND PROGRAM\n"
    controller = parse_program(text)
    controller.step(10)
    controller.step(10)
    assert controller.tags["\\Main.M.ERR"] == 5
    assert parse_program(program_text(controller)).stubs == controller.stubs
