"""Chains of causes in ladder programs: expected by hand, from the rungs and from what was done to them.

A row has rungs, what is done (`Start` sets that tag, `-Start` clears it, a number runs so many scans), the
tag asked about, and the chain: links as `name value @scan` from the tag back to its first cause; `&` joins
causes that were all needed, `|` those of which each would have done.
"""

import pytest
from chain_text import after as program_after
from chain_text import text_of
from scanrack.jobs.why.chains.partners import _with_rack_name
from scanrack.ladder.debug.chains import DEEPEST
from scanrack.ladder.debug.links import CauseLink, linked
from scanrack.ladder.files import parse_program, parse_structured

TAGS = """PROGRAM p
INSTRUCTION Motor
INPUT On : BOOL REQUIRED
INPUT Off : BOOL REQUIRED
OUTPUT Runs : BOOL REQUIRED
LOCAL Hold : BOOL
ROUTINE Logic
[XIC(On),XIC(Hold)]XIO(Off)OTE(Hold);
XIC(Hold)OTE(Runs);
END
END INSTRUCTION
INSTRUCTION Slow
INPUT In : BOOL REQUIRED
OUTPUT Out : BOOL REQUIRED
INOUT Log : DINT
LOCAL Wait : TIMER
LOCAL M : Motor
LOCAL Never : BOOL
ROUTINE Logic
XIC(In)TON(Wait,50,0);
Motor(M,Wait.DN,Never,Out);
XIC(Wait.DN)MOV(7,Log);
END
END INSTRUCTION
TAG Start : BOOL
TAG Stop : BOOL
TAG Guard : BOOL
TAG Other : BOOL
TAG Run : BOOL
TAG Lamp : BOOL
TAG Horn : BOOL
TAG Bit : BOOL
TAG Seen : BOOL
TAG N : DINT
TAG K : DINT
TAG L : DINT
TAG X : REAL
TAG T : TIMER
TAG C : COUNTER
TAG A : DINT[10]
TAG B : DINT[10]
TAG M : Motor
TAG S : Slow
TAG R : CONTROL
ALIAS Cell : A[3]
ROUTINE Main
"""
SEAL = "[XIC(Start),XIC(Run)]XIO(Stop)OTE(Run);"

ROWS = {
    "a contact": ("XIC(Start)OTE(Lamp);", "2 Start 2", "Lamp", "Lamp on @2 < Start on @2 operator"),
    "a contact that opens": (
        "XIC(Start)OTE(Lamp);", "2 Start 2 -Start 2", "Lamp", "Lamp off @4 < Start off @4 operator",
    ),
    "a contact that is closed while off": (
        "XIO(Start)OTE(Lamp);", "2 Start 2", "Lamp", "Lamp off @2 < Start on @2 operator",
    ),
    "since power-up": ("XIO(Start)OTE(Lamp);", "3", "Lamp", "Lamp on @0 < power-up @0"),
    "a rung behind a rung": (
        "XIC(Start)OTE(Run);XIC(Run)OTE(Lamp);", "2 Start 3", "Lamp",
        "Lamp on @2 < Run on @2 < Start on @2 operator",
    ),
    "a rung before the rung is a scan later": (
        "XIC(Run)OTE(Lamp);XIC(Start)OTE(Run);", "2 Start 3", "Lamp",
        "Lamp on @3 < Run on @2 < Start on @2 operator",
    ),
    "seal-in, on": (SEAL, "2 Start 2 -Start 2", "Run", "Run on @2 < Start on @2 operator"),
    "seal-in, off": (SEAL, "2 Start 2 -Start 2 Stop 2", "Run", "Run off @6 < Stop on @6 operator"),
    "the last of two needed": (
        "XIC(Start)XIC(Guard)OTE(Lamp);", "2 Start 2 Guard 2", "Lamp", "Lamp on @4 < Guard on @4 operator",
    ),
    "two needed at once": (
        "XIC(Start)XIC(Guard)OTE(Lamp);", "2 Start Guard 2", "Lamp",
        "Lamp on @2 < Start on @2 operator & Guard on @2 operator",
    ),
    "each of two would have opened it": (
        "XIC(Start)XIC(Guard)OTE(Lamp);", "2 Start Guard 2 -Start -Guard 2", "Lamp",
        "Lamp off @4 < Start off @4 operator | Guard off @4 operator",
    ),
    "each leg would have done": (
        "[XIC(Start),XIC(Guard)]OTE(Lamp);", "2 Start Guard 2", "Lamp",
        "Lamp on @2 < Start on @2 operator | Guard on @2 operator",
    ),
    "both legs had to open": (
        "[XIC(Start),XIC(Guard)]OTE(Lamp);", "2 Start Guard 2 -Start -Guard 2", "Lamp",
        "Lamp off @4 < Start off @4 operator & Guard off @4 operator",
    ),
    "the last leg to open": (
        "[XIC(Start),XIC(Guard)]OTE(Lamp);", "2 Start Guard 2 -Start 2 -Guard 2", "Lamp",
        "Lamp off @6 < Guard off @6 operator",
    ),
    "a branch within a branch": (
        "XIC(Start)[XIC(Guard)[XIC(Other),XIC(Stop)],XIC(Bit)]OTE(Lamp);", "1 Start Other 2 Guard 2", "Lamp",
        "Lamp on @3 < Guard on @3 operator",
    ),
    "latched": (
        "XIC(Start)OTL(Lamp);XIC(Stop)OTU(Lamp);", "2 Start 1 -Start 3", "Lamp",
        "Lamp on @2 < Start on @2 operator",
    ),
    "unlatched": (
        "XIC(Start)OTL(Lamp);XIC(Stop)OTU(Lamp);", "2 Start 1 -Start 3 Stop 2", "Lamp",
        "Lamp off @6 < Stop on @6 operator",
    ),
    "latched again once the unlatch lets go": (
        "XIC(Start)OTL(Lamp);XIC(Stop)OTU(Lamp);XIC(Lamp)OTE(Horn);", "2 Start Stop 3 -Stop 2", "Horn",
        "Horn on @5 < Lamp on @5 < Stop off @5 operator",
    ),
    "a one-shot latches": (
        "XIC(Start)ONS(Seen)OTL(Lamp);", "2 Start 3", "Lamp", "Lamp on @2 < Start on @2 operator",
    ),
    "a one-shot is over": (
        "XIC(Start)ONS(Seen)OTE(Lamp);", "2 Start 3", "Lamp", "Lamp off @3 < Start on @2 operator",
    ),
    "OSR": (
        "XIC(Start)OSR(Seen,Bit);XIC(Bit)OTL(Lamp);", "2 Start 3", "Lamp",
        "Lamp on @2 < Bit on @2 < Start on @2 operator",
    ),
    "OSF": (
        "XIC(Start)OSF(Seen,Bit);XIC(Bit)OTL(Lamp);", "2 Start 3 -Start 3", "Lamp",
        "Lamp on @5 < Bit on @5 < Start off @5 operator",
    ),
    "TON done": (
        "XIC(Start)TON(T,50,0);XIC(T.DN)OTE(Lamp);", "2 Start 10", "Lamp",
        "Lamp on @7 < T.DN on @7 < Start on @2 operator",
    ),
    "TON reset": (
        "XIC(Start)TON(T,50,0);XIC(T.DN)OTE(Lamp);", "2 Start 10 -Start 2", "Lamp",
        "Lamp off @12 < T.DN off @12 < Start off @12 operator",
    ),
    "TOF": (
        "XIC(Start)TOF(T,50,0);XIC(T.DN)OTE(Lamp);", "2 Start 3 -Start 10", "Lamp",
        "Lamp off @10 < T.DN off @10 < Start off @5 operator",
    ),
    "RTO": (
        "XIC(Start)RTO(T,50,0);XIC(Stop)RES(T);", "2 Start 3 -Start 3 Start 9", "T.DN",
        "T.DN on @11 < Start on @8 operator",
    ),
    "RES": (
        "XIC(Start)RTO(T,50,0);XIC(Stop)RES(T);", "2 Start 9 -Start 1 Stop 2", "T.DN",
        "T.DN off @12 < Stop on @12 operator",
    ),
    "a counter": (
        "XIC(Start)CTU(C,2,0);XIC(C.DN)OTE(Lamp);", "1 Start 1 -Start 1 Start 1 -Start 3", "Lamp",
        "Lamp on @3 < C.DN on @3 < Start on @3 operator",
    ),
    "MOV": ("MOV(K,N);", "2 K=5 3", "N", "N = 5 @2 < K = 5 @2 operator"),
    "MOV once allowed": (
        "XIC(Start)MOV(K,N);", "2 K=5 3 Start 1", "N", "N = 5 @5 < Start on @5 operator",
    ),
    "a comparison": (
        "MOV(K,N);GRT(N,3)OTE(Lamp);", "2 K=5 3", "Lamp", "Lamp on @2 < N = 5 @2 < K = 5 @2 operator",
    ),
    "CPT of two": (
        "CPT(N,K+L*2);", "2 K=5 3 L=2 2", "N", "N = 9 @5 < L = 2 @5 operator",
    ),
    "a sum": ("XIC(Start)ADD(N,1,N);", "2 Start 3", "N", "N = 3 @4 < Start on @2 operator"),
    "LIM with both limits": (
        "LIM(K,N,L)OTE(Lamp);", "1 L=9 1 N=5 K=4 2", "Lamp", "Lamp on @0 < power-up @0",
    ),
    "a computed subscript": (
        "MOV(A[K],N);", "1 A[4]=6 1 K=4 2", "N", "N = 6 @2 < K = 4 @2 operator",
    ),
    "an alias": ("MOV(K,Cell);EQU(A[3],8)OTE(Lamp);", "2 K=8 2", "Lamp",
        "Lamp on @2 < A[3] = 8 @2 < K = 8 @2 operator"),
    "COP": ("COP(A[0],B[0],4);EQU(B[2],8)OTE(Lamp);", "2 A[2]=8 2", "Lamp",
        "Lamp on @2 < B[2] = 8 @2 < A[2] = 8 @2 operator"),
    "a bit of a word": ("XIC(N.4)OTE(Lamp);", "2 N=1 1 N=17 2", "Lamp", "Lamp on @3 < N.4 on @3 operator"),
    "a bit written among others": (
        "XIC(Start)OTE(N.1);XIC(Guard)OTE(N.2);XIC(N.1)OTE(Lamp);", "2 Start 2 Guard 2", "Lamp",
        "Lamp on @2 < N.1 on @2 < Start on @2 operator",
    ),
    "a routine": (
        "XIC(Start)OTE(Run);JSR(Sub);\nEND\nROUTINE Sub\nXIC(Run)OTE(Lamp);", "2 Start 2", "Lamp",
        "Lamp on @2 < Run on @2 < Start on @2 operator",
    ),
    "a routine that is called at last": (
        "XIC(Start)JSR(Sub);\nEND\nROUTINE Sub\nXIC(Run)OTE(Lamp);", "1 Run 2 Start 2", "Lamp",
        "Lamp on @3 < Start on @3 operator",
    ),
    "an add-on instruction": (
        "Motor(M,Start,Stop,Run);XIC(Run)OTE(Lamp);", "2 Start 2 -Start 2", "Lamp",
        "Lamp on @2 < Run on @2 < Start on @2 operator",
    ),
    "an add-on instruction that stops": (
        "Motor(M,Start,Stop,Run);XIC(Run)OTE(Lamp);", "2 Start 2 -Start 2 Stop 2", "Lamp",
        "Lamp off @6 < Run off @6 < Stop on @6 operator",
    ),
    "an output parameter": (
        "Motor(M,Start,Stop,Run);XIC(M.Runs)OTE(Lamp);", "2 Start 2", "Lamp",
        "Lamp on @2 < M.Runs on @2 < Start on @2 operator",
    ),
    "an add-on instruction in one, with a timer": (
        "Slow(S,Start,Run,N);XIC(Run)OTE(Lamp);", "2 Start 10", "Lamp",
        "Lamp on @7 < Run on @7 < Start on @2 operator",
    ),
    "an InOut": ("Slow(S,Start,Run,N);EQU(N,7)OTE(Lamp);", "2 Start 10", "Lamp",
        "Lamp on @7 < N = 7 @7 < Start on @2 operator"),
    "an assignment": ("ST Lamp := Start AND Guard;", "2 Start 2 Guard 2", "Lamp",
        "Lamp on @4 < Guard on @4 operator"),
    "IF": ("ST IF Start THEN\n  N := 4;\nEND_IF;", "2 Start 2", "N",
        "N = 4 @2 < Start on @2 operator"),
    "ELSE": ("ST IF Start THEN\n  N := 4;\nELSE\n  N := K;\nEND_IF;", "2 Start 2 -Start 2", "N",
        "N = 0 @4 < Start off @4 operator"),
    "CASE": ("ST CASE K OF\n 1: N := 10;\n 2: N := 20;\nEND_CASE;", "2 K=1 2 K=2 2", "N",
        "N = 20 @4 < K = 2 @4 operator"),
    "FOR": ("ST N := 0;\nFOR L := 0 TO 3 DO\n N := N + A[L];\nEND_FOR;\nK := N;", "2 A[2]=5 2", "K",
        "K = 5 @2 < N = 5 @2 < A[2] = 5 @2 operator"),
}  # fmt: skip


def program_of(rungs):
    if rungs.startswith("ST "):
        tags = [each for each in TAGS.splitlines() if each.startswith("TAG ") and each[-1] not in "rw"]
        return parse_structured("\n".join([*tags, "", rungs[3:]]) + "\n", "p")
    return parse_program(TAGS + rungs.replace(";", ";\n") + "\nEND\n")


def after(rungs, done):
    return program_after(program_of(rungs), done)


@pytest.mark.parametrize("name", ROWS)
def test_chain(name):
    rungs, done, tag, expected = ROWS[name]
    assert text_of(after(rungs, done).chain(tag)) == expected


TAKES = {
    "a contact": ("XIC(Start)OTE(Lamp);", "2", "Lamp", None, ["Start on"]),
    "two in series": ("XIC(Start)XIO(Stop)OTE(Lamp);", "2 Stop 2", "Lamp", None, ["Start on & Stop off"]),
    "either": ("[XIC(Start),XIC(Guard)]OTE(Lamp);", "2", "Lamp", None, ["Start on", "Guard on"]),
    "seal-in": (SEAL, "2 Start 1 -Start 2", "Run", None, ["Stop on"]),
    "three": (
        "XIC(Start)XIC(Guard)XIC(Other)OTE(Lamp);", "2", "Lamp", None, ["Start on & Guard on & Other on"],
    ),
    "through rungs": (
        "XIC(Start)OTE(Run);XIC(Run)XIC(Guard)OTE(Lamp);", "2 Start 2", "Lamp", None, ["Guard on"],
    ),
    "a timer": ("XIC(Start)TON(T,50,0);XIC(T.DN)OTE(Lamp);", "2", "Lamp", None, ["Start on after 6"]),
    "by itself": ("XIC(Start)TON(T,50,0);XIC(T.DN)OTE(Lamp);", "2 Start 3", "Lamp", None, [" after 3"]),
    "a value": ("XIC(Start)MOV(5,N);XIC(Guard)MOV(6,N);", "2", "N", 5, ["Start on"]),
    "an add-on instruction": ("Motor(M,Start,Stop,Run);", "2 Stop 2", "Run", None, ["Start on & Stop off"]),
    "a one-shot that must fall first": ("XIC(Start)ONS(Seen)OTE(Lamp);", "2 Start 3", "Lamp", None, []),
    "nothing": ("XIC(Start)XIO(Start)OTE(Lamp);", "2", "Lamp", None, []),
    "an assignment": ("ST Lamp := Start AND NOT Stop;", "2 Stop 1", "Lamp", None, ["Start on & Stop off"]),
    "a number above a limit": ("GRT(K,100)OTE(Lamp);", "2", "Lamp", None, ["K = 101"]),
    "a number below a limit, and a bit": (
        "LES(K,5)XIC(Start)OTE(Lamp);", "2 K=20 2", "Lamp", None, ["K = 4 & Start on"],
    ),
    "the number that a limit has": ("EQU(K,7)OTE(Lamp);", "2", "Lamp", None, ["K = 7"]),
    "a number that is scaled: 3 x 34 is above 100": (
        "MUL(K,3,N);GRT(N,100)OTE(Lamp);", "2", "Lamp", None, ["K = 34"],
    ),
    "a number within limits": ("LIM(10,K,20)OTE(Lamp);", "2 K=50 2", "Lamp", None, ["K = 20"]),
    "a copied number": ("MOV(K,N);", "2", "N", 4, ["K = 4"]),
    "the next REAL above 2.5": ("GRT(X,2.5)OTE(Lamp);", "2", "Lamp", None, [f"X = {2.5 + 2**-22}"]),
}  # fmt: skip


def changed(each):
    is_bit = isinstance(each.value, bool)
    return f"{each.name} {('off', 'on')[each.value] if is_bit else f'= {each.value}'}"


@pytest.mark.parametrize("name", TAKES)
def test_what_it_would_take(name):
    """The sets are expected by hand; each is confirmed by a run of its own."""
    rungs, done, tag, wanted, expected = TAKES[name]
    remedies = after(rungs, done).suggest_inputs(tag, wanted)
    sets = [
        " & ".join(map(changed, one.changes)) + (f" after {one.scans}" if one.scans > 1 else "")
        for one in remedies.found
    ]
    assert sets == expected
    for one in remedies.found:
        debugger = after(rungs, done)
        for each in one.changes:
            debugger.tags[each.name] = each.value
        debugger.scan(one.scans)
        assert debugger.tags[tag] == remedies.requested


def test_what_it_would_take_is_asked_of_single_values():
    debugger = after("XIC(Start)TON(T,50,0);MOV(K,N);", "2")
    with pytest.raises(ValueError, match="T is not a single value; ask about one of its members"):
        debugger.suggest_inputs("T")
    with pytest.raises(ValueError, match="N is of type DINT; give the value that it should have"):
        debugger.suggest_inputs("N")
    assert str(debugger.suggest_inputs("N", 4)) == "N becomes 4 if K becomes 4"
    assert str(debugger.suggest_inputs("Lamp")) == "Lamp depends on no input"


def test_a_question_does_not_touch_the_program():
    debugger = after(SEAL, "2 Start 2")
    before = debugger.engine.memory.snapshot()
    debugger.chain("Run")
    debugger.suggest_inputs("Run")
    assert (debugger.engine.memory.snapshot(), debugger.scans) == (before, 4)


def test_the_links_of_an_add_on_instruction_when_asked_deeply():
    links = list(after("Motor(M,Start,Stop,Run);", "2 Start 2").chain("Run", deep=True).walk())
    assert [(each.name, each.site and each.site.routine) for each in links] == [
        ("Run", "Main"), ("M.Runs", "Motor.Logic"), ("M.Hold", "Motor.Logic"), ("M.On", "Main"),
        ("Start", None),
    ]  # fmt: skip


def test_since_when_and_what_it_was_before():
    link = after("MOV(K,N);", "2 K=5 2 K=9 3").chain("N")
    assert link.since == {
        "scan": 4, "now_ns": 40_000_000, "value": 9, "last_different": {"scan": 3, "value": 5},
    }  # fmt: skip


def test_a_chain_as_text_has_branches():
    said = str(after("XIC(Start)XIC(Guard)OTE(Lamp);", "2 Start Guard 2").chain("Lamp"))
    assert said.splitlines() == [
        "Lamp on (0.02 s, Main rung 0: XIC(Start) XIC(Guard))",
        "  <- Start on (0.02 s, set from outside of the program)",
        "  <- and Guard on (0.02 s, set from outside of the program)",
    ]


BLINK = "XIO(Lamp)OTE(Run);XIC(Run)OTE(Lamp);"
"""Both change in each scan: Lamp by Run, and Run by the Lamp of the scan before."""


@pytest.mark.slow
def test_a_chain_of_5_000_links_is_bounded_in_links_and_not_by_pythons_stack():
    chains = after(BLINK, "2500").chains()
    chains.most = 6_000
    chain = chains.of_tag("Lamp", 2_499)
    assert chain is not None
    links = list(chain.walk())
    assert [(link.name, link.scan) for link in links[:5_000]] == [
        (name, scan) for scan in range(2_499, -1, -1) for name in ("Lamp", "Run")
    ]
    assert (chain.first.kind, len(chain.as_json())) == ("power-up", 5_001)
    assert f"{chain}".count(" <- ") == 5_000


def test_the_bound_of_links_is_of_links():
    chain = after(BLINK, "300").chain("Lamp")
    assert chain is not None
    links = list(chain.walk())
    assert [link.kind for link in links] == ["rung"] * DEEPEST + ["unknown"]
    assert links[-1].text == f"more than {DEEPEST} links"


def test_links_of_another_rack_are_named_in_a_chain_of_5_000():
    chain = CauseLink("input", "Start", True, 0, 0)
    for scan in range(1, 5_000):
        chain = linked([(chain,)], kind="rung", name="Run", value=True, scan=scan, now_ns=0)
    named = list(_with_rack_name(chain, "press").walk())
    assert [each.name for each in named] == ["press: Run"] * 4_999 + ["press: Start"]
