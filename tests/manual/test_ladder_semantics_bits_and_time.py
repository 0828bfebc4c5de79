"""Bit, timer and counter instructions row by row; ids name the source (RM003 = 1756-RM003N)."""

import pytest
from ladder_bench import both

DINT_MAX, DINT_MIN = 2_147_483_647, -2_147_483_648


@pytest.mark.parametrize("engine", both("TAG X : BOOL\nTAG Y : BOOL := true", "XIC(X)OTE(Y);"), ids=str)
def test_ote_rm003_p98(engine):
    """False clears, prescan clears."""
    engine.interpreter.prescan()
    assert engine.tags.Y is False
    engine.tags.X = True
    engine.step()
    assert engine.tags.Y is True
    engine.tags.X = False
    engine.step()
    assert engine.tags.Y is False


LATCHES = "TAG X : BOOL\nTAG L : BOOL := true\nTAG U : BOOL\nTAG V : BOOL := true"


@pytest.mark.parametrize("engine", both(LATCHES, "XIC(X)OTL(U)OTU(L);", "OTU(V);"), ids=str)
def test_otl_otu_rm003_p100(engine):
    """Prescan and a false rung leave the bit."""
    engine.interpreter.prescan()
    assert (engine.tags.L, engine.tags.U, engine.tags.V) == (True, False, True)
    engine.step()
    assert (engine.tags.L, engine.tags.U, engine.tags.V) == (True, False, False)
    engine.tags.X = True
    engine.step()
    engine.tags.X = False
    engine.step()
    assert (engine.tags.L, engine.tags.U) == (False, True)


ONE_SHOT = "TAG X : BOOL\nTAG S : BOOL\nTAG N : DINT"


@pytest.mark.parametrize("engine", both(ONE_SHOT, "XIC(X)ONS(S)ADD(N,1,N);"), ids=str)
def test_ons_rm003_p103(engine):
    """Prescan sets the storage bit, so a rung true at power-up does not pass; then once per rise."""
    engine.tags.X = True
    engine.step()
    engine.step()
    assert engine.tags.N == 0
    for level in (False, True, True, False, True):
        engine.tags.X = level
        engine.step()
    assert engine.tags.N == 2
    for level in (False, False, False):  # a false rung does not pass, whatever the storage bit
        engine.tags.X = level
        engine.step()
    assert engine.tags.N == 2


EDGES = "TAG X : BOOL\nTAG R : BOOL\nTAG F : BOOL\nTAG Up : BOOL\nTAG Down : BOOL"


@pytest.mark.parametrize("engine", both(EDGES, "XIC(X)[OSR(R,Up),OSF(F,Down)];"), ids=str)
def test_osr_osf_rm003_p106_p109(engine):
    """OSR: prescan sets the storage bit. OSF: prescan clears it. One scan per edge each."""
    seen = []
    for level in (True, True, False, False, True, False):
        engine.tags.X = level
        engine.step()
        seen.append((engine.tags.Up, engine.tags.Down))
    assert seen == [(0, 0), (0, 0), (0, 1), (0, 0), (1, 0), (0, 1)]


TIMER = 'TAG X : BOOL\nTAG T : TIMER := {"PRE": 20, "ACC": 7, "DN": true}'


def timer(engine):
    tags = engine.tags
    return tags["T.EN"], tags["T.TT"], tags["T.DN"], tags["T.ACC"]


@pytest.mark.parametrize("engine", both(TIMER, "XIC(X)TON(T,?,?);"), ids=str)
def test_ton_rm003_p118(engine):
    """No time on the first true scan; done at PRE; may exceed it; stops; false clears."""
    engine.interpreter.prescan()
    assert timer(engine) == (0, 0, 0, 0)
    engine.step(8)
    engine.tags.X = True
    seen = []
    for _ in range(5):
        engine.step(8)
        seen.append(timer(engine))
    # 0, 8, 16, then 24 >= 20 is done, and nothing is added any more
    assert seen == [(1, 1, 0, 0), (1, 1, 0, 8), (1, 1, 0, 16), (1, 0, 1, 24), (1, 0, 1, 24)]
    engine.tags.X = False
    engine.step(8)
    assert timer(engine) == (0, 0, 0, 0)


@pytest.mark.parametrize("engine", both("TAG X : BOOL\nTAG T : TIMER", "XIC(X)TON(T,?,?);"), ids=str)
def test_ton_with_pre_0_is_done_in_its_first_true_scan(engine):
    """ACC, 0, has reached PRE: allowed, and no fault (RM003 p117: negative values are one)."""
    engine.step(8)
    engine.tags.X = True
    engine.step(8)
    assert timer(engine) == (1, 0, 1, 0)


@pytest.mark.parametrize("engine", both(TIMER, "XIC(X)RTO(T,?,?);"), ids=str)
def test_rto_that_is_done_is_enabled_again_rm003_p127(engine):
    """EN follows the rung; DN stays, and nothing is timed."""
    seen = []
    for level in (True, True, True, False, True):  # 7 + 8 + 8 >= 20
        engine.tags.X = level
        engine.step(8)
        seen.append(timer(engine))
    assert seen[-3:] == [(1, 0, 1, 23), (0, 0, 1, 23), (1, 0, 1, 23)]


@pytest.mark.slow
@pytest.mark.parametrize("engine", both('TAG T : TIMER := {"PRE": 100000}', "TON(T,?,?);"), ids=str)
def test_ton_counts_elapsed_time_exactly(engine):
    """10,000 scans of 0.7 ms after the first are 7,000 ms, not 6,999 and not 0."""
    for _ in range(10_001):
        engine.step(0.7)
    assert engine.tags["T.ACC"] == 7000


@pytest.mark.parametrize(
    "engine",
    both('TAG X : BOOL\nTAG T : TIMER := {"PRE": 90}', "XIC(X)JSR(Sub,0);", sub="TON(T,?,?);"),
    ids=str,
)
def test_ton_counts_the_time_since_its_own_last_scan_rm003_p117(engine):
    """A timer in a routine that is not called for 70 ms has 70 ms more when it is."""
    engine.tags.X = True
    engine.step()
    engine.tags.X = False
    for _ in range(6):
        engine.step(10)
    engine.tags.X = True
    engine.step(10)
    assert engine.tags["T.ACC"] == 70


@pytest.mark.parametrize("engine", both(TIMER, "XIC(X)TOF(T,?,?);"), ids=str)
def test_tof_rm003_p122(engine):
    """Prescan sets ACC to PRE; true holds DN; false times, then clears DN."""
    engine.interpreter.prescan()
    assert timer(engine) == (0, 0, 0, 20)
    engine.step(8)
    assert timer(engine) == (0, 0, 0, 20)
    engine.tags.X = True
    engine.step(8)
    assert timer(engine) == (1, 0, 1, 0)
    engine.tags.X = False
    seen = []
    for _ in range(5):
        engine.step(8)
        seen.append(timer(engine))
    assert seen == [(0, 1, 1, 0), (0, 1, 1, 8), (0, 1, 1, 16), (0, 0, 0, 24), (0, 0, 0, 24)]


@pytest.mark.parametrize("engine", both(TIMER, "XIC(X)RTO(T,?,?);"), ids=str)
def test_rto_rm003_p127(engine):
    """Prescan leaves ACC; false keeps ACC and DN; the time between does not count."""
    engine.interpreter.prescan()
    assert timer(engine) == (0, 0, 0, 7)
    seen = []
    for level in (True, True, False, False, True, True, False):
        engine.tags.X = level
        engine.step(8)
        seen.append(timer(engine))
    assert [each[3] for each in seen] == [7, 15, 15, 15, 15, 23, 23]
    assert seen[5][:3] == (1, 0, 1)
    assert seen[6][:3] == (0, 0, 1)


@pytest.mark.parametrize("engine", both(TIMER, "XIC(X)RTO(T,?,?);", "XIO(X)RES(T);"), ids=str)
def test_res_of_a_timer_rm003_p154(engine):
    engine.tags.X = True
    engine.step(8)
    engine.step(8)
    engine.tags.X = False
    engine.step(8)
    assert timer(engine) == (0, 0, 0, 0)
    assert engine.tags["T.PRE"] == 20


COUNTER = 'TAG X : BOOL\nTAG C : COUNTER := {"PRE": 2}'


@pytest.mark.parametrize("engine", both(COUNTER, "XIC(X)CTU(C,?,?);"), ids=str)
def test_ctu_rm003_p143(engine):
    """A rung true at power-up does not count; then one count per rise, and on past PRE."""
    seen = []
    for level in (1, 1, 0, 1, 1, 0, 1, 0, 1):
        engine.tags.X = level
        engine.step()
        seen.append((engine.tags["C.ACC"], engine.tags["C.DN"]))
    assert seen == [(0, 0), (0, 0), (0, 0), (1, 0), (1, 0), (1, 0), (2, 1), (2, 1), (3, 1)]


@pytest.mark.parametrize(
    ("name", "start", "wrapped", "flag"),
    [("CTU", DINT_MAX, DINT_MIN, "OV"), ("CTD", DINT_MIN, DINT_MAX, "UN")],
)
def test_wrap_of_a_counter_rm003_p143_p147(name, start, wrapped, flag):
    tags = f'TAG X : BOOL\nTAG C : COUNTER := {{"PRE": 0, "ACC": {start}}}'
    for engine in both(tags, f"XIC(X){name}(C,?,?);"):
        engine.step()
        engine.tags.X = True
        engine.step()
        assert (engine.tags["C.ACC"], engine.tags[f"C.{flag}"]) == (wrapped, True)
        assert engine.tags["C.DN"] is (name == "CTU")


@pytest.mark.parametrize(
    ("there", "back", "flag"), [("CTU", "CTD", "OV"), ("CTD", "CTU", "UN")], ids=["up", "down"]
)
def test_a_counter_that_wraps_back_is_where_it_was_rm003_p143_p147(there, back, flag):
    """Wrapping back clears the bit of the first wrap instead of setting its own."""
    start = DINT_MAX if there == "CTU" else DINT_MIN
    tags = f'TAG X : BOOL\nTAG Y : BOOL\nTAG C : COUNTER := {{"PRE": 0, "ACC": {start}}}'
    for engine in both(tags, f"XIC(X){there}(C,?,?);", f"XIC(Y){back}(C,?,?);"):
        engine.step()
        engine.tags.X = True
        engine.step()
        assert engine.tags[f"C.{flag}"] is True
        engine.tags.Y = True
        engine.step()
        assert (engine.tags["C.ACC"], engine.tags["C.OV"], engine.tags["C.UN"]) == (start, False, False)


@pytest.mark.parametrize("engine", both(COUNTER, "XIC(X)CTU(C,?,?);", "XIO(X)RES(C);"), ids=str)
def test_res_of_a_counter_rm003_p154(engine):
    for level in (0, 1, 0):
        engine.tags.X = level
        engine.step()
    assert engine.tags.C == {"CU": 0, "CD": 0, "DN": 0, "OV": 0, "UN": 0, "PRE": 2, "ACC": 0}


ZONE = "TAG X : BOOL\nTAG A : BOOL\nTAG B : BOOL\nTAG L : BOOL"


@pytest.mark.parametrize(
    "engine", both(ZONE, "XIC(X)MCR();", "OTE(A);", "OTL(L);", "MCR();", "OTE(B);"), ids=str
)
def test_mcr_runs_the_zone_as_false(engine):
    """FactoryTalk Design Studio help, MCR: a false MCR toggles the override."""
    engine.step()
    assert (engine.tags.A, engine.tags.L, engine.tags.B) == (False, False, True)
    engine.tags.X = True
    engine.step()
    assert (engine.tags.A, engine.tags.L, engine.tags.B) == (True, True, True)


FLOW = "TAG X : BOOL\nTAG N : DINT\nTAG M : DINT"


@pytest.mark.parametrize(
    "engine", both(FLOW, "XIC(X)JMP(Over);", "ADD(N,1,N);", "LBL(Over)ADD(M,1,M);"), ids=str
)
def test_jmp_leaves_out_what_is_between_but_not_in_prescan(engine):
    engine.step()
    engine.tags.X = True
    engine.step()
    assert (engine.tags.N, engine.tags.M) == (1, 2)


@pytest.mark.parametrize(
    "engine",
    both(
        FLOW,
        "XIC(X)JMP(Two);",
        "LBL(One)ADD(N,1,N);",
        "XIO(X)JMP(Three);",
        "LBL(Two)ADD(N,10,N);",
        "LBL(Three)ADD(M,1,M);",
    ),
    ids=str,
)
def test_a_routine_may_have_several_labels(engine):
    engine.step()
    assert (engine.tags.N, engine.tags.M) == (1, 1)
    engine.tags.X = True
    engine.step()
    assert (engine.tags.N, engine.tags.M) == (11, 2)


@pytest.mark.parametrize("engine", both(FLOW, "LBL(Again)ADD(N,1,N);", "LES(N,5)JMP(Again);"), ids=str)
def test_jmp_backwards_loops(engine):
    engine.step()
    assert engine.tags.N == 5


@pytest.mark.parametrize("engine", both(FLOW, "XIC(X)TND();", "ADD(N,1,N);"), ids=str)
def test_tnd_ends_the_routine(engine):
    engine.step()
    engine.tags.X = True
    engine.step()
    assert engine.tags.N == 1


@pytest.mark.parametrize(
    "engine", both(FLOW, "JSR(Sub,1,20,M);", sub="SBR(N);\nGRT(N,10)RET(N);\nRET(0);"), ids=str
)
def test_jsr_sbr_ret_pass_values(engine):
    engine.step()
    assert (engine.tags.N, engine.tags.M) == (20, 20)


@pytest.mark.parametrize(
    "engine",
    both("TAG A : BOOL\nTAG B : BOOL\nTAG C : BOOL", "AFI()OTE(A);", "NOP()OTE(B);", "[,AFI()]OTE(C);"),
    ids=str,
)
def test_afi_nop_and_a_wire(engine):
    engine.step()
    assert (engine.tags.A, engine.tags.B, engine.tags.C) == (False, True, True)


@pytest.mark.parametrize("engine", both(FLOW, "XIC(S:FS)ADD(N,1,N);"), ids=str)
def test_first_scan_flag(engine):
    for _ in range(3):
        engine.step()
    assert engine.tags.N == 1


@pytest.mark.parametrize(
    "engine",
    both(
        "TAG A : BOOL\nTAG B : BOOL\nTAG N : DINT",
        "OTE(A)XIC(B)MOV(1,N);",
        "XIO(A)[OTL(A)XIC(A),XIC(B)]MOV(2,N);",
    ),
    ids=str,
)
def test_inputs_after_outputs_and_outputs_in_branches(engine):
    """The coil is written before the input behind it is read."""
    engine.step()
    assert (engine.tags.A, engine.tags.N) == (True, 0)
    engine.tags.B = True
    engine.step()
    assert engine.tags.N == 1
