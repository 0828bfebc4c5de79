"""Compare, compute, move and file instructions row by row; ids name the source (RM003 = 1756-RM003N)."""

# ruff: noqa: SIM300 - tags in capitals are no constants

import math

import pytest
from ladder_bench import both
from scanrack.ladder import LadderFault

TAGS = """TAG S : SINT
TAG I : INT
TAG D : DINT
TAG E : DINT
TAG L : LINT
TAG R : REAL
TAG Q : REAL
TAG Yes : BOOL
TAG Block : INT[8] := [1, 2, 3, 4, 5, 6, 7, 8]
TAG Wide : DINT[3]
TAG T : TIMER
"""


def after(*rungs, **values):
    """Run the rungs once on both back ends, with these values; return the tags, which must agree."""
    engines = both(TAGS, *rungs)
    for engine in engines:
        for name, value in values.items():
            engine.tags[name] = value
        engine.step()
    compiled, interpreted = (engine.tags for engine in engines)
    assert all(compiled[name] == interpreted[name] or math.isnan(compiled[name]) for name in compiled)
    assert [str(fault) for fault in engines[0].minor_faults] == [
        str(fault) for fault in engines[1].minor_faults
    ]
    return engines[0]


@pytest.mark.parametrize(
    ("value", "wanted"),
    [(2.5, 2), (1.5, 2), (-1.5, -2), (-2.5, -2), (1.6, 2), (-1.6, -2), (1.4, 1), (-1.4, -1)],
)
def test_real_to_integer_rm003_p653(value, wanted):
    assert after("MOV(R,D);", R=value).tags.D == wanted


@pytest.mark.parametrize(("kind", "wanted"), [("I", 129), ("S", -127)])
def test_narrowing_rm006_p544(kind, wanted):
    """65,665 is 1_0081h; the low bits stay, S:V tells, and a minor fault is recorded."""
    engine = after(f"MOV(D,{kind});", "XIC(S:V)OTE(Yes);", D=65_665)
    assert engine.tags[kind] == wanted
    assert engine.tags.Yes is True
    assert [(fault.type, fault.code) for fault in engine.minor_faults] == [(4, 4)]


def test_real_is_single_precision():
    # the single nearest to 0.1 is 13421773 / 2^27
    assert after("MOV(0.1,R);").tags.R == 13_421_773 / 2**27


def test_division_by_zero_rm003_p277():
    """A minor fault, type 4 code 4; the dividend stays (docs/instructions.md), the scan goes on."""
    engine = after("DIV(D,E,L);", "MOD(D,E,D);", "MOV(5,E);", D=17)
    assert (engine.tags.L, engine.tags.D, engine.tags.E) == (17, 17, 5)
    assert [(fault.site.rung, fault.code) for fault in engine.minor_faults] == [(0, 4), (1, 4)]
    assert engine.tags["S:MINOR"] is True


def test_real_division_by_zero():
    assert after("DIV(R,Q,R);", R=-2.0).tags.R == -math.inf


@pytest.mark.parametrize(("a", "b", "whole", "rest"), [(7, 2, 3, 1), (-7, 2, -3, -1), (7, -2, -3, 1)])
def test_div_and_mod_cut_off_rm003_p281(a, b, whole, rest):
    """MOD is A - TRN(A/B)*B."""
    engine = after("DIV(D,E,L);", "MOD(D,E,S);", D=a, E=b)
    assert (engine.tags.L, engine.tags.S) == (whole, rest)


def test_div_into_real_and_of_real_rm003_p276():
    """Into a REAL 5/2 is 2.5; of REAL into a DINT it is rounded, half to even."""
    engine = after("DIV(D,2,R);", "DIV(Q,2,E);", D=5, Q=5.0)
    assert (engine.tags.R, engine.tags.E) == (2.5, 2)


@pytest.mark.parametrize(
    ("rung", "d", "wanted", "flags"),
    [
        ("ADD(D,1,D);", 2_147_483_647, -2_147_483_648, (1, 0, 1, 0)),  # V, N
        ("ADD(D,1,D);", -1, 0, (0, 1, 0, 1)),  # Z, carry out of bit 31
        ("SUB(D,1,D);", 0, -1, (0, 0, 1, 1)),  # N, borrow
        ("MUL(D,D,D);", 65_536, 0, (1, 1, 0, 0)),
        ("NEG(D,D);", -2_147_483_648, -2_147_483_648, (1, 0, 1, 1)),
        ("ABS(D,D);", -5, 5, (0, 0, 0, 0)),
        ("CLR(D);", 5, 0, (0, 1, 0, 0)),
    ],
)
def test_overflow_and_flags(rung, d, wanted, flags):
    reader = "XIC(S:V)OTE(T.EN);", "XIC(S:Z)OTE(T.TT);", "XIC(S:N)OTE(T.DN);", "XIC(S:C)OTE(Yes);"
    engine = after(rung, *reader, D=d)
    tags = engine.tags
    assert tags.D == wanted
    assert (tags["T.EN"], tags["T.TT"], tags["T.DN"], tags.Yes) == flags


def test_lint_keeps_64_bits():
    assert after("ADD(D,1,L);", D=2_147_483_647).tags.L == 2_147_483_648


@pytest.mark.parametrize(
    ("rung", "wanted"),
    [
        ("CPT(D,TOD(E));", 0x1254),
        ("CPT(D,FRD(L)+1);", 7655),  # L is 16#7654
        ("CPT(D,FRD(TOD(E))-TO_BCD(15));", 1254 - 0x15),
        ("CPT(R,FRD(L)/4);", 1913.5),
    ],
)
def test_decimal_digits_in_expressions_rm003_operators(rung, wanted):
    tags = after(rung, E=1254, L=0x7654).tags
    assert (tags.R if "(R," in rung else tags.D) == wanted


def test_square_root_takes_the_size_rm003_p284():
    engine = after("SQR(D,E);", "SQR(R,Q);", D=-27, R=-6.25)
    assert (engine.tags.E, engine.tags.Q) == (5, 2.5)


def test_truncate_rm003_p567():
    engine = after("TRN(R,D);", "TRN(Q,E);", R=357.06, Q=-1.9)
    assert (engine.tags.D, engine.tags.E) == (357, -1)


@pytest.mark.parametrize(
    ("low", "test", "high", "wanted"),
    [(5, 5, 8, 1), (5, 8, 8, 1), (5, 9, 8, 0), (8, 5, 5, 1), (8, 6, 5, 0), (8, 7, 5, 0), (8, 8, 5, 1)],
)
def test_lim_rm003_p246(low, test, high, wanted):
    """With the limits crossed what lies between them is false, the limits themselves are true."""
    assert after("LIM(D,E,L)OTE(Yes);", D=low, E=test, L=high).tags.Yes == wanted


def test_meq_rm003_p250():
    assert after("MEQ(D,16#00FF,E)OTE(Yes);", D=0x1234, E=0x5634).tags.Yes is True
    assert after("MEQ(D,16#0FFF,E)OTE(Yes);", D=0x1234, E=0x5634).tags.Yes is False


@pytest.mark.parametrize(
    ("name", "results"),
    [("EQU", "010"), ("NEQ", "101"), ("LES", "100"), ("LEQ", "110"), ("GRT", "001"), ("GEQ", "011")],
)
def test_comparisons_under_both_names(name, results):
    other = {"EQU": "EQ", "NEQ": "NE", "LES": "LT", "LEQ": "LE", "GRT": "GT", "GEQ": "GE"}[name]
    for spelling in (name, other, name.lower()):
        found = [after(f"{spelling}(D,E)OTE(Yes);", D=d, E=2).tags.Yes for d in (1, 2, 3)]
        assert "".join(str(int(each)) for each in found) == results


def test_cmp_and_cpt_order_of_operators_rm003_p265():
    engine = after("CMP(D+E*2>=L AND NOT (D=3))CPT(R,(D+E)*2-7 MOD 4**2/2.0);", D=2, E=3, L=8)
    # 7 MOD (4**2) = 7, then 7 / 2.0 = 3.5 from the left; (2+3)*2 - 3.5 = 6.5
    assert engine.tags.R == 6.5


def test_logical_fill_up_with_zeros_rm003_p311():
    """An INT of FFFFh is 0000FFFFh in a DINT; into an INT nothing is lost."""
    engine = after("OR(I,0,D);", "NOT(I,E);", I=-1)
    assert (engine.tags.D, engine.tags.E) == (0xFFFF, -65_536)


@pytest.mark.parametrize(
    ("rung", "wanted"), [("AND(D,E,L);", 0b1000), ("OR(D,E,L);", 0b1110), ("XOR(D,E,L);", 0b0110)]
)
def test_logical(rung, wanted):
    assert after(rung, D=0b1100, E=0b1010).tags.L == wanted


def test_mvm_rm003_p299():
    assert after("MVM(D,16#00FF,E);", D=0x1234, E=0x5678).tags.E == 0x5634


def test_btd_rm003_p303():
    """Bits that find no room are lost and do not wrap."""
    engine = after("BTD(D,3,E,5,10);", "BTD(D,0,I,12,8);", D=0b1_1111_1111_1000, E=0)
    assert engine.tags.E == 0b11_1111_1111 << 5
    assert engine.tags.I == -32_768  # bits 0 to 3 of D are 1000: only bit 15 is set


def test_swpb_rm003():
    engine = after("SWPB(D,REVERSE,E);", "SWPB(I,WORD,D);", D=0x41424344, I=0x0102)
    assert (engine.tags.E, engine.tags.D) == (0x44434241, 0x0201)


def test_cop_copies_bytes_rm003_p371():
    """Eight INTs are four DINTs; three fit, the copy stops at the end of the array."""
    engine = after("COP(Block,Wide,9);")
    assert engine.tags.Wide == [0x0002_0001, 0x0004_0003, 0x0006_0005]


def test_cop_from_an_element_and_of_a_real():
    engine = after("COP(Block[6],Block[0],4);", "COP(R,D,1);", R=1.0)
    assert engine.tags.Block == [7, 8, 3, 4, 5, 6, 7, 8]
    assert engine.tags.D == 0x3F80_0000  # 1.0 in IEEE 754


def test_cop_of_a_timer_is_its_three_dints():
    engine = after("COP(T,Wide,3);", **{"T.PRE": 5, "T.ACC": 6, "T.DN": True})
    assert engine.tags.Wide == [1 << 29, 5, 6]


def test_fll_converts_and_stops_rm003_p377():
    engine = after("FLL(R,Block[5],9);", R=2.5)
    assert engine.tags.Block == [1, 2, 3, 4, 5, 2, 2, 2]


@pytest.mark.parametrize(
    "rung", ["MOV(Block[D],E);", "MOV(1,Block[D]);", "XIC(I.[D])OTE(Yes);", "OTE(Block[D].0);"]
)
@pytest.mark.parametrize("index", [-1, 16])
def test_subscript_out_of_range_is_a_major_fault_rm006_p539(rung, index):
    for engine in both(TAGS, "NOP();", rung):
        engine.tags.D = index
        with pytest.raises(LadderFault) as caught:
            engine.step()
        fault = caught.value
        assert (fault.type, fault.code, fault.site.routine, fault.site.rung) == (4, 20, "Main", 1)
        assert fault.tag in ("Block[D]", "I.[D]", "Block[D].0")
        assert f"subscript {index}" in str(fault)


def test_a_false_rung_does_not_look_at_the_subscript():
    assert after("XIC(Yes)MOV(Block[D],E);", D=99).tags.E == 0


@pytest.mark.parametrize("member", ["PRE", "ACC"])
def test_negative_timer_is_a_major_fault_rm003_p117(member):
    for engine in both(TAGS, "XIC(Yes)RTO(T,?,?);"):
        engine.tags.Yes = True
        engine.tags[f"T.{member}"] = -1
        with pytest.raises(LadderFault, match=r"type 4 code 34") as caught:
            engine.step()
        assert caught.value.tag == "T"


def test_strings_compare_by_their_characters():
    tags = 'TAG A : STRING := "abc"\nTAG B : STRING := "abd"\nTAG Less : BOOL\nTAG Same : BOOL'
    for engine in both(tags, "LES(A,B)OTE(Less);", "EQU(A,'abc')OTE(Same);"):
        engine.step()
        assert (engine.tags.Less, engine.tags.Same) == (True, True)


@pytest.mark.parametrize(
    ("condition", "wanted"),
    [
        ("D>0 AND E>0", (False, False, False, True)),
        ("D>0 OR E>0", (False, True, True, True)),
        ("D>0 XOR E>0", (False, True, True, False)),
        ("NOT (D>0)", (True, True, False, False)),
    ],
)
def test_cmp_joins_relations_rm003_p232(condition, wanted):
    """The truth tables, rows 00, 01, 10, 11 of D and E."""
    rows = [(d, e) for d in (0, 1) for e in (0, 1)]
    assert tuple(after(f"CMP({condition})OTE(Yes);", D=d, E=e).tags.Yes for d, e in rows) == wanted


def test_lim_with_equal_limits_is_one_value_rm003_p246():
    """Low is not above high, so the test has to be between them."""
    assert [after("LIM(5,D,5)OTE(Yes);", D=value).tags.Yes for value in (4, 5, 6)] == [False, True, False]


@pytest.mark.parametrize(
    "rung",
    ["MOV(1,E);", "CPT(E,1+1);", "TRN(1.5,E);", "AND(1,1,E);", "NOT(1,E);", "CLR(E);", "ADD(1,1,E);"],
)
def test_an_instruction_that_fits_clears_the_overflow_of_the_one_before(rung):
    """1756-RM003N, arithmetic status flags: S:V says what the latest instruction did."""
    engine = after("ADD(2147483647,1,D);", rung, "XIC(S:V)OTE(Yes);")
    assert engine.tags.Yes is False
    assert len(engine.minor_faults) == 1


@pytest.mark.parametrize(
    ("mask", "zero", "negative"), [(0, True, False), (-1, False, True), (3, False, False)]
)
def test_logical_instructions_tell_zero_and_sign(mask, zero, negative):
    """-5 is 1...1011: AND 0 is 0, AND -1 is -5, AND 3 is 3."""
    for flag, wanted in (("S:Z", zero), ("S:N", negative)):
        assert after(f"AND(-5,{mask},E);", f"XIC({flag})OTE(Yes);").tags.Yes is wanted


def test_truncation_of_infinity_overflows():
    engine = after("TRN(R,D);", "XIC(S:V)OTE(Yes);", R=math.inf)
    assert (engine.tags.Yes, engine.tags.D, len(engine.minor_faults)) == (True, 0, 1)


def test_fll_rounds_half_to_even_as_mov_does():
    assert after("FLL(3.5,Block[0],2);").tags.Block[:3] == [4, 4, 3]


def test_overflow_in_real_tells_once_and_infinity_goes_on():
    """3.0e38 + 3.0e38 is beyond REAL; infinity + 1 is infinity, and no news."""
    engine = after("ADD(R,R,Q);", "XIC(S:V)OTE(Yes);", R=3.0e38)
    assert (engine.tags.Q, engine.tags.Yes, len(engine.minor_faults)) == (math.inf, True, 1)
    engine = after("ADD(R,1,Q);", "XIC(S:V)OTE(Yes);", R=math.inf)
    assert (engine.tags.Q, engine.tags.Yes, len(engine.minor_faults)) == (math.inf, False, 0)


def test_bitwise_operators_compute_in_integers_inside_of_a_real_expression():
    """6 AND 3 is 2, and 2 + 0.5 is 2.5."""
    assert after("CPT(R,(D AND E)+Q);", D=6, E=3, Q=0.5).tags.R == 2.5


def test_two_dimensions_count_row_by_row():
    """Element [1,2] of DINT[2,3] is the sixth."""
    tags = "TAG G : DINT[2,3] := [[0, 1, 2], [3, 4, 5]]\nTAG A : DINT\nTAG B : DINT\nTAG N : DINT"
    for engine in both(tags, "MOV(G[A,B],N);"):
        engine.tags.A, engine.tags.B = 1, 2
        engine.step()
        assert engine.tags.N == 5
