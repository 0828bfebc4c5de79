"""Two programs: values that can differ, now or later, each with a run; equal ones are not named."""

from __future__ import annotations

from random import Random

import pytest
from amounts import amount
from proofs import program_text
from scanrack.ladder.files import parse_program
from scanrack.ladder.model.errors import LadderFault
from scanrack.ladder.prove.difference import Difference, compare
from scanrack.ladder.prove.system import shown

pytestmark = pytest.mark.extra("prove")

HEAD = ["PROGRAM p", "ALLOW repeated coils"]
HEAD += [f"TAG {name} : BOOL" for name in ("A", "B", "C", "X", "Y", "Z")]
HEAD += ["TAG N : DINT", "TAG T : TIMER", "TAG List : DINT[4]", "TAG F : REAL", "TAG G : REAL"]
OLD = ("XIC(A)XIO(B)OTE(X);", "XIC(X)TON(T,500,0);", "XIC(T.DN)OTE(Y);", "XIC(C)OTE(Z);", "XIC(C)ADD(N,1,N);")


def program(*rungs: str) -> object:
    return parse_program("\n".join([*HEAD, "ROUTINE Main", *rungs, "END", ""]))


def compared(*new: str, old: tuple[str, ...] = OLD) -> Difference:
    return compare(program(*old), program(*new))  # type: ignore[arg-type]


def test_a_program_is_equal_to_itself_and_to_one_that_says_the_same() -> None:
    assert compared(*OLD).changed == []
    same = compared("XIO(B)XIC(A)OTE(X);", OLD[1], OLD[2], OLD[3], "XIC(C)ADD(1,N,N);")
    assert (same.changed, same.removed, same.added) == ([], [], [])
    assert same.compared == 8  # X, Y, Z, N, and EN, TT, DN, ACC of T


def test_a_dropped_contact_changes_its_coil_now_and_what_follows_later() -> None:
    found = compared("XIC(A)OTE(X);", *OLD[1:])
    by_name = {each.name: each for each in found.changed}
    assert set(by_name) == {"X", "Y", "T.EN", "T.TT", "T.DN", "T.ACC"}
    assert by_name["X"].now
    assert by_name["X"].inputs == ("A", "B")
    assert by_name["X"].scans[-1].inputs == {("A", 0): True, ("B", 0): True}
    assert all(each.scans for each in found.changed)


def test_what_differs_only_later_says_so() -> None:
    old = ("XIC(Y)OTE(Z);", "XIC(A)XIO(B)OTE(Y);")
    found = compared(old[0], "XIC(A)OTE(Y);", old=old)
    assert [(each.name, each.now, len(each.scans)) for each in found.changed] == [
        ("Y", True, 1),
        ("Z", False, 2),
    ]


def test_what_one_program_alone_writes_is_named() -> None:
    found = compared(*OLD[:3], OLD[4], "XIC(C)OTE(List[1].3);")
    assert (found.removed, found.added) == (["Z"], ["LIST[1]"])


def test_a_difference_that_no_run_reaches_is_proved_away() -> None:
    """X is never on, so what depends on it alone does not count."""
    old = ("XIC(A)XIO(A)OTE(X);", "XIC(X)XIC(B)OTE(Y);")
    assert compared(old[0], "XIC(X)OTE(Y);", old=old).changed == []


def test_instructions_that_are_not_modeled_are_equal_where_their_operands_are() -> None:
    old = (*OLD, "XIC(A)SIN(F,G);")
    assert "G" not in [each.name for each in compared("XIC(A)OTE(X);", *old[1:], old=old).changed]
    assert [each.name for each in compared(*OLD, "XIC(B)SIN(F,G);", old=old).changed] == ["G"]
    assert [each.name for each in compared(*OLD, "XIC(A)SIN(N,G);", old=old).changed] == ["G"]


def mutated(text: str, rng: Random) -> str:
    """Negate or drop one contact."""
    lines = text.splitlines()
    rungs = [n for n, line in enumerate(lines) if line.startswith(("XIC(", "XIO(")) and line.count("XI") > 1]
    if not rungs:
        return text
    at = rng.choice(rungs)
    if rng.random() < 0.5:
        lines[at] = lines[at][lines[at].index(")") + 1 :]
    else:
        lines[at] = ("XIO" if lines[at].startswith("XIC") else "XIC") + lines[at][3:]
    return "\n".join(lines) + "\n"


def differ_at_random(old: object, new: object, rng: Random, scans: int) -> set[str]:
    """Run both with the same inputs; return tags that differ after some scan."""
    engines = [each.compile() for each in (old, new)]  # type: ignore[attr-defined]
    layout = engines[0].lowered.layout
    found: set[str] = set()
    for number in range(scans):
        if number % 50 == 0:
            engines = [each.compile() for each in (old, new)]  # type: ignore[attr-defined]
        for name in ("X0", "X1", "X2", "X3"):
            value = rng.random() < 0.5
            for each in engines:
                each.memory.write(layout.leaf(name), 0, value)
        ms = rng.choice((1, 10, 60))
        try:
            for each in engines:
                each.step(ms)
        except LadderFault:
            engines = [each.compile() for each in (old, new)]  # type: ignore[attr-defined]
            continue
        for path, leaf in layout.leaves.items():
            if not path.startswith(("~", "S:")) and ".~" not in path:
                one, other = ([each.memory.read(leaf, at) for at in range(leaf.size)] for each in engines)
                found.update(shown(f"{path}[{at}]") for at in range(leaf.size) if one[at] != other[at])
    return found


def told_apart(seed: int, scans: int) -> bool:
    """Compare a random program and a mutant; return whether random scans tell them apart."""
    rng = Random(seed)
    text = program_text(rng)
    changed = mutated(text, rng)
    named = {each.name for each in compare(parse_program(text), parse_program(changed)).changed}
    seen = differ_at_random(parse_program(text), parse_program(changed), rng, scans)
    assert seen <= named, (seed, seen - named)
    return bool(seen)


SINE = """INSTRUCTION Sine
INPUT X : REAL REQUIRED
OUTPUT Y : REAL REQUIRED
ROUTINE Logic
SIN(X,Y);
END
END INSTRUCTION
TAG S : Sine
TAG M : DINT[3] := [%s, 1, 2]
TAG K : CONTROL := {"LEN": 3}
TAG R : REAL := %s"""
AVERAGED = ("XIC(A)AVE(M,0,G,K,?,?);", "GRT(G,2)OTE(X);")


@pytest.mark.parametrize(
    ("rungs", "old", "new"),
    [
        (("XIC(A)MOV(2,F);", "@", "SIN(F,G);", "CLR(F);", "GRT(G,0)OTE(X);"), "ADD(F,1,F);", "ADD(F,2,F);"),
        (("XIC(A)MOV(2,F);", "@", "GRT(G,0)OTE(X);"), "Sine(S,F,G);", "ADD(F,1,F);\nSine(S,F,G);\nCLR(F);"),
        (("XIC(A)MOV(@,M[0]);", *AVERAGED, "CLR(M[0]);"), "5", "600"),
        (("XIC(A)SIN(R,G);", "GRT(G,0)OTE(X);"), "1", "-1"),
        (AVERAGED, "1", "900"),
    ],
)
def test_instructions_that_are_not_modeled_differ_with_what_they_find(rungs, old, new) -> None:
    """The value that differs is overwritten before the scan ends, or is an initial value of any element."""

    def made(text: str) -> object:
        initial = text if text[-1].isdigit() else "0"
        lines = [*HEAD, SINE % (initial, initial), "ROUTINE Main", *rungs, "END", ""]
        return parse_program("\n".join(lines).replace("@", text))

    names = {each.name for each in compare(made(old), made(new)).changed}  # type: ignore[arg-type]
    assert names >= {"X", "G"}
    assert compare(made(old), made(old)).changed == []  # type: ignore[arg-type]


@pytest.mark.slow
def test_whatever_random_scans_tell_apart_is_named() -> None:
    assert sum(told_apart(seed, 100) for seed in range(amount(5))) >= 2
