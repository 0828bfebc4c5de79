"""String instructions row by row; ids name the page (RM003 = 1756-RM003N)."""

import pytest
from ladder_bench import both

TAGS = """TAG A : STRING := "first"
TAG B : STRING := "second"
TAG To : STRING := "stays"
TAG Lines : STRING[3] := ["one", "two", "three"]
TAG N : DINT := 7
TAG S : SINT := 7
TAG R : REAL := 7.0
TAG Go : BOOL := true
TAG Zero : BOOL
TAG Carry : BOOL
"""


def after(*rungs, **values):
    """Run the rungs once on both back ends, with these values; return what both come to."""
    engines = both(TAGS, *rungs)
    for engine in engines:
        for name, value in values.items():
            engine.tags[name] = value
        engine.step()
    compiled, interpreted = engines
    assert compiled.memory.snapshot() == interpreted.memory.snapshot()
    faults = [list(map(str, engine.minor_faults)) for engine in engines]
    assert faults[0] == faults[1]
    return compiled


def codes(engine):
    return [(fault.type, fault.code) for fault in engine.minor_faults]


def test_concat_rm003_p610():
    engine = after("CONCAT(A,B,To)CONCAT(A,'$0D',A);")
    assert (engine.tags.To, engine.tags.A) == ("firstsecond", "first\r")
    assert engine.tags["To.LEN"] == 11
    assert codes(engine) == []


def test_concat_of_too_many_characters_rm003_p610():
    """Fault 4/51; what fits, 82 characters, is there."""
    engine = after("CONCAT(A,B,To);", A="a" * 80, B="bcde")
    assert engine.tags.To == "a" * 80 + "bc"
    assert codes(engine) == [(4, 51)]


def test_a_length_above_the_size_of_data_rm003_p610():
    engine = after("MOV(83,A.LEN)CONCAT(B,A,To);")
    assert engine.tags.To == "stays"
    assert codes(engine) == [(4, 51)]
    assert engine.tags["S:MINOR"] is True


def test_a_false_rung_does_nothing():
    engine = after("XIC(Go)CONCAT(A,B,To)UPPER(A,A)STOD(B,N);", Go=False)
    assert (engine.tags.To, engine.tags.A, engine.tags.N) == ("stays", "first", 7)


@pytest.mark.parametrize(
    ("quantity", "start", "wanted"),
    [(3, 1, "sec"), (3, 4, "ond"), (0, 2, ""), (6, 1, "second")],
)
def test_mid_rm003_p618(quantity, start, wanted):
    engine = after(f"MID(B,{quantity},{start},To);")
    assert engine.tags.To == wanted
    assert codes(engine) == []


@pytest.mark.parametrize(("quantity", "start"), [(1, 0), (-1, 1), (1, 7), (4, 4), (1, -2)])
@pytest.mark.parametrize("name", ["MID", "DELETE"])
def test_a_part_that_is_not_inside_rm003_p618(name, quantity, start):
    """Fault 4/56; the destination stays."""
    engine = after(f"{name}(B,{quantity},{start},To);")
    assert engine.tags.To == "stays"
    assert codes(engine) == [(4, 56)]


def test_delete_takes_a_part_out():
    assert after("DELETE(B,2,3,To);").tags.To == "send"


@pytest.mark.parametrize(
    ("search", "start", "wanted"), [("'o'", 1, 4), ("'ond'", 1, 4), ("'o'", 5, 0), ("'x'", 1, 0), ("B", 1, 1)]
)
def test_find_rm003_p614(search, start, wanted):
    engine = after(f"FIND(B,{search},{start},N);")
    assert wanted == engine.tags.N
    assert codes(engine) == []


@pytest.mark.parametrize(("source", "start"), [("second", 0), ("second", 7), ("", 1)])
def test_find_from_a_wrong_start_rm003_p614(source, start):
    engine = after(f"FIND(B,'o',{start},N);", B=source)
    assert engine.tags.N == 7
    assert codes(engine) == [(4, 56)]


@pytest.mark.parametrize(("start", "wanted"), [(1, "firstsecond"), (4, "secfirstond"), (7, "secondfirst")])
def test_insert_places_one_string_in_another(start, wanted):
    assert after(f"INSERT(B,A,{start},To);").tags.To == wanted


@pytest.mark.parametrize("start", [0, 8])
def test_insert_outside_of_the_string(start):
    engine = after(f"INSERT(B,A,{start},To);")
    assert engine.tags.To == "stays"
    assert codes(engine) == [(4, 56)]


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("\x06324\\12\\1\\\r", 324),  # the example of p. 624
        ("-12", -12),
        ("abc", 0),
        ("12.9", 12),
        ("a-b5", 5),
        ("", 7),
    ],
)
def test_stod_rm003_p624(text, wanted):
    """The first group of digits counts; an empty string leaves the destination as it is."""
    engine = after("STOD(A,N);", A=text)
    assert wanted == engine.tags.N
    assert codes(engine) == []


def test_stod_sets_carry_and_tells_zero_rm003_p624():
    engine = after("STOD(A,N)XIC(S:Z)OTE(Zero);", "XIC(S:C)OTE(Carry);", A="000")
    assert (engine.tags.Zero, engine.tags.Carry) == (True, True)


def test_a_number_beyond_its_destination_rm003_p623():
    engine = after("STOD(A,S);", A="300")
    assert engine.tags.S == 44  # 300 - 256
    assert codes(engine) == [(4, 53)]


@pytest.mark.parametrize(
    ("text", "wanted"), [("temp 15.25 C", 15.25), ("-.5", -0.5), ("1.5e2,7", 150.0), ("8", 8.0), ("x", 0.0)]
)
def test_stor_takes_the_first_number(text, wanted):
    assert wanted == after("STOR(A,R);", A=text).tags.R


@pytest.mark.parametrize(("value", "wanted"), [(0, "0"), (-12, "-12"), (2_147_483_647, "2147483647")])
def test_dtos_writes_the_digits(value, wanted):
    assert after("DTOS(N,To);", N=value).tags.To == wanted


@pytest.mark.parametrize(
    ("value", "wanted"),
    [
        (15.3001, "15.3001003"),  # the single nearest to 15.3001 is 15.30010032653808...
        (0.5, "0.5"),
        (-2.0, "-2.0"),
        (float("inf"), "1.$"),
    ],
)
def test_rtos_rm003_p629(value, wanted):
    assert after("RTOS(R,To);", R=value).tags.To == wanted


def test_upper_and_lower_leave_other_signs_alone():
    engine = after("UPPER(A,To)LOWER(B,B);", A="aZ9{", B="Qy[")
    assert (engine.tags.To, engine.tags.B) == ("AZ9{", "qy[")


def test_strings_of_an_array_by_a_computed_subscript():
    engine = after("CONCAT(Lines[N],Lines[0],Lines[N-1]);", N=2)
    assert [engine.tags[f"Lines[{each}]"] for each in range(3)] == ["one", "threeone", "three"]
