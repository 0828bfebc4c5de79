"""Bits, timers, counters, files and program control of SLC 500 and MicroLogix [1747-RM001, 1766-RM001]."""

import pytest
from scanrack.ladder.model.stubs import Stubs, parse_stub
from scanrack.rockwell.slc import import_text
from slc_bench import Bench, after, imported

# --- Addressing


@pytest.mark.parametrize(
    ("address", "word", "bit"),
    [("B3/17", 1, 1), ("B3:1/1", 1, 1), ("B3/0", 0, 0), ("B3/[N7:0]", 2, 3), ("B3:[N7:1]/[N7:2]", 1, 4)],
)
def test_bits_of_a_file(address, word, bit):
    """Addressing: a bit of the file, of a word, and indirect ones."""
    bench = after(f"OTL {address}", data=["B3:0 0 0 0", "N7:0 35 1 4"])
    assert [value >> bit & 1 if place == word else value for place, value in enumerate(bench["B3"][:3])] == [
        int(place == word) for place in range(3)
    ]


def test_a_word_that_another_word_names():
    bench = after("MOV N7:[N7:1] N7:0", data=["N7:0 0 3 0 77"])
    assert bench["N7[0]"] == 77


def test_an_index_beyond_the_file_is_a_major_fault():
    assert Bench("MOV N7:[N7:1] N7:0", data=["N7:0 0 300"]).scan().code == 20


def test_the_3601_of_a_micrologix_is_words_of_its_slot():
    """An I/O card of vendor 3, type 10, code 25: I:1.0 to I:1.7 and O:1.0 to O:1.7 are the images."""
    found = imported("XIC I:1.0/14 MOV I:1.7 N7:0 OTE O:1/19", slots=[1])
    assert [str(rung) for rung in found.program.routines[0].rungs] == [
        "XIC(I:1.0/14)MOV(I:1.7,N7:0)OTE(O:1.1/3);"
    ]
    images = {(each.slot, each.output) for each in found.program.build().layout.images}
    assert images == {(1, False), (1, True)}
    assert not found.report.notes


def test_a_slot_that_the_rack_does_not_have_is_memory_and_listed():
    found = imported("XIC I:2/3 OTE O:0/1", slots=[1])
    assert [each.text.split(":")[0] for each in found.report.notes] == ["I", "O"]
    engine = found.program.compile()
    engine.tags["I:2"] = [8]
    engine.step()
    assert engine.tags["O:0"] == [2]


def test_bits_and_words_of_a_function_file():
    """1766-RM001, function files: a tag whose parts are what the rungs name."""
    bench = after("MOV RTC:0.HR N7:0 XIC RTC:0/DS OTE B3/0", data=["N7:0 7", "B3:0 0"])
    assert (bench["N7[0]"], bench["RTC[0]"]) == (0, {"HR": 0, "DS": False})


def test_osr_of_an_slc_500_passes_for_one_scan_and_that_of_a_micrologix_sets_a_bit():
    bench = Bench("XIC B3/0 OSR B3/1 ADD N7:0 1 N7:0", "XIC B3/0 OSR B3/2 B3/3 OTE B3/4", data=["B3:0 0"])
    seen = []
    for go in (0, 1, 1, 0, 1):
        bench["B3[0]"] = bench["B3[0]"] & ~1 | go
        bench.scan()
        seen.append((bench["N7[0]"], bench["B3[0]"] >> 3 & 1, bench["B3[0]"] >> 4 & 1))
    assert seen == [(0, 0, 0), (1, 1, 1), (1, 0, 1), (1, 0, 0), (2, 1, 1)]


def test_a_message_with_a_control_block_of_words():
    """Communication Instructions, MSG: EN, ST, then DN of word 0; EN ends with the rung."""
    found = import_text(
        "SOR XIC B3/0 MSG READ 500CPU LOCAL N9:0 14 EOR",
        "bench",
        Stubs({"MSG": parse_stub("done after 20 ms")}),
    )
    assert found.report.refused == []
    assert found.program is not None
    for engine in (found.program.compile(), found.program.interpret()):
        seen = []
        for go in (1, 1, 1, 1, 0):
            engine.tags["B3[0]"] = go
            engine.step()
            seen.append(engine.tags["N9[0]"] >> 12 & 0xF)
        assert seen == [0b1100, 0b1100, 0b1010, 0b1010, 0b0010]


# --- Status file


def test_s1_15_is_on_in_the_first_scan():
    bench = Bench("XIC S:1/15 ADD N7:0 1 N7:0", "XIO S:1/15 ADD N7:1 1 N7:1", data=["N7:0 0 0"])
    bench.scan(3)
    assert (bench["N7[0]"], bench["N7[1]"], bench["S[1]"] & 0x1F) == (1, 2, 6)


def test_s4_counts_10_ms_and_the_calendar_goes_on():
    bench = Bench("NOP")
    bench.scan(6, ms=10_000)
    assert (bench["S[4]"], bench["S"][37:43]) == (5000, [1970, 1, 1, 0, 0, 50])


# --- Basic Instructions: timers


@pytest.mark.parametrize(("base", "scans", "accumulated"), [("0.01", 6, 5), ("1.0", 6, 0), ("0.001", 6, 20)])
def test_a_timer_counts_its_time_base(base, scans, accumulated):
    """TON: a scan of 10 ms; 50 ms are 5 x 0.01 s, no second, and 50 ms, of which PRE allows 20."""
    bench = Bench(f"TON T4:0 {base} 20 0")
    bench.scan(scans)
    assert bench["T4[0].ACC"] == accumulated


def test_ton_row_by_row():
    bench = Bench("XIC B3/0 TON T4:0 0.01 2 0", data=["B3:0 1"])
    names = ("EN", "TT", "DN", "ACC")
    seen = []
    for go in (1, 1, 1, 1, 0):
        bench["B3[0]"] = go
        bench.scan()
        seen.append(tuple(int(bench[f"T4[0].{name}"]) for name in names))
    assert seen == [(1, 1, 0, 0), (1, 1, 0, 1), (1, 0, 1, 2), (1, 0, 1, 2), (0, 0, 0, 0)]


def test_tof_row_by_row():
    bench = Bench("XIC B3/0 TOF T4:0 0.01 2 0", data=["B3:0 0"])
    names = ("EN", "TT", "DN", "ACC")
    seen = []
    for go in (0, 1, 0, 0, 0, 0):
        bench["B3[0]"] = go
        bench.scan()
        seen.append(tuple(int(bench[f"T4[0].{name}"]) for name in names))
    assert seen == [(0, 0, 0, 2), (1, 0, 1, 0), (0, 1, 1, 0), (0, 1, 1, 1), (0, 0, 0, 2), (0, 0, 0, 2)]


def test_rto_retains_and_res_resets():
    bench = Bench("XIC B3/0 RTO T4:0 0.01 9 0", "XIC B3/1 RES T4:0", data=["B3:0 1"])
    bench.scan(4)
    bench["B3[0]"] = 0
    bench.scan(3)
    assert (bench["T4[0].ACC"], bench["T4[0].EN"]) == (3, False)
    bench["B3[0]"] = 2
    bench.scan()
    assert bench["T4[0].ACC"] == 0


def test_part_of_a_time_base_waits_for_the_next_scan():
    bench = Bench("TON T4:0 0.01 1000 0")
    bench.scan(101, ms=7)
    assert bench["T4[0].ACC"] == 70


def test_a_negative_preset_is_a_major_fault():
    """Fault 0034: a negative value in a timer's preset or accumulator."""
    bench = Bench("MOV -1 T4:0.PRE", "TON T4:0 0.01 10 0")
    assert bench.scan().code == 34


# --- counters


def test_ctu_counts_rungs_that_become_true_and_wraps_in_16_bits():
    bench = Bench("XIC B3/0 CTU C5:0 10 0", data=["B3:0 0", "C5:0 0 10 32766"])
    seen = []
    for go in (0, 1, 1, 0, 1):
        bench["B3[0]"] = go
        bench.scan()
        seen.append((bench["C5[0].ACC"], int(bench["C5[0].OV"]), int(bench["C5[0].DN"])))
    assert seen == [(32766, 0, 1), (32767, 0, 1), (32767, 0, 1), (32767, 0, 1), (-32768, 1, 0)]


def test_ctd_and_res():
    bench = Bench("XIC B3/0 CTD C5:0 0 0", "XIC B3/1 RES C5:0", data=["B3:0 0", "C5:0 0 0 -32768"])
    bench.scan()
    bench["B3[0]"] = 1
    bench.scan()
    assert (bench["C5[0].ACC"], bench["C5[0].UN"]) == (32767, True)
    bench["B3[0]"] = 2
    bench.scan()
    assert (bench["C5[0].ACC"], bench["C5[0].UN"], bench["C5[0].CD"]) == (0, False, False)


# --- File, Sequencer and Shift Instructions


def test_cop_and_fll_count_elements_of_the_destination():
    bench = after("COP #N7:0 #N7:4 3", "FLL 9 #N7:8 2", data=["N7:0 1 2 3 4 0 0 0 0 0 0 0"])
    assert bench["N7"][:11] == [1, 2, 3, 4, 1, 2, 3, 0, 9, 9, 0]


def test_cop_of_a_timer_to_words():
    """A timer is three words: bits, PRE, ACC."""
    bench = after("COP #T4:0 #N7:0 3", data=["T4:0 8192 5 6", "N7:0 0 0 0"])
    assert bench["N7"][:3] == [8192, 5, 6]


def test_bsl_shifts_length_bits():
    """BSL: the bit enters at bit 0, the one of bit 18 leaves to UL."""
    data = ["B3:0 1 4", "N7:0 1", "B10:0 0"]
    bench = Bench("XIC B10/0 BSL #B3:0 R6:0 N7:0/0 19", data=data)
    bench.scan()
    bench["B10[0]"] = 1
    bench.scan(2)
    assert (bench["B3"][:2], bench["R6[0].UL"], bench["R6[0].DN"]) == ([3, 0], True, True)


def test_bsr_shifts_to_the_right():
    bench = Bench("XIC B10/0 BSR #B3:0 R6:0 N7:0/0 16", data=["B3:0 3", "N7:0 1", "B10:0 0"])
    bench.scan()
    bench["B10[0]"] = 1
    bench.scan()
    assert (bench["B3[0]"] & 0xFFFF, bench["R6[0].UL"]) == (0x8001, True)


def test_sqo_goes_from_step_to_step():
    bench = Bench("XIC B3/0 SQO #N7:0 00FFh N10:0 R6:0 2 0", data=["N7:0 0 5 6", "N10:0 256", "B3:0 0"])
    seen = []
    for go in (0, 1, 0, 1, 0, 1):
        bench["B3[0]"] = go
        bench.scan()
        seen.append((bench["R6[0].POS"], bench["N10[0]"], int(bench["R6[0].DN"])))
    assert [each for each, go in zip(seen, (0, 1, 0, 1, 0, 1), strict=True) if go] == [
        (1, 261, 0),
        (2, 262, 1),
        (1, 261, 0),
    ]


def test_sqc_tells_by_fd():
    bench = Bench("XIC B3/0 SQC #N7:0 FFFFh N10:0 R6:0 2 0", data=["N7:0 0 5 6", "N10:0 5", "B3:0 0"])
    bench.scan()
    bench["B3[0]"] = 1
    bench.scan()
    assert (bench["R6[0].FD"], bench["R6[0].POS"]) == (True, 1)


def test_a_queue():
    rungs = ("XIC B3/0 FFL N7:0 #N10:0 R6:0 4 0", "XIC B3/1 FFU #N10:0 N7:1 R6:0 4 0")
    bench = Bench(*rungs, data=["N7:0 8 0", "B3:0 0", "N10:0 0 0 0 0"])
    for word in (0, 1, 0, 1, 2):
        bench["B3[0]"] = word
        bench.scan()
    assert (bench["N7[1]"], bench["R6[0].POS"], bench["N10"][:2]) == (8, 1, [8, 0])


# --- Program Flow Instructions


def test_jsr_by_the_number_of_its_file():
    bench = after("JSR U:3 JSR 3", data=["N7:0 0"], sub=["SBR ADD N7:0 1 N7:0", "RET", "ADD N7:0 1 N7:0"])
    assert bench["N7[0]"] == 2


def test_tnd_in_a_subroutine_ends_the_scan():
    bench = after("JSR U:3", "MOV 5 N7:1", data=["N7:0 0 0"], sub=["MOV 7 N7:0", "TND"])
    assert bench["N7"][:2] == [7, 0]


def test_jmp_and_lbl():
    bench = after("JMP Q2:1", "MOV 5 N7:0", "LBL Q2:1 MOV 6 N7:1", data=["N7:0 0 0"])
    assert bench["N7"][:2] == [0, 6]


def test_comparisons_and_masks():
    rungs = ("EQU N7:0 5 GRT N7:0 4 LIM 1 N7:0 9 MEQ N7:0 000Fh 5 OTE B3/0", "NEQ N7:0 5 OTE B3/1")
    assert after(*rungs, data=["N7:0 5", "B3:0 0"])["B3[0]"] == 1
