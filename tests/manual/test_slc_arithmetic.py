"""Arithmetic of SLC 500 and MicroLogix, row by row [1747-RM001 and 1766-RM001, chapters named per test]."""

import pytest
from slc_bench import Bench, after

UNTRAP = "OTU S:5/0"
CARRY, OVERFLOW, ZERO, SIGN = 1, 2, 4, 8


def computed(rung, a, b=0, *more):
    """Return N7:2, the flags S:0/0 to 3, and the trap, of a rung on N7:0 and N7:1."""
    bench = after(f"{rung} MOV S:0 N7:8 MOV S:5 N7:9", UNTRAP, *more, data=[f"N7:0 {a} {b} 0 0 0 0 0 0 0 0"])
    return bench["N7[2]"], bench["N7[8]"] & 0xF, bench["N7[9]"] & 1


@pytest.mark.parametrize(
    ("rung", "a", "b", "result", "flags"),
    [
        # Math Instructions, "Updates to Arithmetic Status Bits" of each instruction
        ("ADD N7:0 N7:1 N7:2", 5, 7, 12, 0),
        ("ADD N7:0 N7:1 N7:2", 5, -5, 0, CARRY | ZERO),
        ("ADD N7:0 N7:1 N7:2", -5, 2, -3, SIGN),
        ("ADD N7:0 N7:1 N7:2", -1, -1, -2, CARRY | SIGN),
        ("ADD N7:0 N7:1 N7:2", 32767, 1, 32767, OVERFLOW),
        ("ADD N7:0 N7:1 N7:2", -32768, -1, -32768, CARRY | OVERFLOW | SIGN),
        ("SUB N7:0 N7:1 N7:2", 5, 7, -2, CARRY | SIGN),
        ("SUB N7:0 N7:1 N7:2", 7, 7, 0, ZERO),
        ("SUB N7:0 N7:1 N7:2", -32768, 1, -32768, OVERFLOW | SIGN),
        ("MUL N7:0 N7:1 N7:2", 300, 100, 30000, 0),
        ("MUL N7:0 N7:1 N7:2", 300, 200, 32767, OVERFLOW),
        ("MUL N7:0 N7:1 N7:2", -300, 200, -32768, OVERFLOW | SIGN),
        ("DIV N7:0 N7:1 N7:2", 7, 2, 4, 0),
        ("DIV N7:0 N7:1 N7:2", -7, 2, -4, SIGN),
        ("DIV N7:0 N7:1 N7:2", 7, 3, 2, 0),
        ("DIV N7:0 N7:1 N7:2", 1, 3, 0, ZERO),
        ("DIV N7:0 N7:1 N7:2", 9, 0, 32767, OVERFLOW),
        ("NEG N7:0 N7:2", 5, 0, -5, CARRY | SIGN),
        ("NEG N7:0 N7:2", 0, 0, 0, ZERO),
        ("NEG N7:0 N7:2", -32768, 0, 32767, OVERFLOW),
        ("SQR N7:0 N7:2", 10, 0, 3, 0),
        ("SQR N7:0 N7:2", -9, 0, 3, 0),
        ("ABS N7:0 N7:2", -9, 0, 9, 0),
        ("CLR N7:2", 1, 0, 0, ZERO),
        # Data Handling, Move and Logical
        ("MOV N7:0 N7:2", -4, 0, -4, SIGN),
        ("AND N7:0 N7:1 N7:2", 12, 10, 8, 0),
        ("OR N7:0 N7:1 N7:2", 12, 10, 14, 0),
        ("XOR N7:0 N7:1 N7:2", 12, 12, 0, ZERO),
        ("NOT N7:0 N7:2", 0, 0, -1, SIGN),
        ("MVM N7:0 00FFh N7:2", 0x1234, 0, 0x34, 0),
        ("TOD N7:0 N7:2", 1234, 0, 0x1234, 0),
        ("FRD N7:0 N7:2", 0x1234, 0, 1234, 0),
        ("DCD N7:0 N7:2", 5, 0, 32, None),
        ("ENC N7:0 N7:2", 32, 0, 5, 0),
        # SCL: rate / 10,000, rounded, then the offset
        ("SCL N7:0 15000 10 N7:2", 3, 0, 15, 0),
        ("SCL N7:0 25000 -3 N7:2", 1, 0, 0, ZERO),
        # SCP: the line through (0, 100) and (10, 200)
        ("SCP N7:0 0 10 100 200 N7:2", 5, 0, 150, 0),
        ("SCP N7:0 0 3 0 10 N7:2", 2, 0, 7, 0),
        ("CPT N7:2 (N7:0 | 2) + N7:1", 9, 1, 5, 0),
    ],
)
def test_result_and_flags(rung, a, b, result, flags):
    value, seen, trap = computed(rung, a, b)
    assert value == result
    assert flags is None or seen == flags
    assert trap == (0 if flags is None else bool(flags & OVERFLOW))


def test_with_s2_14_the_low_sixteen_bits_stay():
    """Math Instructions, "Math Overflow Selection Bit S:2/14"."""
    bench = after("OTL S:2/14", "ADD 32767 1 N7:0", "MUL 300 200 N7:1", UNTRAP, data=["N7:0 0 0"])
    assert (bench["N7[0]"], bench["N7[1]"]) == (-32768, 60000 - 65536)


def test_the_math_register_has_the_product_and_quotient_with_remainder():
    """Math Instructions, MUL and DIV, "Changes to the Math Register"."""
    bench = after("MUL 300 200 N7:0", UNTRAP, data=["N7:0 0 0"])
    assert (bench["S[13]"] & 0xFFFF, bench["S[14]"]) == (60000, 0)
    bench = after("DIV 11 4 N7:0", data=["N7:0 0"])
    assert (bench["N7[0]"], bench["S[14]"], bench["S[13]"]) == (3, 2, 3)


def test_ddv_divides_the_math_register():
    """Math Instructions, DDV: 300 x 200 / 7 is 8571.4."""
    bench = after("MUL 300 200 N7:0 OTU S:5/0 DDV 7 N7:1", data=["N7:0 0 0"])
    assert (bench["N7[1]"], bench["S[14]"], bench["S[13]"]) == (8571, 8571, 3)


def test_floating_point_rounds_into_an_integer():
    """Data files F, "Move a float to an integer": halves away from zero; beyond the range, an overflow."""
    bench = after("MOV F8:0 N7:0 MOV F8:1 N7:1 MUL F8:0 2 F8:2", data=["F8:0 2.5 -2.5", "N7:0 0 0"])
    assert (bench["N7[0]"], bench["N7[1]"], bench["F8[2]"]) == (3, -3, 5.0)
    bench = after("MOV F8:0 N7:0", UNTRAP, data=["F8:0 40000.0", "N7:0 0"])
    assert bench["N7[0]"] == 32767


def test_a_long_has_32_bits():
    """1766-RM001, data files L."""
    bench = after("ADD L9:0 1 L9:1", data=["L9:0 70000 0"])
    assert bench["L9[1]"] == 70001


def test_the_trap_stops_the_processor_at_the_end_of_the_scan():
    """System status file, S:5/0: major error 0020 at END, unless the program clears it before."""
    bench = Bench("ADD 32767 1 N7:0", "MOV 5 N7:1", data=["N7:0 0 0"])
    fault = bench.scan()
    assert (fault.type, fault.code) == (0, 0x0020)
    assert (bench["N7[1]"], bench["S[6]"], bench["S[1]"] >> 13 & 1) == (5, 0x0020, 1)


def test_the_trap_stops_the_processor_at_tnd():
    """The same at TND, which ends the scan; rungs behind it do not run."""
    bench = Bench("ADD 32767 1 N7:0", "TND", "OTU S:5/0", data=["N7:0 0"])
    assert bench.scan().code == 0x0020


def test_indexed_addresses_go_on_by_s24():
    """Addressing, "Indexed Addressing": the offset is in S:24."""
    bench = after("MOV 2 S:24 ADD #N7:0 1 N7:5", data=["N7:0 10 20 30 0 0 0"])
    assert bench["N7[5]"] == 31
