"""Diagrams of drives, curves and pulses on both back ends, with values by hand [1756-RM006K]."""

import math

import pytest
from diagram_runs import around, follow, open_diagram

FIRST = 1  # InstructFault


@pytest.fixture
def run(tmp_path):
    """Runs a diagram in a task of `rate` ms, 0 for a continuous one of 1 s scans, and checks each scan."""

    def run_(diagram, tags, rate, *scans):
        follow(open_diagram(tmp_path / "machine.L5X", diagram, tags, rate=rate), *scans, ms=rate or 1000)

    return run_


def test_pi_in_linear_mode(run):
    """p. 274: I + 2 x 0.5 (In + In before)/2, PTerm 2 In; the first scan starts at 0 [p. 303].

    4: 2 + 8; 4: 6 + 8; 4: 10 + 8, above 15: 15, and I stays 6; -2: 6 + 1 - 4 = 3; 2: 7 + 0 + 4 = 11;
    2 with HoldHigh: 7 + 4, not 9 + 4; InitialValue 20 is limited to 15; limits crossed: LowLimit.
    """
    diagram = around("PI", "Loop", {"In": "E", "Kp": "2", "Wld": "0.5", "HighLimit": "15"}, {"Out": "Out"})
    run(
        diagram,
        {"PROP_INT": "Loop", "REAL": "E Out"},
        1000,
        ({"E": 4}, {"Out": 10, "Loop.DeltaT": 1, "Loop.Status": 0}),
        ({}, {"Out": 14, "Loop.HighAlarm": False}),
        ({}, {"Out": 15, "Loop.HighAlarm": True, "Loop.LowAlarm": False}),
        ({"E": -2}, {"Out": 3, "Loop.HighAlarm": False}),
        ({"E": 2}, {"Out": 11}),
        ({"Loop.HoldHigh": True}, {"Out": 11}),
        ({"Loop.HoldHigh": False}, {"Out": 13}),
        ({"Loop.Initialize": True, "Loop.InitialValue": 20.0}, {"Out": 15}),
        (
            {"Loop.Initialize": False, "Loop.LowLimit": 15.0},
            {"Out": 15, "Loop.HighAlarm": True, "Loop.LowAlarm": True, "Loop.Status": FIRST | 1 << 3},
        ),
    )


def test_pi_in_non_linear_mode(run):
    """Kp ((Shape - 1) r + 1), with r = |In|/10 and its square; Wld 1, and I + Kp Wld (In + In before)/2.

    5: Kp 2: 5 + 10; -20: r 1, Kp 0.5: 5 - 3.75 - 10 = -8.75; 5, squared: Kp 1.5: 1.25 - 11.25 + 7.5 = -2.5;
    10, shape 20 is limited to 10: Kp 10: -10 + 75 + 100; 10, Wld shaped by 2: 65 + 20 + 10.
    """
    pins = {"In": "E", "Kp": "1", "Wld": "1", "KpInRange": "10", "ShapeKpPlus": "Plus", "ShapeKpMinus": "0.5"}
    diagram = around("PI", "Loop", {**pins, "NonLinearMode": "1"}, {"Out": "Out"})
    run(
        diagram,
        {"PROP_INT": "Loop", "REAL": "E Plus Out"},
        1000,
        ({"E": 5, "Plus": 3}, {"Out": 15, "Loop.Status": 0}),
        ({"E": -20}, {"Out": -8.75}),
        ({"E": 5, "Loop.ParabolicLinear": True}, {"Out": -2.5}),
        ({"E": 10, "Plus": 20}, {"Out": 165, "Loop.Status": FIRST | 1 << 4}),
        ({"Plus": 1, "Loop.ShapeWldPlus": 2.0, "Loop.WldInRange": 10.0}, {"Out": 95, "Loop.Status": 0}),
        ({"E": math.inf}, {"Out": math.inf, "Loop.EnableOut": False}),
        ({"E": -10}, {"Out": 80, "Loop.EnableOut": True}),
    )


def test_soc(run):
    """2 (1 + s + s^2)/(s (1 + s)) with 1 s: 2/s + 2 s/(1 + s), as the sum of x + x before and y.

    s = 2 (1 - z)/(1 + z): y = (4 (x - x before) + y before)/3. 3: 3 + 4; 3: 9 + 4/3; 0: 12 - 32/9;
    ZetaLead 11 is limited to 10: a = 19, y = -32/27.
    """
    pins = {"In": "E", "Gain": "2", "WLag": "1", "WLead": "1", "ZetaLead": "0.5"}
    diagram = around("SOC", "Loop", pins, {"Out": "Out"})
    run(
        diagram,
        {"SEC_ORDER_CONTROLLER": "Loop", "REAL": "E Out"},
        1000,
        ({"E": 3}, {"Out": 7, "Loop.Status": 0}),
        ({}, {"Out": 10.333333}),
        ({"E": 0}, {"Out": 8.444444}),
        ({}, {"Out": 10.814815}),
        ({"Loop.HighLimit": 10.0}, {"Out": 10, "Loop.HighAlarm": True}),
        ({"Loop.Initialize": True, "Loop.InitialValue": -4.0, "E": 1}, {"Out": -4}),
        ({"Loop.Initialize": False}, {"Out": -2}),
    )


def test_soc_refuses_what_is_out_of_range(run):
    """p. 302: ZetaLead up to 10; a frequency of 0 is limited; x 2, x before 0, WLag and WLead 1, a = 20 - 1.

    y = (2 (19 + 2) + 0)/3 = 14, the integral 1.
    """
    pins = {"In": "2", "Gain": "1", "WLag": "1", "WLead": "1", "ZetaLead": "11"}
    diagram = around("SOC", "Loop", pins, {"Out": "Out"})
    tags = {"SEC_ORDER_CONTROLLER": "Loop", "REAL": "Out"}
    scans = [
        ({}, {"Out": 15, "Loop.Status": FIRST | 1 << 4}),
        ({"Loop.HoldHigh": True}, {"Loop.ZetaLeadInv": True}),
    ]
    run(diagram, tags, 1000, *scans)


def test_pmul(run):
    """p. 284: sum = change x 50000 + remainder, Out = sum/100000, with a word of 4 bits.

    3 to 6: 150000: 1, rest 50000; 7: 100000: 1; -7 is 9: 100000: 1; -8: -50000: 0; -9: -100000: -1. Absolute
    5: 250000, then 300000. From InitialValue 2 to 5: 150000. 2,000,000 is limited: 1,050,000. 10 x (2^31 - 1)
    does not fit, and a REAL has 24 bits.
    """
    diagram = around("PMUL", "Count", {"In": "At", "WordSize": "4", "Multiplier": "Parts"}, {"Out": "Out"})
    run(
        diagram,
        {"PULSE_MULTIPLIER": "Count", "DINT": "At Parts", "REAL": "Out"},
        0,
        ({"At": 3, "Parts": 50_000}, {"Out": 0, "Count.Status": 0}),
        ({"At": 6}, {"Out": 1}),
        ({"At": 7}, {"Out": 1}),
        ({"At": -7}, {"Out": 1}),
        ({"At": -8}, {"Out": 0}),
        ({"At": -9}, {"Out": -1}),
        ({"At": 5, "Count.Mode": False}, {"Out": 2}),
        ({}, {"Out": 3}),
        ({"Count.Initialize": True, "Count.InitialValue": 2, "Count.Mode": True}, {"Out": 0}),
        ({"Count.Initialize": False}, {"Out": 1}),
        ({"At": 6, "Parts": 2_000_000}, {"Out": 10, "Count.Status": FIRST | 1 << 4}),
        (
            {"At": 2_147_483_647, "Count.Mode": False},
            {"Out": 2_147_483_647, "Count.OutOverflow": True, "Count.LostPrecision": True},
        ),
    )


UP = {"AccelRate": "2", "DecelRate": "4", "JerkRate": "Jerk", "In": "Goal"}


def test_scrv_as_an_s(run):
    """Rates 0, 1, 2, 2, 2, 1, 0 with a jerk of 1: Out is the sum of their means, 0.5, 1.5, 2, 2, 1.5, 0.5.

    For 0.6 the rate r has r/2 + r^2/2 = 0.6: 1.204160 - 0.5; the next step arrives.
    """
    diagram = around("SCRV", "Ramp", UP, {"Out": "Out", "Rate": "Rate"})
    run(
        diagram,
        {"S_CURVE": "Ramp", "REAL": "Goal Jerk Out Rate"},
        1000,
        ({"Goal": 8, "Jerk": 1}, {"Out": 0.5, "Rate": 1, "Ramp.S_Mode": True}),
        ({}, {"Out": 2, "Rate": 2, "Ramp.S_Mode": False}),
        ({}, {"Out": 4, "Rate": 2}),
        ({}, {"Out": 6, "Rate": 2}),
        ({}, {"Out": 7.5, "Rate": 1}),
        ({}, {"Out": 8, "Rate": 0, "Ramp.Status": 0}),
        ({}, {"Out": 8, "Rate": 0}),
        ({"Goal": 8.6}, {"Out": 8.352080, "Rate": 0.704160}),
        ({}, {"Out": 8.6, "Rate": 0}),
    )


def test_scrv_held_by_jerk_and_at_once(run):
    """HoldEnable takes the rate from 2 to 0 by 1 a scan; with HoldMode at once."""
    diagram = around("SCRV", "Ramp", UP, {"Out": "Out", "Rate": "Rate"})
    run(
        diagram,
        {"S_CURVE": "Ramp", "REAL": "Goal Jerk Out Rate"},
        1000,
        ({"Goal": 100, "Jerk": 1}, {"Out": 0.5}),
        ({}, {"Out": 2, "Rate": 2}),
        ({"Ramp.HoldEnable": True}, {"Out": 3.5, "Rate": 1}),
        ({}, {"Out": 4, "Rate": 0}),
        ({}, {"Out": 4, "Rate": 0}),
        ({"Ramp.HoldEnable": False}, {"Out": 4.5, "Rate": 1}),
        ({"Ramp.HoldEnable": True, "Ramp.HoldMode": True}, {"Out": 4.5, "Rate": 0}),
    )


def test_scrv_as_a_ramp(run):
    """A jerk above the rates: 4 per second toward 0 and 2 away from it; algebraic 4 down, 2 up."""
    diagram = around("SCRV", "Ramp", UP, {"Out": "Out", "Rate": "Rate"})
    run(
        diagram,
        {"S_CURVE": "Ramp", "REAL": "Goal Jerk Out Rate"},
        1000,
        ({"Goal": -3, "Jerk": 100, "Ramp.Initialize": True, "Ramp.InitialValue": 8.0}, {"Out": 8, "Rate": 0}),
        ({"Ramp.Initialize": False}, {"Out": 4, "Rate": -4, "Ramp.S_Mode": False}),
        ({}, {"Out": 0, "Rate": -4}),
        ({}, {"Out": -2, "Rate": -2}),
        ({}, {"Out": -3, "Rate": 0}),
        ({"Ramp.AbsAlgRamp": False, "Goal": -9}, {"Out": -7, "Rate": -4}),
        ({"Goal": 0}, {"Out": -5, "Rate": 2}),
        ({}, {"Out": -3, "Ramp.Status": 0}),
        ({"Jerk": -1}, {"Out": -3, "Rate": 0, "Ramp.Status": FIRST | 1 << 3}),
    )


def test_ldl2_of_order_2(run):
    """(1 + s/2)^2/(1 + s)^2 with 1 s: Out = (4 In + 6 Out before - Out before that)/9 [p. 343-345].

    9: 4; (36 + 24)/9 = 6.666667; (36 + 40 - 4)/9 = 8. After an infinite In it starts again at In.
    """
    pins = {"In": "In", "WLead": "2", "WLag": "1", "ZetaLead": "1", "ZetaLag": "1"}
    diagram = around("LDL2", "Filter", pins, {"Out": "Out"})
    run(
        diagram,
        {"LEAD_LAG_SEC_ORDER": "Filter", "REAL": "In Out"},
        1000,
        ({}, {"Out": 0, "Filter.Status": 0}),
        ({"In": 9}, {"Out": 4}),
        ({}, {"Out": 6.666667}),
        ({}, {"Out": 8}),
        ({"In": math.inf}, {"Out": math.inf, "Filter.EnableOut": False}),
        ({"In": 5}, {"Out": 5, "Filter.EnableOut": True}),
        ({"Filter.Order": 7}, {"Out": 5, "Filter.Status": FIRST | 1 << 5}),
    )


def test_ldl2_of_order_1_limits_the_ratio_of_its_frequencies(run):
    """WLag 2 is limited to 40 x 0.025: (1 + 40 s)/(1 + s): Out = (81 In - 79 In before + Out before)/3.

    81; (243 - 237 + 81)/3; 27 x 3E38 is no REAL, and the next call starts again; (729 - 474 + 6)/3.
    """
    pins = {"In": "In", "WLead": "0.025", "WLag": "2", "Order": "1"}
    diagram = around("LDL2", "Filter", pins, {"Out": "Out"})
    run(
        diagram,
        {"LEAD_LAG_SEC_ORDER": "Filter", "REAL": "In Out"},
        1000,
        ({}, {"Out": 0, "Filter.Status": FIRST | 1 << 6}),
        ({"In": 3}, {"Out": 81}),
        ({}, {"Out": 29}),
        ({"In": 3e38}, {"Out": math.inf, "Filter.EnableOut": False}),
        ({"In": 6}, {"Out": 6, "Filter.EnableOut": True}),
        ({"In": 9}, {"Out": 87}),
        ({"Filter.Initialize": True}, {"Out": 9}),
    )


def test_a_low_pass_filter_of_an_invalid_order_is_of_order_1(run):
    """1/(1 + s) with 1 s: Out = (In + In before + Out before)/3; 3: 1, then 7/3; 5 after an infinite In."""
    diagram = around("LPF", "Filter", {"In": "In", "WLag": "1", "Order": "9"}, {"Out": "Out"})
    run(
        diagram,
        {"FILTER_LOW_PASS": "Filter", "REAL": "In Out"},
        1000,
        ({}, {"Out": 0, "Filter.Status": FIRST | 1 << 2}),
        ({"In": 3}, {"Out": 1}),
        ({}, {"Out": 2.333333}),
        ({"In": math.inf}, {"Out": math.inf}),
        ({"In": 5}, {"Out": 5}),
        ({}, {"Out": 5}),
    )


def test_posp(run):
    """p. 106-108: 50 % and 30 % at 10 %/s are 2 s, and 0.25 s of Deadtime; MaxOnTime 3, MinOnTime 0.5.

    49 %: 0.1 + 0.25 s is too short; 70 % closes at 20 %/s: 1 + 0.25 s; 100 % from 0 %: 10 s, limited to 3.
    """
    rates = {"CycleTime": "4", "OpenRate": "10", "CloseRate": "20", "MaxOnTime": "3", "MinOnTime": "0.5"}
    pins = {"SP": "SP", "Position": "At", "PositionEUMax": "200", "Deadtime": "0.25", **rates}
    diagram = around("POSP", "Valve", pins, {"OpenOut": "Open", "CloseOut": "Close"})
    off = {"Open": False, "Close": False}
    opens, closes = {"Open": True, "Close": False}, {"Open": False, "Close": True}
    run(
        diagram,
        {"POSITION_PROP": "Valve", "REAL": "SP At", "BOOL": "Open Close"},
        0,
        ({"SP": 100, "At": 60}, {**off, "Valve.SPPercent": 50, "Valve.PositionPercent": 30}),
        *[({}, off)] * 3,
        ({}, {**opens, "Valve.OpenTime": 2.25, "Valve.CloseTime": 0}),
        ({}, opens),
        ({}, opens),
        ({"At": 98}, {**off, "Valve.OpenTime": 2.25}),
        ({}, {**off, "Valve.OpenTime": 0}),
        *[({"At": 140}, off)] * 3,
        ({}, {**closes, "Valve.CloseTime": 1.25, "Valve.OpenTime": 0}),
        ({}, closes),
        ({}, off),
        ({"At": 0, "SP": 200}, off),
        ({}, {**opens, "Valve.OpenTime": 3}),
        ({"Valve.OpenedFB": True}, {**off, "Valve.OpenTime": 0}),
        ({"Valve.OpenedFB": False}, off),
        ({"SP": 300}, {**off, "Valve.Status": FIRST | 1 << 8}),
        ({"SP": 200}, {**opens, "Valve.Status": 0}),
    )


def test_posp_takes_its_limits_for_invalid_times(run):
    """MaxOnTime above CycleTime is CycleTime, 2 s; 100 % at 10 %/s is 10 s; an invalid Deadtime is none."""
    pins = {"SP": "100", "CycleTime": "2", "OpenRate": "10", "MaxOnTime": "9", "Deadtime": "-1"}
    diagram = around("POSP", "Valve", pins, {"OpenOut": "Open"})
    status = FIRST | 1 << 4 | 1 << 6
    run(
        diagram,
        {"POSITION_PROP": "Valve", "BOOL": "Open"},
        0,
        ({}, {"Open": False, "Valve.Status": status}),
        ({}, {"Open": False}),
        ({}, {"Open": True, "Valve.OpenTime": 2, "Valve.Status": status}),
        ({"Valve.PositionEUMin": 100.0}, {"Open": False, "Valve.Status": status | 1 << 9}),
    )


def test_srtp(run):
    """p. 133: (75 - 50)/50 of 4 s heat for 2 s; 25 cools for 2 s; 110 is 4 s, and 3 s by MaxHeatTime."""
    diagram = around(
        "SRTP", "Zone", {"In": "CV", "CycleTime": "Cycle"}, {"HeatOut": "Heat", "CoolOut": "Cool"}
    )
    heats, cools = {"Heat": True, "Cool": False}, {"Heat": False, "Cool": True}
    off = {"Heat": False, "Cool": False}
    run(
        diagram,
        {"SPLIT_RANGE": "Zone", "REAL": "CV Cycle", "BOOL": "Heat Cool"},
        0,
        ({"CV": 75, "Cycle": 4}, {**heats, "Zone.HeatTimePercent": 50, "Zone.CoolTimePercent": 0}),
        ({}, heats),
        ({}, off),
        ({}, off),
        ({}, heats),
        ({"CV": 25}, {**cools, "Zone.HeatTimePercent": 0, "Zone.CoolTimePercent": 50}),
        ({}, off),
        ({"CV": 110}, {**heats, "Zone.HeatTimePercent": 100}),
        ({"Zone.MaxHeatTime": 3.0}, {**heats, "Zone.HeatTimePercent": 75}),
        ({"Zone.MinHeatTime": 1.0, "CV": 55}, {**off, "Zone.HeatTimePercent": 0, "Zone.Status": 0}),
        ({"Zone.MaxHeatTime": 5.0, "CV": 75}, {"Zone.HeatTimePercent": 50, "Zone.Status": FIRST | 1 << 2}),
        ({"Zone.MinHeatIn": 100.0}, {"Zone.HeatTimePercent": 0, "Zone.HeatSpanInv": True}),
        ({"Cycle": -1}, {**off, "Zone.CycleTimeInv": True}),
    )


def test_fgen(run):
    """p. 60: lines between (0, 5), (10, 25), (20, -5), constant outside; then (0, 0), (1, 100)."""
    arrays = {"X1": "Xs", "Y1": "Ys", "X2": "Others", "Y2": "Heights"}
    pins = {"In": "In", "XY1Size": "Size", "XY2Size": "2", "Select": "Second"}
    diagram = around("FGEN", "Curve", pins, {"Out": "Out"}, **arrays)
    points = {"Xs[1]": 10.0, "Xs[2]": 20.0, "Ys[0]": 5.0, "Ys[1]": 25.0, "Ys[2]": -5.0, "Heights[1]": 100.0}
    types = {"REAL": "In Out", "REAL[3]": "Xs Ys", "REAL[2]": "Others Heights", "DINT": "Size"}
    run(
        diagram,
        {"FUNCTION_GENERATOR": "Curve", **types, "BOOL": "Second"},
        0,
        ({**points, "Others[1]": 1.0, "Size": 3, "In": -3}, {"Out": 5, "Curve.Status": 0}),
        ({"In": 0}, {"Out": 5}),
        ({"In": 5}, {"Out": 15}),
        ({"In": 10}, {"Out": 25}),
        ({"In": 15}, {"Out": 10}),
        ({"In": 21}, {"Out": -5}),
        ({"In": 0.25, "Second": True}, {"Out": 25}),
        ({"Others[1]": -1.0}, {"Out": 25, "Curve.Status": FIRST | 1 << 3}),
        ({"Others[1]": 1.0, "In": 0.5}, {"Out": 50, "Curve.Status": 0}),
        ({"Others[0]": 1.0, "In": 1}, {"Out": 0, "Curve.Status": 0}),
        ({"In": 2}, {"Out": 100}),
        ({"Second": False, "Size": 4}, {"Out": 100, "Curve.Status": FIRST | 1 << 1}),
        ({"Size": 0}, {"Out": 100, "Curve.Status": FIRST | 1 << 1}),
    )


def test_fgen_without_a_second_table(run):
    diagram = around("FGEN", "Curve", {"In": "7", "Select": "Second"}, {"Out": "Out"}, X1="Xs", Y1="Ys")
    run(
        diagram,
        {"FUNCTION_GENERATOR": "Curve", "REAL": "Out", "REAL[1]": "Xs Ys", "BOOL": "Second"},
        0,
        ({"Ys[0]": 2.0}, {"Out": 2, "Curve.Status": 0}),
        ({"Ys[0]": 3.0, "Second": True}, {"Out": 2, "Curve.XY2SizeInv": True}),
    )


def test_btdt(run):
    """1756-RM003N p. 307: 6 bits of 16#0A50 from bit 4, 2#100101, at bit 16; bits above 31 are lost."""
    pins = {"Source": "From", "SourceBit": "First", "Length": "Count", "DestBit": "Place", "Target": "Under"}
    diagram = around("BTDT", "Field", pins, {"Dest": "Dest"})
    run(
        diagram,
        {"FBD_BIT_FIELD_DISTRIBUTE": "Field", "DINT": "From First Count Place Under Dest"},
        0,
        ({"From": 0x0A50, "First": 4, "Count": 6, "Place": 16, "Under": 0x7F00FF}, {"Dest": 0x6500FF}),
        ({"Place": 28, "Count": 8}, {"Dest": 0x507F00FF}),
        ({"From": -1, "First": 30, "Place": 0}, {"Dest": 0x7F0003}),
        ({"First": 32}, {"Dest": 0x7F00FF}),
        ({"First": 0, "Count": 32}, {"Dest": -1}),
    )
