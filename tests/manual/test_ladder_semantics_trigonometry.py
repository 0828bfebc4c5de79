"""Trigonometric and advanced math instructions; ids name the page (RM003 = 1756-RM003N)."""

import math

import pytest
from ladder_bench import both

TAGS = "TAG R : REAL\nTAG Q : REAL := 1.0\nTAG D : DINT\nTAG Over : BOOL\n"
SINGLE_HALF_PI = 13_176_795 / 2**23
"""The single nearest to pi/2: pi/2 * 2^23 = 13,176,794.6..."""


def after(*rungs, **values):
    engines = both(TAGS, *rungs)
    for engine in engines:
        for name, value in values.items():
            engine.tags[name] = value
        engine.step()
    compiled, interpreted = (engine.tags for engine in engines)
    for name in compiled:
        assert compiled[name] == interpreted[name] or math.isnan(compiled[name])
    assert list(map(str, engines[0].minor_faults)) == list(map(str, engines[1].minor_faults))
    return engines[0]


@pytest.mark.parametrize(
    ("name", "source", "wanted"),
    [
        ("SIN", SINGLE_HALF_PI, 1.0),
        ("COS", 0.0, 1.0),
        ("TAN", 0.0, 0.0),
        ("ASN", 1.0, SINGLE_HALF_PI),
        ("ASIN", 1.0, SINGLE_HALF_PI),
        ("ACS", 1.0, 0.0),
        ("ACOS", 0.0, SINGLE_HALF_PI),
        ("ATN", math.inf, SINGLE_HALF_PI),
        ("ATAN", 0.0, 0.0),
        ("LN", 1.0, 0.0),
        ("LOG", 1000.0, 3.0),
        ("DEG", SINGLE_HALF_PI, 90.0),
        ("RAD", 90.0, SINGLE_HALF_PI),
    ],
)
def test_functions_as_instructions_and_in_expressions(name, source, wanted):
    assert wanted == after(f"{name}(R,Q);", R=source).tags.Q
    assert wanted == after(f"CPT(Q,0.0+{name}(R));", R=source).tags.Q


def test_an_integer_is_computed_as_real_and_rounded():
    """cos 1 is 0.54, which is 1 in a DINT; 2 * sin 1 is 1.68, and 2."""
    assert after("COS(D,D);", D=1).tags.D == 1
    assert after("CPT(D,2*SIN(D));", D=1).tags.D == 2


def test_xpy_raises_x_to_y():
    assert after("XPY(R,3,Q);", R=1.5).tags.Q == 3.375
    assert after("EXPT(2,10,D);").tags.D == 1024


@pytest.mark.parametrize(
    ("rung", "source", "wanted"),
    [
        ("ASN(R,Q)", 1.5, math.nan),
        ("ACS(R,Q)", -2.0, math.nan),
        ("LN(R,Q)", 0.0, -math.inf),
        ("LOG(R,Q)", -1.0, math.nan),
    ],
)
def test_a_source_without_a_result_overflows(rung, source, wanted):
    engine = after(f"{rung}XIC(S:V)OTE(Over);", R=source)
    assert wanted == engine.tags.Q or (math.isnan(engine.tags.Q) and math.isnan(wanted))
    assert engine.tags.Over is True
    assert [(fault.type, fault.code) for fault in engine.minor_faults] == [(4, 4)]
