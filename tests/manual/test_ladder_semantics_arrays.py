"""File, shift and sequencer instructions, FOR and BRK; ids name the page (RM003 = 1756-RM003N)."""

import pytest
from ladder_bench import both
from scanrack.ladder import LadderFault
from scanrack.ladder.state import fault_log
from scanrack.ladder.state.memory import same

TAGS = """TYPE Part (Size : INT, Good : BOOL, Weight : REAL)
TAG Go : BOOL
TAG Bit : BOOL
TAG Yes : BOOL
TAG D : DINT
TAG N : INT
TAG R : REAL
TAG Index : DINT
TAG Sum : DINT
TAG By : DINT := 1
TAG C : CONTROL
TAG Bits : DINT[2]
TAG Table : DINT[5] := [0, 11, 22, 33, 44]
TAG Data : INT[6] := [5, 1, 4, 2, 3, 9]
TAG Copy : DINT[6]
TAG Queue : INT[4]
TAG Fine : LREAL
TAG Fines : LREAL[3]
TAG Grid : DINT[2,3] := [[1, 2, 3], [40, 60, 50]]
TAG One : Part := {"Size": 3, "Good": true, "Weight": 1.5}
TAG Two : Part
TAG Stack : Part[3]
"""


class Both:
    """Rungs on both back ends, which must agree after every scan."""

    def __init__(self, *rungs, sub=None):
        self.engines = both(TAGS, *rungs, sub=sub)
        self.tags = self.engines[0].tags

    def scan(self, **values):
        faults: list[LadderFault | None] = []
        for engine in self.engines:
            for name, value in values.items():
                engine.tags[name] = value
            try:
                engine.step()
                faults.append(None)
            except LadderFault as fault:
                faults.append(fault)
        compiled, interpreted = (engine.memory.snapshot() for engine in self.engines)
        assert {path for path in compiled if not same(compiled[path], interpreted[path])} == set()
        assert str(faults[0]) == str(faults[1])
        if faults[0]:
            raise faults[0]
        return self

    def pulse(self, **values):
        """A scan with a true rung, and one with a false rung."""
        self.scan(Go=True, **values)
        return self.scan(Go=False)

    def control(self, *names):
        return tuple(int(self.tags[f"C.{name}"]) for name in names)

    def list(self, name, count):
        return [self.tags[f"{name}[{each}]"] for each in range(count)]


# --- FAL, FSC


def test_fal_in_all_mode_rm003_p351():
    bench = Both("XIC(Go)FAL(C,6,0,ALL,Copy[C.POS],Data[C.POS]*10);")
    bench.scan(Go=True)
    assert bench.list("Copy", 6) == [50, 10, 40, 20, 30, 90]
    assert bench.control("EN", "DN", "ER", "POS") == (1, 1, 0, 6)
    bench.scan(Go=True, **{"Data[0]": 7})
    assert bench.tags["Copy[0]"] == 50  # once per transition
    bench.scan(Go=False)
    assert bench.control("EN", "DN", "POS") == (0, 0, 0)


def test_fal_in_incremental_mode_does_one_element_per_transition():
    bench = Both("XIC(Go)FAL(C,3,0,INC,Copy[C.POS],Data[C.POS]);")
    seen = []
    for _ in range(3):
        bench.scan(Go=True).scan(Go=True)
        seen.append((bench.list("Copy", 3), bench.control("DN", "POS")))
        bench.scan(Go=False)
    assert seen == [([5, 0, 0], (0, 1)), ([5, 1, 0], (0, 2)), ([5, 1, 4], (1, 3))]
    assert bench.control("DN", "POS") == (0, 0)


def test_fal_in_numeric_mode_goes_on_whatever_the_rung_does():
    bench = Both("XIC(Go)FAL(C,5,0,2,Copy[C.POS],Data[C.POS]);")
    bench.scan(Go=True)
    assert bench.control("EN", "DN", "POS") == (1, 0, 2)
    bench.scan(Go=False)
    assert bench.control("EN", "DN", "POS") == (1, 0, 4)
    bench.scan(Go=False)
    assert bench.control("EN", "DN", "POS") == (1, 1, 5)
    assert bench.list("Copy", 6) == [5, 1, 4, 2, 3, 0]
    bench.scan(Go=False)
    assert bench.control("EN", "DN", "POS") == (0, 0, 0)


def test_fal_stops_at_an_overflow_until_er_is_cleared():
    bench = Both("XIC(Go)FAL(C,3,0,ALL,Queue[C.POS],Table[C.POS]);")
    bench.scan(Go=True, **{"Table[1]": 40_000})
    assert bench.control("EN", "DN", "ER", "POS") == (1, 0, 1, 1)
    assert bench.list("Queue", 3) == [0, 40_000 - 65_536, 0]
    bench.scan(**{"Table[1]": 4})
    assert bench.control("ER", "POS") == (1, 1)
    bench.scan(**{"C.ER": False})
    assert bench.control("DN", "ER", "POS") == (1, 0, 3)
    assert bench.list("Queue", 3) == [0, 4, 22]


@pytest.mark.parametrize(("number", "state"), [("0", (0, 1, 6)), ("1", (1, 0, 0))])
def test_fsc_with_a_number_for_a_condition_finds_nothing_or_the_first_element(number, state):
    bench = Both(f"XIC(Go)FSC(C,6,0,ALL,{number});", f"CMP({number})OTE(Yes);")
    bench.scan(Go=True)
    assert bench.control("FD", "DN", "POS") == state
    assert bool(bench.tags["Yes"]) == (number == "1")


def test_a_position_behind_the_array_is_a_major_fault():
    bench = Both("FAL(C,7,0,ALL,Copy[C.POS],Data[C.POS]);")
    with pytest.raises(LadderFault, match="type 4 code 20") as error:
        bench.scan()
    assert error.value.code == 20


@pytest.mark.parametrize("member", ["LEN", "POS"])
@pytest.mark.parametrize("rung", ["FAL(C,?,?,INC,D,1);", "FFL(D,Queue,C,?,?);", "FFU(Queue,D,C,?,?);"])
def test_a_negative_length_or_position_is_a_major_fault(rung, member):
    bench = Both(rung)
    with pytest.raises(LadderFault, match="type 4 code 21"):
        bench.scan(**{f"C.{member}": -1, "C.EN": False})


def test_a_file_instruction_without_end_meets_the_watchdog(monkeypatch):
    monkeypatch.setattr(fault_log, "MOST_JUMPS", 100)
    with pytest.raises(LadderFault, match="type 6 code 1"):
        Both("FAL(C,2000000000,0,ALL,D,1);").scan()


def test_fsc_finds_one_element_after_another():
    bench = Both("XIC(Go)FSC(C,6,0,ALL,Data[C.POS]>3);")
    bench.scan(Go=True)
    assert bench.control("EN", "FD", "IN", "DN", "POS") == (1, 1, 1, 0, 0)
    bench.scan(Go=True)
    assert bench.control("FD", "POS") == (1, 0)  # IN inhibits
    places = []
    for _ in range(3):
        bench.scan(Go=True, **{"C.IN": False})
        places.append(bench.control("FD", "DN", "POS"))
    assert places == [(1, 0, 2), (1, 0, 5), (0, 1, 6)]
    bench.scan(Go=False)
    assert bench.control("EN", "FD", "DN", "POS") == (0, 0, 0, 0)


def test_fsc_starts_anew_after_a_false_rung():
    bench = Both("XIC(Go)FSC(C,6,0,ALL,Data[C.POS]=4);")
    bench.scan(Go=True)
    assert bench.control("FD", "IN", "POS") == (1, 1, 2)
    bench.scan(Go=False)
    assert bench.control("EN", "FD", "IN") == (0, 0, 0)
    bench.scan(Go=True)
    assert bench.control("FD", "POS") == (1, 2)


# --- SIZE, AVE, SRT, STD


@pytest.mark.parametrize(
    ("source", "dimension", "wanted"),
    [("Data", 0, 6), ("Data[2]", 0, 6), ("Grid[0,0]", 0, 2), ("Grid", 1, 3), ("Stack", 0, 3)],
)
def test_size_of_a_dimension(source, dimension, wanted):
    assert wanted == Both(f"SIZE({source},{dimension},N);").scan().tags.N


def test_ave_rm003_p382():
    bench = Both("XIC(Go)AVE(Data[0],0,R,C,4,0);").scan(Go=True)
    assert bench.tags.R == 3.0  # (5 + 1 + 4 + 2) / 4
    assert bench.control("EN", "DN", "ER", "POS") == (1, 1, 0, 4)
    bench.scan(Go=False)
    assert bench.control("EN", "DN", "POS") == (0, 0, 0)


@pytest.mark.parametrize(
    ("rung", "wanted"),
    [
        ("AVE(Grid[1,0],1,R,C,3,0);", 50.0),  # 40, 60, 50
        ("AVE(Grid[0,1],0,R,C,2,0);", 31.0),  # 2, 60
        ("STD(Grid[1,0],1,R,C,3,0);", 10.0),  # sqrt((100 + 100 + 0) / 2), p. 392
        ("AVE(Data[4],0,R,C,2,0);", 6.0),
    ],
)
def test_one_dimension_from_the_named_element_on_rm003_p392(rung, wanted):
    assert wanted == Both(rung).scan().tags.R


def test_an_average_is_rounded_into_an_integer():
    assert Both("AVE(Data[1],0,D,C,2,0);").scan().tags.D == 2  # 2.5, half to even


@pytest.mark.parametrize("rung", ["AVE(Data,0,R,C,0,0);", "STD(Data,0,R,C,1,0);"])
def test_a_statistic_of_too_few_values_is_an_error(rung):
    bench = Both(rung).scan(R=7.0)
    assert bench.control("DN", "ER") == (0, 1)
    assert bench.tags.R == 7.0
    assert [(fault.type, fault.code) for fault in bench.engines[0].minor_faults] == [(4, 4)]


def test_a_length_beyond_the_dimension_is_a_major_fault():
    with pytest.raises(LadderFault, match="type 4 code 20"):
        Both("AVE(Grid[0,1],1,R,C,3,0);").scan()


def test_srt_sorts_in_ascending_order():
    assert Both("SRT(Data,0,C,5,0);").scan().list("Data", 6) == [1, 2, 3, 4, 5, 9]
    bench = Both("SRT(Grid[1,0],1,C,3,0);").scan()
    assert [bench.tags[f"Grid[1,{each}]"] for each in range(3)] == [40, 50, 60]


# --- BSL, BSR


def test_bsl_shifts_toward_the_high_end():
    bench = Both("XIC(Go)BSL(Bits,C,Bit,34);").scan(Go=True, Bit=True, **{"Bits[0]": -(2**31), "Bits[1]": 2})
    assert bench.list("Bits", 2) == [1, 5]  # bit 31 to bit 32, bit 33 out
    assert bench.control("EN", "DN", "UL", "POS") == (1, 1, 1, 34)
    assert bench.scan(Go=True).list("Bits", 2) == [1, 5]
    bench.scan(Go=False)
    assert bench.control("EN", "DN", "POS") == (0, 0, 0)


def test_bsr_shifts_toward_the_low_end():
    bench = Both("XIC(Go)BSR(Bits,C,Bit,34);").scan(Go=True, Bit=True, **{"Bits[0]": 3, "Bits[1]": 1})
    assert bench.list("Bits", 2) == [1 - 2**31, 2]
    assert bench.control("UL", "DN") == (1, 1)


def test_a_shift_of_negative_length_is_an_error():
    bench = Both("BSL(Bits,C,Bit,?);").scan(**{"C.LEN": -1})
    assert bench.control("ER", "DN") == (1, 0)


# --- FFL, FFU, LFL, LFU


def test_a_queue_first_in_first_out():
    bench = Both("XIC(Go)FFL(D,Queue,C,3,0);", "XIC(Bit)FFU(Queue,N,C,3,0);").scan()
    for value in (7, 8, 9, 10):
        bench.pulse(D=value)
    assert bench.list("Queue", 4) == [7, 8, 9, 0]
    assert bench.control("DN", "EM", "POS") == (1, 0, 3)
    taken = []
    for _ in range(4):
        bench.scan(Bit=True).scan(Bit=False)
        taken.append((bench.tags.N, *bench.control("DN", "EM", "POS")))
    assert taken == [(7, 0, 0, 2), (8, 0, 0, 1), (9, 0, 1, 0), (0, 0, 1, 0)]
    assert bench.list("Queue", 4) == [0, 0, 0, 0]


def test_a_stack_last_in_first_out():
    bench = Both("XIC(Go)LFL(D,Queue,C,3,0);", "XIC(Bit)LFU(Queue,N,C,3,0);").scan()
    for value in (7, 8):
        bench.pulse(D=value)
    taken = []
    for _ in range(3):
        bench.scan(Bit=True).scan(Bit=False)
        taken.append((bench.tags.N, bench.list("Queue", 2), *bench.control("EM", "POS")))
    assert taken == [(8, [7, 0], 0, 1), (7, [0, 0], 1, 0), (0, [0, 0], 1, 0)]


@pytest.mark.parametrize("rung", ["FFL(D,Queue,C,3,0);", "LFL(D,Queue,C,3,0);"])
def test_a_rung_that_is_true_at_power_up_loads_nothing(rung):
    """Prescan sets .EN."""
    assert Both(rung).scan(D=7).control("EN", "POS", "EM") == (1, 0, 1)


def test_a_queue_of_structures():
    bench = Both("XIC(Go)FFL(One,Stack,C,3,0);", "XIC(Bit)FFU(Stack,Two,C,3,0);").scan()
    bench.pulse()
    bench.scan(Bit=True)
    assert (bench.tags["Two.Size"], bench.tags["Two.Good"], bench.tags["Two.Weight"]) == (3, True, 1.5)
    assert bench.tags["Stack[0].Size"] == 0


def test_an_lreal_keeps_its_precision_in_a_queue():
    bench = Both("XIC(Go)FFL(Fine,Fines,C,3,0);", "XIC(Bit)LFU(Fines,Fine,C,3,0);").scan()
    bench.pulse(Fine=0.1)
    bench.scan(Bit=True, Fine=0.0)
    assert bench.tags.Fine == 0.1


def test_a_queue_converts_what_it_takes():
    bench = Both("XIC(Go)FFL(R,Queue,C,3,0);", "XIC(Bit)FFU(Queue,R,C,3,0);").scan()
    bench.pulse(R=2.5)
    bench.scan(Bit=True, R=0.0)
    assert bench.tags.R == 2.0


def test_a_queue_shorter_than_its_length_is_a_major_fault():
    bench = Both("XIC(Go)FFL(D,Queue,C,6,4);").scan(Go=False)
    with pytest.raises(LadderFault, match="type 4 code 20"):
        bench.scan(Go=True)


# --- SQI, SQO, SQL


def test_sqo_rm003_p442():
    """A step per transition; the masked bits are written while the rung is true; step 1 follows the last."""
    bench = Both("XIC(Go)SQO(Table,16#0F,D,C,2,0);").scan(Go=False)
    seen = []
    for _ in range(3):
        bench.scan(Go=True, D=0x70).scan(Go=True)
        seen.append((bench.tags.D, *bench.control("DN", "POS")))
        bench.scan(Go=False)
    assert seen == [(0x7B, 0, 1), (0x76, 1, 2), (0x7B, 0, 1)]


def test_sqo_does_not_step_at_power_up_rm003_p442():
    bench = Both("SQO(Table,-1,D,C,2,0);").scan(D=9)
    assert (bench.tags.D, *bench.control("EN", "POS")) == (0, 1, 0)


@pytest.mark.parametrize(
    "rung", ["SQO(Table,-1,D,C,0,0);", "SQL(Table,D,C,0,0);", "SQI(Table,-1,D,C,0,0)OTE(Yes);"]
)
def test_a_sequencer_without_length_is_an_error_rm003_p438_p442_p446(rung):
    bench = Both(rung).scan(D=5)
    assert bench.control("ER") == (1,)
    assert (bench.tags.D, bench.tags.Yes) == (5, False)


@pytest.mark.parametrize(("source", "position", "wanted"), [(0x1B, 1, 1), (0x16, 1, 0), (0x16, 2, 1)])
def test_sqi_rm003_p438(source, position, wanted):
    bench = Both("SQI(Table,16#0F,D,C,2,?)OTE(Yes);").scan(D=source, **{"C.POS": position})
    assert bench.tags.Yes == wanted


def test_sql_rm003_p446():
    bench = Both("XIC(Go)SQL(Table,D,C,2,0);").scan()
    for value in (100, 200, 300):
        bench.pulse(D=value)
    assert bench.list("Table", 4) == [0, 300, 200, 33]
    assert bench.control("DN", "POS") == (0, 1)


# --- FOR, BRK


def test_for_calls_a_routine_for_every_count():
    """6 down to 1, and the index is one step further in the end."""
    bench = Both("XIC(Go)FOR(Sub,Index,6,1,-1);", sub="ADD(Sum,Index,Sum);").scan(Go=True)
    assert (bench.tags.Sum, bench.tags.Index) == (21, 0)
    assert bench.scan(Go=False).tags.Sum == 21


def test_for_does_nothing_beyond_its_terminal_value():
    bench = Both("FOR(Sub,Index,3,2,By);", sub="ADD(Sum,1,Sum);").scan(Index=9)
    assert (bench.tags.Sum, bench.tags.Index) == (0, 3)


def test_brk_ends_the_innermost_for():
    bench = Both("FOR(Sub,Index,0,9,1)ADD(D,1,D);", sub="ADD(Sum,1,Sum)EQU(Index,4)BRK()ADD(Sum,100,Sum);")
    bench.scan()
    assert (bench.tags.Sum, bench.tags.Index, bench.tags.D) == (5, 4, 1)


def test_for_without_end_meets_the_watchdog(monkeypatch):
    monkeypatch.setattr(fault_log, "MOST_JUMPS", 100)
    with pytest.raises(LadderFault, match="type 6 code 1"):
        Both("FOR(Sub,Index,0,9,By);", sub="NOP();").scan(By=0)
