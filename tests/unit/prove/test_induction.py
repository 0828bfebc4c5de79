"""Verdicts: on systems made by hand, and on programs, whose refutations run on the compiled program."""

from __future__ import annotations

from importlib.metadata import version

import pytest
from scanrack.ladder import LadderError
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove import ProgramSystem, ScanBounds
from scanrack.ladder.prove.algebra.meaning import INT
from scanrack.ladder.prove.algebra.numbers import add, eq, lt
from scanrack.ladder.prove.algebra.terms import FALSE, T, and_, const, forget, ite, not_, or_, var
from scanrack.ladder.prove.claims import Claim, ClaimKind
from scanrack.ladder.prove.induction import Limits, Verdict, VerdictKind, prove
from scanrack.ladder.prove.monitors import monitored
from scanrack.ladder.prove.system import RUN_ONLY, System

pytestmark = pytest.mark.extra("prove")


def counter(most: int) -> tuple[System, T]:
    """Return a number that counts to `most` and stays, and its variable."""
    forget()
    n, go = var("n", INT, 0, 127), var("go")
    up = ite(and_(go, lt(n, const(most))), add(n, const(1)), n)
    return System(next={"n": up}, initial={"n": 0}), n


def test_a_bound_that_is_inductive_is_proved() -> None:
    system, _ = counter(5)
    verdict = prove(system, lt(const(5), system.next["n"]))
    assert (verdict.kind, verdict.k) == (VerdictKind.PROVED, 1)
    assert verdict


def test_a_number_that_is_reached_is_refuted_with_the_shortest_run() -> None:
    system, _ = counter(5)
    verdict = prove(system, eq(system.next["n"], const(3)))
    assert (verdict.kind, verdict.k) == (VerdictKind.REFUTED, 3)
    assert not verdict


def test_a_run_beyond_the_limit_of_scans_is_unknown() -> None:
    system, _ = counter(100)
    verdict = prove(system, eq(system.next["n"], const(50)), Limits(scans=8, k=2))
    assert (verdict.kind, verdict.blame) == (VerdictKind.UNKNOWN, ("the limit of 8 scans",))


def test_the_fuse_is_named_with_the_version_of_the_solver() -> None:
    system, _ = counter(100)
    a, b = (var(name, INT, 2, 2**20) for name in "ab")
    from scanrack.ladder.prove.algebra.numbers import mul

    hard = and_(eq(mul(a, b), const(1_048_573 * 1_048_571)), lt(a, const(1_048_571)))
    verdict = prove(system, hard, Limits(fuse=0))
    said = f"the solver's fuse (bitwuzla {version('bitwuzla')}), in scan 1"
    assert (verdict.kind, verdict.blame) == (VerdictKind.UNKNOWN, (said,))


def test_the_limit_of_work_is_named() -> None:
    """Work is what the relation asks: the same with every version of the solver."""
    system, _ = counter(100)
    bad = eq(system.next["n"], const(50))
    enough = prove(system, bad, Limits(scans=8, k=2)).work
    verdict = prove(system, bad, Limits(scans=8, k=2, work=enough // 2))
    assert (verdict.kind, len(verdict.blame)) == (VerdictKind.UNKNOWN, 1)
    assert verdict.blame[0].startswith("the limit of work, in scan ")


def test_invariants_prove_what_induction_alone_does_not() -> None:
    """Two counters in step: that they never differ needs no help; that one is never above 5 does."""
    forget()
    a, b, go = var("a", INT, 0, 127), var("b", INT, 0, 127), var("go")
    moves = and_(go, lt(a, const(5)))
    after = {"a": ite(moves, add(a, const(1)), a), "b": ite(moves, add(b, const(1)), b)}
    after["b"] = ite(lt(b, const(6)), after["b"], const(7))
    system = System(next=after, initial={"a": 0, "b": 0})
    bad = eq(after["b"], const(7))
    assert prove(system, bad, Limits(scans=4, k=2, helped=False)).kind is VerdictKind.UNKNOWN
    helped = prove(System(next=after, initial={"a": 0, "b": 5}), lt(const(9), after["b"]), Limits(k=2))
    assert helped.kind is VerdictKind.PROVED


def test_assumptions_that_no_run_keeps_prove_nothing() -> None:
    system, n = counter(5)
    system.contract = lt(n, const(0)) if lt(n, const(0)) is not FALSE else and_(var("x"), eq(n, const(9)))
    verdict = prove(system, eq(system.next["n"], const(90)))
    assert (verdict.kind, verdict.blame) == (
        VerdictKind.UNKNOWN,
        ("no run of 1 scans keeps the assumptions",),
    )


def test_where_the_relation_may_not_follow_the_program_nothing_is_proved() -> None:
    system, n = counter(5)
    bad = lt(const(5), system.next["n"])
    system.deep = eq(n, const(2))
    assert prove(system, bad).kind is VerdictKind.UNKNOWN
    system.deep, system.follows = eq(n, const(7)), None
    assert prove(system, bad).kind is VerdictKind.PROVED


# --- programs


def asked(text: str, *claims: str, bounds: ScanBounds = ScanBounds(), **options: object) -> list[Verdict]:  # noqa: B008
    """Return the verdicts on conditions that are never to hold, and on the routine NEVER."""
    made = [Claim(each, ClaimKind.NEVER, each) for each in claims]
    checked = monitored(parse_program(text), made)
    problem = ProgramSystem(checked.program, bounds, assume=checked.assume, **options)  # type: ignore[arg-type]
    limits = Limits(scans=12, k=3)
    return [prove(problem, each.bit, limits) for each in checked.properties]


MOTOR = """PROGRAM motor
TAG Start : BOOL
TAG Stop : BOOL
TAG Fwd : BOOL
TAG Rev : BOOL
TAG Speed : DINT
ROUTINE Main
[XIC(Start),XIC(Fwd)]XIO(Stop)XIO(Rev)OTE(Fwd);
XIO(Start)XIO(Stop)XIO(Fwd)GRT(Speed,10)OTE(Rev);
END
"""


def test_an_interlock_is_proved_and_its_absence_refuted_with_inputs() -> None:
    proved, refuted = asked(MOTOR, "Fwd AND Rev", "Fwd AND NOT Start")
    assert (proved.kind, refuted.kind) == (VerdictKind.PROVED, VerdictKind.REFUTED)
    assert [each.inputs for each in refuted.scans] == [{("START", 0): True}, {("START", 0): False}]


def test_a_number_that_nothing_writes_is_held_unless_it_is_free() -> None:
    (held,), (free,) = asked(MOTOR, "Rev"), asked(MOTOR, "Rev", free=["Speed"])
    assert (held.kind, [(each.key[0], each.value) for each in held.held]) == (
        VerdictKind.PROVED,
        [("SPEED", 0)],
    )
    assert (free.kind, free.held) == (VerdictKind.REFUTED, ())
    assert free.scans[0].inputs["SPEED", 0] > 10


def test_a_tag_that_is_written_outside_too_may_change_between_scans() -> None:
    text = (
        "PROGRAM p\nTAG Mode : DINT\nTAG Lamp : BOOL\nROUTINE Main\n"
        "MOV(1,Mode);\nEQU(Mode,7)OTE(Lamp);\nEND\n"
    )
    before = text.replace("MOV(1,Mode);\nEQU(Mode,7)OTE(Lamp);", "EQU(Mode,7)OTE(Lamp);\nMOV(1,Mode);")
    assert asked(text, "Lamp", written_outside=["Mode"])[0].kind is VerdictKind.PROVED
    assert asked(before, "Lamp")[0].kind is VerdictKind.PROVED
    (refuted,) = asked(before, "Lamp", written_outside=["Mode"])
    assert (refuted.kind, refuted.k) == (VerdictKind.REFUTED, 2)


def test_a_name_that_no_tag_has_is_refused() -> None:
    with pytest.raises(LadderError, match="free: no tag 'Sped'"):
        asked(MOTOR, "Rev", free=["Sped"])


TIMED = """PROGRAM timed
TAG Go : BOOL
TAG T : TIMER
TAG Out : BOOL
ROUTINE Main
XIC(Go)TON(T,5000,0);
XIC(T.DN)OTE(Out);
END
"""


def test_a_timer_is_done_after_its_time_and_never_before() -> None:
    early, done = asked(TIMED, "Out AND T.ACC < 5000", "Out")
    assert (early.kind, done.kind, done.k) == (VerdictKind.PROVED, VerdictKind.REFUTED, 6)
    assert sum(each.ms for each in done.scans) >= 5000


def test_with_short_scans_the_run_is_done_in_them() -> None:
    (done,) = asked(TIMED, "Out", bounds=ScanBounds(10, 10))
    assert done.kind is VerdictKind.REFUTED
    assert {each.ms for each in done.scans[1:]} == {10}
    assert sum(each.ms for each in done.scans) >= 5000


def test_an_assumption_of_each_scan_makes_the_proof() -> None:
    comment = "// prove: assume NOT Start\n"
    text = MOTOR.replace("[XIC(Start)", comment + "[XIC(Start)")
    (proved,) = asked(text, "Fwd")
    assert (proved.kind, [each.key[0] for each in proved.held]) == (VerdictKind.PROVED, ["SPEED"])


def test_what_faults_ends_the_run() -> None:
    text = (
        "PROGRAM p\nTAG I : DINT\nTAG A : DINT[4]\nTAG Bad : BOOL\nROUTINE Main\n"
        "ADD(I,1,I);\nMOV(1,A[I]);\nGRT(I,5)OTE(Bad);\nEND\n"
    )
    (verdict,) = asked(text, "Bad")
    assert verdict.kind is not VerdictKind.REFUTED


def test_two_proofs_say_the_same() -> None:
    assert asked(TIMED, "Out", "T.TT") == asked(TIMED, "Out", "T.TT")


def test_or_of_bad_states_is_what_it_says() -> None:
    system, _ = counter(5)
    n = system.next["n"]
    assert prove(system, or_(lt(const(5), n), not_(lt(n, const(100))))).kind is VerdictKind.PROVED


def test_a_timer_that_never_runs_ahead_of_another_is_an_invariant() -> None:
    """A valve goes off 2 s after its feedback is lost, at the latest a scan of 1 s later: never 3 s."""
    made = parse_program(
        """
PROGRAM valve
TAG Request : BOOL
TAG Valve : BOOL
TAG Open : BOOL
TAG Watch : TIMER
TAG Alarm : BOOL
TAG Late : TIMER
ROUTINE Main
XIC(Request)XIO(Alarm)OTE(Valve);
XIC(Valve)XIO(Open)TON(Watch,2000,0);
XIC(Watch.DN)OTL(Alarm);
XIC(Valve)XIO(Open)TON(Late,3000,0);
END
"""
    )
    verdict = prove(ProgramSystem(made, ScanBounds(1, 1000)), ("LATE.DN", 0))
    assert verdict.kind is VerdictKind.PROVED
    assert "LATE.ACC <= WATCH.ACC" in verdict.invariants


@pytest.mark.slow
def test_a_timer_counts_whole_ms_of_scans_with_parts_of_one() -> None:
    """Scans of 2.5 ms: 2 ms after one of them, 5 after two; scans of 2 ms: 2, 4 and 6."""
    text = TIMED.replace("TON(T,5000,0)", "TON(T,5,0)")
    claims = "T.ACC = 3", "T.ACC = 5", "T.ACC > 6"
    whole, parts = (asked(text, *claims, bounds=ScanBounds.of(each, each)) for each in (2, 2.5))
    assert [each.kind for each in whole] == [VerdictKind.PROVED] * 3
    assert [each.kind for each in parts] == [VerdictKind.PROVED, VerdictKind.REFUTED, VerdictKind.PROVED]
    assert [each.ms for each in parts[1].scans[-2:]] == [2.5, 2.5]


def test_two_timers_count_parts_of_a_ms_from_their_own_instants() -> None:
    """Begun a scan of 2.5 ms after each other, one counts 2 ms in a scan in which the other counts 3."""
    text = TIMED.replace("TON(T,5000,0)", "TON(T,500,0)").replace(
        "END\n", "XIC(Other)TON(U,500,0);\nEND\nROUTINE Unused\nEND\n", 1
    )
    text = text.replace("TAG Go", "TAG U : TIMER\nTAG Other : BOOL\nTAG Go", 1)
    claim = "T.TT AND U.TT AND old(T.TT) AND old(U.TT) AND T.ACC - old(T.ACC) <> U.ACC - old(U.ACC)"
    in_run = {"happens": RUN_ONLY}
    found = [asked(text, claim, bounds=ScanBounds.of(each, each), **in_run)[0].kind for each in (2, 2.5)]
    assert found == [VerdictKind.PROVED, VerdictKind.REFUTED]


def test_a_bit_that_prescan_clears_is_not_set_before_the_first_scan() -> None:
    """The timer never runs, so its DN is free; an operator can set it after power-up only."""
    text = TIMED.replace("XIC(Go)TON(T,5000,0)", "XIC(Go)AFI()TON(T,5000,0)")
    (verdict,) = asked(text.replace("TON(", "RTO("), "Out")
    assert (verdict.kind, verdict.k) == (VerdictKind.REFUTED, 2)
