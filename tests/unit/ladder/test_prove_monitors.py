"""Claims of a rack file, of comments and of routines NEVER: the same bits in both back ends."""

from __future__ import annotations

from pathlib import Path

import pytest
from scanrack.io_images.amci3601 import CommandMsw
from scanrack.io_images.amci3601.bits import StatusLsw
from scanrack.ladder import LadderError, read_program
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove.claims import Claim, ClaimKind, claims_in
from scanrack.ladder.prove.monitors import monitored

LINE = """\
PROGRAM line
TAG A : BOOL
TAG B : BOOL
TAG Fwd : BOOL
TAG Rev : BOOL
TAG N : DINT := 3
TAG T : TIMER
SLOT axis : 1
ROUTINE Main
// forward
// prove: never Fwd AND Rev
XIC(A)OTE(Fwd);
// prove: always N >= old(N)
XIC(B)OTE(Rev)ADD(N,1,N);
END
ROUTINE Never
// late
XIC(Fwd)TON(T,20,0)XIC(T.DN)NOP();
END
"""


def never(text: str, *assume: str) -> Claim:
    return Claim("asked", ClaimKind.NEVER, text, assume)


def broken(claims: list[Claim], *, compiled: bool, text: str = LINE) -> list[str]:
    """Names of the broken claims after each scan of 10 ms; A in scans 2 to 4, B from scan 3 on."""
    found = monitored(parse_program(text), claims, [1])
    engine = found.program.compile() if compiled else found.program.interpret()
    said = []
    for scan in range(1, 6):
        engine.tags["A"], engine.tags["B"] = scan in (2, 3, 4), scan >= 3
        engine.step(10)
        said.append(" ".join(each.claim.name[:5] for each in found.properties if not each.holds(engine)))
    return said


@pytest.mark.parametrize("compiled", [True, False])
def test_claims_are_broken_in_the_scan_that_breaks_them(compiled: bool) -> None:
    # both coils in scans 3 and 4; the timer begins in scan 2 and is done 20 ms later
    assert broken([], compiled=compiled) == ["", "", "never", "late never", ""]


@pytest.mark.parametrize("compiled", [True, False])
def test_old_is_the_value_before_the_scan(compiled: bool) -> None:
    assert broken([never("A AND NOT old(A)")], compiled=compiled)[1] == "asked"
    assert broken([never("old(A) AND NOT A")], compiled=compiled)[4] == "asked"
    # N begins with 3, so that no scan sees another value before the first one
    assert "asked" not in "".join(broken([never("old(N) < 3")], compiled=compiled))
    assert broken([never("old(N) <> N AND NOT old(T.TT)")], compiled=compiled)[2:] == [
        "never",
        "late never",
        "asked",
    ]


def test_a_claim_names_bits_of_modules() -> None:
    found = monitored(
        parse_program(LINE), [never("axis.command.ABSOLUTE_MOVE AND slot1.status.IN_ESTOP")], [1]
    )
    asked = next(each for each in found.properties if each.claim.name == "asked")
    engine = found.program.compile()
    layout = engine.lowered.layout
    engine.memory.write(layout.leaf("Local:1:O.Data"), 0, CommandMsw.ABSOLUTE_MOVE.value)
    engine.step(10)
    assert asked.holds(engine)
    engine.memory.write(layout.leaf("Local:1:I.Data"), 1, StatusLsw.IN_ESTOP.value)
    engine.step(10)
    assert not asked.holds(engine)


def test_claims_have_the_place_of_their_rung() -> None:
    found = claims_in(parse_program(LINE, file="line.rung").build())
    assert [(each.sentence, each.site.where) for each in found] == [
        ("never Fwd AND Rev", "line.rung:12: routine Main, rung 0"),
        ("always N >= old(N)", "line.rung:14: routine Main, rung 1"),
    ]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("Fdw AND B", "property 'asked': Fdw AND B: no tag Fdw (did you mean Fwd?); declare it"),
        ("A; B := 1", "property 'asked': A; B := 1: expected an operator or ), found ;"),
        (
            "N",
            "property 'asked': N: N is a DINT, a bit or a condition is needed; compare it, as in count <> 0",
        ),
        ("old(N > 3", "property 'asked': old(N > 3: old( has no closing parenthesis"),
        ("old(T)", "property 'asked': old(T): old(T): must be one value at a fixed place"),
    ],
)
def test_a_condition_that_can_not_be_used_is_refused_with_its_property(text: str, says: str) -> None:
    with pytest.raises(LadderError) as caught:
        monitored(parse_program(LINE), [never(text)])
    assert str(caught.value) == says


@pytest.mark.parametrize(
    ("comment", "says"),
    [
        ("prove: nevr Fwd", "prove: nevr: did you mean never"),
        ("prove: always", "prove: always: a condition is missing"),
    ],
)
def test_a_comment_that_looks_like_a_claim_is_not_passed_over(comment: str, says: str) -> None:
    with pytest.raises(LadderError, match=says):
        monitored(parse_program(LINE.replace("prove: never Fwd AND Rev", comment)))


def test_a_routine_never_that_is_called_is_refused() -> None:
    called = LINE.replace("XIC(A)OTE(Fwd);", "XIC(A)OTE(Fwd)JSR(Never,0);")
    with pytest.raises(LadderError, match="routine Never is called"):
        monitored(parse_program(called))


def test_a_monitor_has_power_behind_an_open_zone_and_a_left_out_rung() -> None:
    # MCR() without its partner leaves the zone open; the jump leaves the first monitor out from scan 3 on
    text = LINE.replace("XIC(B)OTE(Rev)ADD(N,1,N);", "XIC(B)OTE(Rev);\nXIC(Rev)MCR();").replace(
        "// late\nXIC(Fwd)TON(T,20,0)XIC(T.DN)NOP();",
        "XIC(B)JMP(out);\n// first\nXIC(Fwd)NOP();\nLBL(out)NOP();\n// open\nXIC(Fwd)NOP();",
    )
    for compiled in (True, False):
        said = broken([], compiled=compiled, text=text)
        assert ["open" in each for each in said] == [False, True, True, True, False]
        assert ["first" in each for each in said] == [False, True, False, False, False]


def test_bits_that_structured_text_sets_in_a_monitor_are_claims(tmp_path: Path) -> None:
    text = LINE.split("ROUTINE Never")[0].replace("TAG T : TIMER", "TAG Both : BOOL\nTAG More : DINT")
    text += "ROUTINE Never ST\nMore := N + 1;\nBoth := Fwd AND Rev;\nEND\n"
    file = tmp_path / "line.rung"
    file.write_text(text, encoding="utf-8")
    found = monitored(read_program(file))
    assert next((each.claim.name, each.claim.text) for each in found.properties) == ("Never line 2", "Both")


def test_the_program_stays_as_it_is() -> None:
    program = parse_program(LINE)
    before = program.source()
    monitored(program, [never("A")])
    assert program.source() == before
    assert "Prove__1" not in program.tags


def test_a_monitor_that_acts_on_the_program_is_refused() -> None:
    text = LINE.replace("XIC(Fwd)TON(T,20,0)", "XIC(B)OTU(Fwd)TON(T,20,0)")
    with pytest.raises(LadderError, match="a routine NEVER writes FWD, which the program uses"):
        parse_program(text).prove(never="Fwd AND Rev")


def test_a_program_answers_in_a_test() -> None:
    program = parse_program(LINE)
    assert program.prove(always="N <> old(N) OR NOT B")
    refuted = program.prove(never="Fwd AND Rev")
    assert not refuted
    assert repr(refuted) == "refuted: never Fwd AND Rev\n  scan 1: A = 1, B = 1"
    assert program.prove(never="Fwd AND Rev", assume=["NOT (A AND B)"])
    reached = program.prove(reachable="T.DN")
    assert (bool(reached), reached.word, reached.verdict.k) == (True, "reached", 2)
    with pytest.raises(LadderError, match="give exactly one of never, always, reachable, not 2 of them"):
        program.prove(never="A", always="B")
