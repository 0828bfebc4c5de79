"""Stubs of instructions: done after a time, false, true, a Python function; both back ends."""

import pytest
from ladder_bench import both
from scanrack.jobs import ProgramError, load_program
from scanrack.jobs.load.program import load_stubs
from scanrack.ladder import BOOL, DINT, OTE, XIC, Controller, LadderError, Program
from scanrack.ladder.files import parse_program, program_text
from scanrack.ladder.model.stubs import Power, Stubs, parse_stub

MOVE = "TYPE Move (EN : BOOL, DN : BOOL, ER : BOOL, IP : BOOL, PC : BOOL, ERR : INT)\n"
TAGS = f"{MOVE}TAG Go : BOOL\nTAG Out : BOOL\nTAG M : Move\nTAG N : DINT\nTAG T : TIMER\n"


def run(engines, scans, *names):
    """Return tags after each scan, 10 ms apart; the back ends must agree."""
    seen = []
    for go in scans:
        for engine in engines:
            engine.tags.Go = go
            engine.step(10)
        first, second = (engine.memory.snapshot() for engine in engines)
        assert first == second
        seen.append(tuple(int(engines[0].tags[name]) for name in names))
    return seen


def test_false_ends_the_rung_and_true_lets_it_pass():
    engines = both(f"{TAGS}STUB ALMD : false\n", "XIC(Go)[ALMD(no,such,tags),NOP()]OTE(Out);")
    assert run(engines, [1, 0], "Out") == [(1,), (0,)]
    engines = both(f"{TAGS}STUB ALMD : false\n", "XIC(Go)ALMD(T,0,0,0,0,?,?)OTE(Out);")
    assert run(engines, [1], "Out") == [(0,)]
    engines = both(f"{TAGS}STUB XRP : true\n", "XIC(Go)XRP(Axis,Units per sec,,1.5,% of Maximum)OTE(Out);")
    assert run(engines, [1, 0], "Out") == [(1,), (0,)]


def test_done_after_a_time():
    """EN with the rung; DN 20 ms later, and IP until then; EN ends with the rung."""
    engines = both(f"{TAGS}STUB MAM : done after 20 ms\n", "XIC(Go)MAM(Axis,M,0,5,Units per sec)OTE(Out);")
    seen = run(engines, [1, 1, 1, 1, 0, 1], *(f"M.{name}" for name in ("EN", "IP", "DN", "PC")), "Out")
    assert seen == [(1, 1, 0, 0, 1)] * 2 + [(1, 0, 1, 1, 1)] * 2 + [(0, 0, 1, 1, 0), (1, 1, 0, 0, 1)]


def test_an_error_after_a_time_sets_er_and_err():
    engines = both(f"{TAGS}STUB MAM : error 16#0010 after 10 ms\n", "XIC(Go)MAM(Axis,M);")
    assert run(engines, [1, 1], "M.ER", "M.DN", "M.ERR") == [(0, 0, 0), (1, 0, 16)]


def test_done_needs_an_operand_with_en_and_dn():
    program = parse_program(
        f"PROGRAM p\n{TAGS}STUB XRP : done after 1 ms\nROUTINE Main\nXIC(Go)XRP(N);\nEND\n"
    )
    with pytest.raises(LadderError, match=r"no operand has EN and DN.*write false or true as its stub"):
        program.build()


def made(function):
    """Return both engines of a program whose XRP is a Python function."""
    stubs = Stubs({"XRP": load_stub(function)})
    text = f"PROGRAM p\n{TAGS}ROUTINE Main\nXIC(Go)XRP(N,T,2.5,'abc',Units per sec)OTE(Out);\nEND\n"
    program = parse_program(text, stubs=stubs)
    return [program.compile(), program.interpret()]


def load_stub(function):
    program = Program("holder")
    program.stub("XRP", function)
    return program.stubs["XRP"]


def test_a_python_function_reads_and_writes_its_operands():
    def xrp(tags, rung, count, timer, factor, said, unit):
        assert (factor, said, unit) == (2.5, "abc", "Units per sec")
        count.value += 1
        timer["PRE"] = int(count.value * factor)
        tags["T.ACC"] = 7
        return rung and count.value > 1

    seen = run(made(xrp), [1, 1, 0], "N", "T.PRE", "T.ACC", "Out")
    assert seen == [(1, 2, 7, 0), (2, 5, 7, 1), (3, 7, 7, 0)]


def test_a_function_that_returns_nothing_leaves_the_rung():
    assert run(made(lambda tags, rung, *operands: None), [1, 0], "Out") == [(1,), (0,)]


def test_what_a_function_may_not_do_names_the_operand():
    for engine in made(lambda tags, rung, count, timer, *rest: timer.value):
        with pytest.raises(ValueError, match="T is a structure or an array; name a member"):
            engine.step()


def test_stubs_reach_the_programs_of_a_controller():
    plant = Controller("plant")
    plant.stub("XRP", "false")
    main = plant.program("Main")
    go, _ = main.declare("Go Out", BOOL)

    @main.routine
    def Step(rung):  # noqa: N802
        rung("XIC(Go)XRP(Go)OTE(Out);")
        rung(XIC(go), OTE(main.declare("Other", BOOL)))

    plant.tags[r"\Main.Go"] = True
    plant.step()
    assert (plant.tags[r"\Main.Out"], plant.tags[r"\Main.Other"]) == (False, True)
    again = parse_program(program_text(plant))
    assert again.stubs == {"XRP": Power(False)}
    assert program_text(plant).count("STUB") == 1


def test_stubs_in_use_are_counted():
    stubs = "STUB ALMD : false\nSTUB XRP : true\nSTUB MSG : done after 1 ms\nSTUB B : done after 2 ms\n"
    tags = f"{stubs}TAG A : MESSAGE\nTAG B : MESSAGE\n"
    program = parse_program(f"PROGRAM p\n{tags}ROUTINE Main\nXRP()XRP(1)MSG(A);\nMSG(B);\nEND\n")
    assert program.stubs_in_use == (
        "XRP = true (twice)",
        "MSG = done after 1 ms (once)",
        "B = done after 2 ms (once)",
    )


@pytest.mark.parametrize("name", ["JMP", "jsr", "MCR"])
def test_what_says_what_runs_next_has_no_stub(name):
    message = f"{name.upper()} decides what runs next, so no stub can replace it"
    with pytest.raises(LadderError, match=message):
        Program("p").stub(name, "false")


@pytest.mark.parametrize("text", ["later", "falsch", "done", "plant.py:xrp"])
def test_what_is_no_stub(text):
    with pytest.raises(LadderError, match="is not a stub; write 'done after 20 ms'"):
        parse_stub(text)


def test_a_rung_file_names_no_python(tmp_path):
    """It is data: reading it must run nothing."""
    path = tmp_path / "line.rung"
    path.write_text("PROGRAM p\nSTUB XRP : plant.py:xrp\nROUTINE Main\nEND\n", encoding="utf-8")
    with pytest.raises(ProgramError, match=r"line.rung:2: 'plant.py:xrp' is not a stub"):
        load_program(str(path))


def test_a_python_program_takes_stubs(tmp_path):
    (tmp_path / "line.py").write_text(
        "from scanrack.ladder import *\nprogram = Program('p')\nout = program.declare('Out', BOOL)\n"
        "@program.routine\ndef Main(rung):\n    rung('XRP(1)OTE(Out);')\nprogram.stub('XRP', 'true')\n",
        encoding="utf-8",
    )
    with pytest.raises(ProgramError, match="XRP is unknown"):
        load_program("line.py", tmp_path)


def test_functions_come_from_files(tmp_path):
    (tmp_path / "plant.py").write_text("def xrp(tags, rung, count):\n    count.value = 5\n", encoding="utf-8")
    stubs = load_stubs({"XRP": "plant.py:xrp", "ALMD": "false"}, tmp_path)
    assert {name: str(stub) for name, stub in stubs.by_name.items()} == {
        "XRP": "plant.py:xrp",
        "ALMD": "false",
    }
    program = Program("p")
    program.take_stubs(stubs)
    program.declare("N", DINT)

    @program.routine
    def Main(rung):  # noqa: N802
        rung("XRP(N);")

    program.step()
    assert program.tags.N == 5
    with pytest.raises(LadderError, match="the stub of XRP is in Python; write it in a rack file"):
        program_text(program)
    with pytest.raises(ProgramError, match="no function yrp among xrp; did you mean xrp"):
        load_stubs({"XRP": "plant.py:yrp"}, tmp_path)
