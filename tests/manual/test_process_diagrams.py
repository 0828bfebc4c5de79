"""Diagrams of process control, scan by scan on both back ends, with values by hand [1756-RM006K].

Periodic tasks make DeltaT: the period of the task in seconds.
"""

import pytest
from diagram_runs import around, follow, open_diagram
from l5x_files import block, reference, sheets, wire


@pytest.fixture
def run(tmp_path):
    """Runs a diagram in a task of `rate` ms, 0 for a continuous one, and checks each scan."""

    def run_(diagram, tags, rate, *scans, ms=0):
        follow(open_diagram(tmp_path / "machine.L5X", diagram, tags, rate=rate), *scans, ms=ms or rate)

    return run_


IN_AUTO = {"ProgProgReq": "1", "ProgAutoReq": "1"}


def test_1_a_temperature_loop_with_proportional_and_integral_gain(run):
    """CV = CV before + 2 dE + 6/60 E with DeltaT 1 s, from CVInitValue, between 0 and 100 %.

    20; E 10, 8: 20 - 4 + 0.8 = 16.8; E 5: 16.8 - 6 + 0.5 = 11.3; E -10: 11.3 - 30 - 1 = -19.7, limited to 0;
    E 10: 0 + 40 + 1 = 41. CVEU is 4 to 20: 4 + 16 x 16.8/100 = 6.688. A limit of 200 % is invalid: E 60 gives
    41 + 100 + 6, limited to 100.
    """
    pins = {"PV": "Temperature", "SPProg": "50", "PGain": "2", "IGain": "6", "CVInitValue": "7.2"}
    diagram = around("PIDE", "Loop", {**pins, **IN_AUTO, "CVEUMax": "20", "CVEUMin": "4"}, {"CVEU": "Valve"})
    run(
        diagram,
        {"PID_ENHANCED": "Loop", "REAL": "Temperature Valve"},
        1000,
        ({"Temperature": 40}, {"Loop.CV": 20, "Valve": 7.2, "Loop.Auto": True, "Loop.DeltaT": 1}),
        ({"Temperature": 42}, {"Loop.CV": 16.8, "Valve": 6.688, "Loop.E": 8, "Loop.CVLAlarm": False}),
        ({"Temperature": 45}, {"Loop.CV": 11.3, "Loop.EPercent": 5, "Loop.PVPercent": 45}),
        ({"Temperature": 60}, {"Loop.CV": 0, "Valve": 4, "Loop.CVLAlarm": True, "Loop.WindupLOut": True}),
        ({"Temperature": 40}, {"Loop.CV": 41, "Loop.CVLAlarm": False, "Loop.Status1": 0, "Loop.Status2": 0}),
        ({"Temperature": -10, "Loop.CVHLimit": 200.0}, {"Loop.CV": 100, "Loop.Status1": 1 | 1 << 17}),
    )


def test_2_a_loop_with_dependent_gains_in_all_modes(run):
    """CV = CV before + 2 (dE + E/(60 x 0.5) + 60 x 0.1 d(dE)), the derivative of -PV.

    50; PV 40, 41: 2 (-1 + 0.3 - 6) = -13.4: 36.6; PV 41: 2 (0 + 0.3 + 6) = 12.6: 49.2; Override 5; Hand 33;
    Auto again: 33 + 2 x 0.3 = 33.6; the operator's manual: CVOper, which has followed CV.
    """
    pins = {"PV": "PV", "SPProg": "50", "PGain": "2", "IGain": "0.5", "DGain": "0.1", "CVInitValue": "50"}
    modes = {"ProgOverrideReq": "Safe", "ProgHandReq": "Field", "CVOverride": "5", "HandFB": "33"}
    more = {"DependIndepend": "1", "ProgOperReq": "Operator", "ProgProgReq": "1", "ProgAutoReq": "1"}
    diagram = around("PIDE", "Loop", {**pins, **modes, **more}, {"CV": "CV"})
    run(
        diagram,
        {"PID_ENHANCED": "Loop", "REAL": "PV CV", "BOOL": "Safe Field Operator"},
        1000,
        ({"PV": 40}, {"CV": 50}),
        ({"PV": 41}, {"CV": 36.6}),
        ({}, {"CV": 49.2, "Loop.Auto": True, "Loop.CVOper": 49.2, "Loop.SPOper": 50}),
        ({"Safe": True}, {"CV": 5, "Loop.Override": True, "Loop.Auto": False}),
        ({"Field": True}, {"CV": 33, "Loop.Hand": True, "Loop.Override": False, "Loop.InitPrimary": True}),
        ({"Safe": False, "Field": False}, {"CV": 33.6, "Loop.Auto": True}),
        (
            {"Operator": True, "Loop.OperManualReq": True},
            {"CV": 33.6, "Loop.Manual": True, "Loop.ProgOper": False, "Loop.OperManualReq": False},
        ),
        ({"Loop.CVOper": 120.0}, {"CV": 100, "Loop.CVOperInv": True, "Loop.Status1": 1 | 1 << 13}),
        ({"Loop.CVOper": 10.0, "PV": 99.0}, {"CV": 10, "Loop.InstructFault": False, "Loop.E": -49}),
    )


def test_3_a_flow_is_totaled_to_a_target(run):
    """gal/min, 1 s: Total + 1/60 (In + In before)/2. The first scan of a run adds nothing.

    60, 60: 1; 120: (120 + 60)/120 = 1.5: 2.5; 0 is the cutoff, and counts as 0 before: 2.5; 120: 1: 3.5. Then
    OldTotal is 3.5, and after the reset to 0 the scan adds 2.
    """
    pins = {"In": "Flow", "TimeBase": "1", "Target": "3", "TargetDev1": "1", "ProgProgReq": "1"}
    requests = {"ProgStartReq": "Run", "ProgResetReq": "Reset"}
    diagram = around("TOT", "Sum", {**pins, **requests}, {"Total": "Total", "TargetFlag": "Full"})
    tags = {"TOTALIZER": "Sum", "REAL": "Flow Total", "BOOL": "Run Reset Full"}
    run(
        diagram,
        tags,
        1000,
        ({"Flow": 60, "Run": True}, {"Total": 0, "Sum.RunStop": True, "Full": False}),
        ({}, {"Total": 1, "Sum.TargetDev1Flag": False}),
        ({"Flow": 120}, {"Total": 2.5, "Sum.TargetDev1Flag": True, "Full": False}),
        ({"Flow": 0}, {"Total": 2.5, "Sum.LowInCutoffFlag": True}),
        ({"Flow": 120}, {"Total": 3.5, "Full": True, "Sum.LowInCutoffFlag": False}),
        ({"Reset": True}, {"Total": 2, "Sum.OldTotal": 3.5, "Sum.ProgResetDone": True}),
        ({}, {"Total": 4, "Sum.OldTotal": 3.5, "Sum.ProgResetDone": True}),
        ({"Reset": False}, {"Total": 6, "Sum.ProgResetDone": False, "Sum.ProgStartReq": True}),
        ({"Sum.ProgValueReset": True}, {"Total": 8, "Sum.ProgStartReq": False, "Sum.ProgProgReq": False}),
    )


def test_4_a_process_model_with_deadtime_and_lag(run):
    """The manual's 4.25 s of 0.5 s are rounded to 9 elements, 4.5 s [p. 54]; then a lag of 2 s.

    Lag: Out = (0.5 (In + In before) + 3.5 Out before)/4.5: 0.5 x 9/4.5 = 1; (9 + 3.5)/4.5 = 2.777778.
    """
    content = (
        reference("IRef", 0, "Heat")
        + block("DEDT", 1, "Wait", x=100, StorageArray="Buffer")
        + block("LDLG", 2, "Lag", x=200)
        + reference("IRef", 3, "4.25")
        + reference("IRef", 4, "2")
        + wire(0, "1.In")
        + wire(3, "1.Deadtime")
        + wire("1.Out", "2.In")
        + wire(4, "2.Lag")
    )
    tags = {"DEADTIME": "Wait", "LEAD_LAG": "Lag", "REAL": "Heat", "REAL[10]": "Buffer"}
    still: list[tuple[dict[str, float], dict[str, float]]] = [({}, {"Wait.Out": 0, "Lag.Out": 0})] * 8
    run(
        sheets("Blocks", content),
        tags,
        500,
        ({}, {"Wait.Out": 0, "Lag.Out": 0, "Wait.DeltaT": 0.5}),
        ({"Heat": 9}, {"Wait.Out": 0, "Buffer[0]": 9}),
        *still,
        ({}, {"Wait.Out": 9, "Lag.Out": 1}),
        ({}, {"Wait.Out": 9, "Lag.Out": 2.777778, "Wait.Status": 0, "Lag.Status": 0}),
        ({"Wait.InFault": True, "Heat": 5}, {"Wait.Out": 9, "Wait.Status": 3, "Wait.InFaulted": True}),
        ({"Wait.InFault": False}, {"Wait.Out": 5, "Wait.Status": 0, "Buffer[9]": 5}),
    )


def test_5_a_pressure_alarm_with_deadband_and_rate(run):
    """H at 80 until below 80 - 2; samples 1 s apart: (79 - 70)/1 s is above 5/s, (77.9 - 79)/1 s is not."""
    pins = {"In": "P", "HHLimit": "90", "HLimit": "80", "LLimit": "10", "Deadband": "2"}
    diagram = around(
        "ALM", "Watch", {**pins, "ROCPosLimit": "5", "ROCPeriod": "1"}, {"HAlarm": "High", "ROC": "Rate"}
    )
    run(
        diagram,
        {"ALARM": "Watch", "REAL": "P Rate", "BOOL": "High"},
        500,
        ({"P": 70}, {"High": False, "Rate": 0, "Watch.LLAlarm": False}),
        ({"P": 80}, {"High": True, "Watch.HHAlarm": False, "Rate": 0}),
        ({"P": 79}, {"High": True, "Rate": 9, "Watch.ROCPosAlarm": True}),
        ({"P": 78}, {"High": True, "Watch.ROCPosAlarm": True}),
        ({"P": 77.9}, {"High": False, "Rate": -1.1, "Watch.ROCPosAlarm": False}),
        ({"P": 10, "Watch.ROCNegLimit": -1.0}, {"Watch.LAlarm": True, "Watch.Status": 1 | 1 << 3}),
        ({"P": 12, "Watch.ROCNegLimit": 0.0}, {"Watch.LAlarm": True, "Watch.InstructFault": False}),
        ({"P": 12.1}, {"Watch.LAlarm": False}),
    )


def test_6_one_of_three_transmitters(run):
    """Values 10, 40, 20: highest 40, lowest 10, median 20, mean 70/3; a fault takes one out."""
    pins = {f"In{n}": each for n, each in enumerate(("10", "40", "20"), start=1)}
    more = {"In2Fault": "Bad", "InsUsed": "3", "SelectorMode": "Mode", "ProgProgReq": "1"}
    diagram = around("ESEL", "Pick", {**pins, **more, "ProgSelector": "3"}, {"Out": "Level"})
    tags = {"SELECT_ENHANCED": "Pick", "REAL": "Level", "DINT": "Mode", "BOOL": "Bad"}
    run(
        diagram,
        tags,
        10,
        ({}, {"Level": 20, "Pick.SelectedIn": 3, "Pick.ProgOper": True}),
        ({"Mode": 1}, {"Level": 40, "Pick.SelectedIn": 2}),
        ({"Mode": 2}, {"Level": 10, "Pick.SelectedIn": 1}),
        ({"Mode": 3}, {"Level": 20, "Pick.SelectedIn": 3}),
        ({"Mode": 4}, {"Level": 70 / 3, "Pick.SelectedIn": 0}),
        ({"Bad": True}, {"Level": 15, "Pick.InsFaulted": True, "Pick.Status": 3}),
        ({"Mode": 1}, {"Level": 20, "Pick.SelectedIn": 3}),
        ({"Mode": 5, "Bad": False}, {"Level": 20, "Pick.SelectorModeInv": True, "Pick.Status": 1 | 1 << 3}),
        ({"Mode": 1, "Pick.ProgOverrideReq": True}, {"Level": 20, "Pick.Override": True, "Pick.Status": 0}),
    )


def test_7_a_moving_average_with_and_without_weights(run):
    """Three samples, at first fewer [p. 388]: 3; (9 + 3)/2; (6 + 9 + 3)/3; (0 + 6 + 9)/3.

    Weights 0.5, 0.3, 0.2 of the newest to the oldest: 0.5 x 10 + 0.3 x 0 + 0.2 x 6 = 6.2.
    """
    pins = {"In": "Raw", "NumberOfSamples": "3", "UseWeights": "Weigh", "InFault": "Bad"}
    arrays = {"StorageArray": "Samples", "WeightArray": "Weights"}
    diagram = around("MAVE", "Mean", pins, {"Out": "Smooth"}, **arrays)
    tags = {"MOVING_AVERAGE": "Mean", "REAL": "Raw Smooth", "REAL[3]": "Samples Weights", "BOOL": "Weigh Bad"}
    weights = {f"Weights[{n}]": each for n, each in enumerate((0.5, 0.3, 0.2))}
    run(
        diagram,
        tags,
        10,
        ({"Raw": 3, **weights}, {"Smooth": 3}),
        ({"Raw": 9}, {"Smooth": 6}),
        ({"Raw": 6}, {"Smooth": 6}),
        ({"Raw": 0}, {"Smooth": 5, "Samples[0]": 0, "Samples[2]": 9}),
        ({"Raw": 10, "Weigh": True}, {"Smooth": 6.2}),
        ({"Raw": 99, "Bad": True}, {"Smooth": 6.2, "Mean.InFaulted": True, "Mean.Status": 3}),
        ({"Bad": False, "Weigh": False, "Raw": 8}, {"Smooth": 8, "Mean.Status": 0}),
        ({"Raw": 4}, {"Smooth": 6}),
    )


def test_8_a_valve_with_feedback(run):
    """FB0 is the open switch, FB1 the closed one; FaultTime 0.25 s, 100 ms a scan.

    The command of scan 2 has its feedback in scan 4, in time. The valve then leaves the state by itself: a
    fault at once, latched until it is unlatched. Commanded to close in scan 8, it does not: 0.3 s later there
    is a fault.
    """
    states = {"FB0State0": "0", "FB1State0": "1", "FB0State1": "1", "FB1State1": "0"}
    pins = {
        "ProgCommand": "Open",
        "FB0": "Opened",
        "FB1": "Closed",
        "FaultTime": "0.25",
        "FaultAlarmLatch": "1",
    }
    diagram = around("D2SD", "Valve", {**pins, **states, "ProgProgReq": "1"}, {"Out": "Coil"})
    tags = {"DISCRETE_2STATE": "Valve", "BOOL": "Open Opened Closed Coil"}
    run(
        diagram,
        tags,
        100,
        ({"Closed": True}, {"Coil": False, "Valve.Device0State": True, "Valve.FaultAlarm": False}),
        ({"Open": True}, {"Coil": True, "Valve.CommandStatus": True, "Valve.Device0State": False}),
        ({"Closed": False}, {"Valve.Device1State": False, "Valve.FaultAlarm": False}),
        ({"Opened": True}, {"Valve.Device1State": True, "Valve.FaultAlarm": False}),
        ({"Opened": False}, {"Valve.Device1State": False, "Valve.FaultAlarm": True}),
        ({"Opened": True}, {"Valve.Device1State": True, "Valve.FaultAlarm": True}),
        ({"Valve.FaultAlmUnlatch": True}, {"Valve.FaultAlarm": False, "Valve.FaultAlmUnlatch": False}),
        ({"Open": False}, {"Coil": False, "Valve.FaultAlarm": False}),
        ({}, {"Valve.FaultAlarm": False}),
        ({}, {"Valve.FaultAlarm": False}),
        ({}, {"Valve.FaultAlarm": True}),
        ({"Valve.State1Perm": False, "Open": True}, {"Coil": False, "Valve.CommandStatus": False}),
        ({"Valve.ProgHandReq": True, "Valve.HandFB": True}, {"Coil": True, "Valve.Hand": True}),
    )


def test_9_a_motor_forward_stop_reverse(run):
    """Out0 is forward (state 1), Out1 reverse (state 2). Two commands hold the state. ModeAlarm: in Operator
    control the program's command changes to another state than the operator's.
    """
    outs = {"Out0State1": "1", "Out1State2": "1"}
    backs = {"FB0": "Runs", "FB0State1": "1", "FB0State2": "1"}
    commands = {f"Prog{n}Command": each for n, each in enumerate(("Stop", "Forward", "Reverse"))}
    pins = {**commands, **outs, **backs, "ProgProgReq": "Program", "ProgOperReq": "Operator"}
    diagram = around("D3SD", "Motor", pins, {"Out0": "Contactor1", "Out1": "Contactor2"})
    names = "Stop Forward Reverse Runs Contactor1 Contactor2 Program Operator"
    stopped = {"Contactor1": False, "Contactor2": False}
    run(
        diagram,
        {"DISCRETE_3STATE": "Motor", "BOOL": names},
        100,
        ({"Program": True}, {**stopped, "Motor.Command0Status": True, "Motor.Device0State": True}),
        ({"Forward": True}, {"Contactor1": True, "Motor.Command1Status": True, "Motor.Device1State": False}),
        ({"Runs": True}, {"Contactor1": True, "Motor.Device1State": True}),
        ({"Reverse": True}, {"Contactor1": True, "Motor.ProgCommandInv": True, "Motor.Status": 1 | 1 << 3}),
        ({"Forward": False}, {"Contactor1": False, "Contactor2": True, "Motor.Status": 0}),
        ({"Program": False, "Operator": True}, {"Contactor2": True, "Motor.ModeAlarm": False}),
        ({"Motor.Oper0Req": True}, {**stopped, "Motor.Oper0Req": False, "Motor.ModeAlarm": False}),
        ({"Forward": True, "Reverse": False}, {**stopped, "Motor.ModeAlarm": True}),
        ({"Forward": False, "Stop": True}, {**stopped, "Motor.ModeAlarm": False}),
        (
            {"Motor.OverrideState": 2, "Motor.ProgOverrideReq": True},
            {"Contactor2": True, "Motor.Override": True},
        ),
    )


def test_10_a_batch_profile(run):
    """30 s a scan. Segment 0: 4 units/min to 5, 1 min there; segment 1: 10 units/min to 0, no soak.

    0, 2, 4, 5 (4 + 2 is past it), 1 min - 0.5 - 0.5, then -5 a scan; the end is Operator Manual.
    """
    arrays = {"RampValue": "Ramps", "SoakValue": "Values", "SoakTime": "Times"}
    pins = {"NumberOfSegs": "2", "PV": "PV", "RampDeadband": "3", "GuarRamp": "Guard"}
    diagram = around("RMPS", "Profile", pins, {"Out": "Setpoint"}, **arrays)
    tags = {"RAMP_SOAK": "Profile", "REAL": "PV Setpoint", "REAL[2]": "Ramps Values Times", "BOOL": "Guard"}
    given = {"Ramps[0]": 4.0, "Ramps[1]": 10.0, "Values[0]": 5.0, "Times[0]": 1.0}
    run(
        diagram,
        tags,
        30_000,
        (given, {"Setpoint": 0, "Profile.Manual": True, "Profile.SoakTimeOper": 1}),
        ({"Profile.OperAutoReq": True}, {"Setpoint": 2, "Profile.Auto": True, "Profile.OutOper": 2}),
        ({}, {"Setpoint": 4, "Profile.GuarRampOn": False}),
        ({"Guard": True}, {"Setpoint": 4, "Profile.GuarRampOn": True}),
        ({"PV": 1}, {"Setpoint": 5, "Profile.GuarRampOn": False, "Profile.SoakTimeLeft": 1}),
        ({}, {"Setpoint": 5, "Profile.SoakTimeLeft": 0.5, "Profile.CurrentSeg": 0}),
        ({}, {"Setpoint": 5, "Profile.CurrentSeg": 1}),
        ({"PV": 5}, {"Setpoint": 0, "Profile.CurrentSeg": 1, "Profile.Auto": True}),
        ({}, {"Setpoint": 0, "Profile.Auto": False, "Profile.Manual": True, "Profile.Status": 0}),
        ({"Profile.OutOper": 3.0}, {"Setpoint": 3}),
        (
            {"Profile.NumberOfSegs": 2, "Ramps[1]": -1.0, "Profile.OperAutoReq": True},
            {
                "Setpoint": 3,
                "Profile.Manual": True,
                "Profile.RampValueInv": True,
                "Profile.Status": 1 | 1 << 9,
            },
        ),
    )


# In before and after a step, in a task of 500 ms: k = w DeltaT/2 = 0.25
FILTERS = {
    # (0.25 (In + In before) + 0.75 Out before)/1.25: 1.25/1.25, (2.5 + 0.75)/1.25
    "LPF": ("FILTER_LOW_PASS", {"WLag": "1"}, (0, 5, 5), (0, 1, 2.6)),
    # (In - In before + 0.75 Out before)/1.25: 5/1.25, 3/1.25
    "HPF": ("FILTER_HIGH_PASS", {"WLead": "1"}, (0, 5, 5), (0, 4, 2.4)),
    # w = 4, Q = 0.5: k = 1: (s^2 + 16)/(s^2 + 8 s + 16) is (1 + 1/z^2)/2 with s = 4 (1 - 1/z)/(1 + 1/z):
    # (16 (1 - 1/z)^2 + 16 (1 + 1/z)^2)/(64) = (1 + 1/z^2)/2
    "NTCH": ("FILTER_NOTCH", {"WNotch": "4", "QFactor": "0.5"}, (0, 8, 8), (0, 4, 4)),
    # lead 1, lag 1 with gain 3 and bias 1 do nothing else
    "LDLG": ("LEAD_LAG", {"Lead": "1", "Lag": "1", "Gain": "3", "Bias": "1"}, (0, 2, 2), (1, 7, 7)),
    # 2 (In - In before)/0.5
    "DERV": ("DERIVATIVE", {"Gain": "2"}, (1, 3, 3), (0, 8, 0)),
    # Out before + 2 (In + In before)/2 x 0.5: 1 + 2, + 3
    "INTG": ("INTEGRATOR", {"IGain": "2", "InitialValue": "1"}, (1, 3, 3), (1, 3, 6)),
}


@pytest.mark.parametrize("name", FILTERS)
def test_a_filter_follows_a_step(run, name):
    kind, pins, inputs, outputs = FILTERS[name]
    diagram = around(name, "Filter", {"In": "A", **pins}, {"Out": "B"})
    scans = [({"A": a}, {"B": b, "Filter.Status": 0}) for a, b in zip(inputs, outputs, strict=True)]
    run(diagram, {kind: "Filter", "REAL": "A B"}, 500, *scans)


def test_a_standard_deviation_and_a_sum(run):
    """1; 1 and 3: mean 2, deviation 1; 1, 3 and 5: mean 3, square root of 8/3. 2 x 1.5 + 4 x 1 + 0.5."""
    content = (
        reference("IRef", 0, "A")
        + block("MSTD", 1, "Spread", StorageArray="Samples")
        + reference("IRef", 2, "3")
        + block("SSUM", 3, "Total", x=50)
        + wire(0, "1.In")
        + wire(2, "1.NumberOfSamples")
        + "".join(reference("IRef", 10 + n, each) for n, each in enumerate(("2", "1.5", "4", "1", "0.5")))
        + "".join(
            wire(10 + n, f"3.{pin}") for n, pin in enumerate(("In1", "Gain1", "In3", "Select1", "Bias"))
        )
        + wire(13, "3.Select3")
    )
    tags = {"MOVING_STD_DEV": "Spread", "SELECTED_SUMMER": "Total", "REAL": "A", "REAL[3]": "Samples"}
    run(
        sheets("Blocks", content),
        tags,
        10,
        ({"A": 1}, {"Spread.Average": 1, "Spread.Out": 0, "Total.Out": 7.5}),
        ({"A": 3}, {"Spread.Average": 2, "Spread.Out": 1}),
        ({"A": 5}, {"Spread.Average": 3, "Spread.Out": (8 / 3) ** 0.5}),
    )


def test_timing_modes(run):
    """Periodic: the task's 500 ms; oversample: its time, with its limits; sampled: between two stamps.

    32,700 to 32 is 100 ms; RTSTime 100 is met, 90 is missed by more than 1 ms; a stamp of -1 runs nothing.
    """
    pins = {"In": "1", "IGain": "1", "TimingMode": "Mode", "OversampleDT": "Time", "RTSTimeStamp": "Stamp"}
    diagram = around("INTG", "Sum", {**pins, "RTSTime": "Period"}, {"Out": "Out"})
    bit = {"TimingModeInv": 27, "RTSMissed": 28, "RTSTimeInv": 29, "RTSTimeStampInv": 30}
    tags = {"INTEGRATOR": "Sum", "DINT": "Mode Stamp Period", "REAL": "Time Out"}
    run(
        diagram,
        tags,
        500,
        ({"Period": 100}, {"Out": 0, "Sum.DeltaT": 0.5, "Sum.Status": 0}),
        ({}, {"Out": 0.5}),
        ({"Mode": 1, "Time": 2.0}, {"Out": 2.5, "Sum.DeltaT": 2}),
        ({"Time": 4194.4}, {"Out": 2.5, "Sum.DeltaT": 0, "Sum.DeltaTInv": True, "Sum.Status": 1 - (1 << 31)}),
        ({"Mode": 2, "Stamp": 32_700}, {"Sum.RTSMissed": True, "Sum.Status": 1 | 1 << bit["RTSMissed"]}),
        ({"Stamp": 32, "Sum.Out": 0.0}, {"Sum.DeltaT": 0.1, "Sum.Status": 0}),
        ({"Stamp": 132, "Period": 90}, {"Sum.DeltaT": 0.1, "Sum.RTSMissed": True}),
        ({"Stamp": -1}, {"Sum.DeltaT": 0, "Sum.Status": 1 | 1 << bit["RTSTimeStampInv"]}),
        ({"Stamp": 232, "Period": 0}, {"Sum.DeltaT": 0.1, "Sum.Status": 1 | 1 << bit["RTSTimeInv"]}),
        ({"Mode": 3}, {"Sum.DeltaT": 0, "Sum.Status": 1 | 1 << bit["TimingModeInv"]}),
    )


def test_a_continuous_task_counts_whole_milliseconds(run):
    """10.5 ms a scan: 10, then 11 with the half of before. The first scan has no time."""
    diagram = around("INTG", "Sum", {"In": "1000", "IGain": "1"}, {"Out": "Out"})
    run(
        diagram,
        {"INTEGRATOR": "Sum", "REAL": "Out"},
        0,
        ({}, {"Out": 0, "Sum.DeltaT": 0}),
        ({}, {"Out": 10, "Sum.DeltaT": 0.01}),
        ({}, {"Out": 21, "Sum.DeltaT": 0.011}),
        ms=10.5,
    )


def test_an_overflow_clears_enable_out(run):
    """3E38 + 3E38 is infinite, 1/0 too; the block of a filter holds what it was before."""
    content = (
        reference("IRef", 0, "A")
        + block("ADD", 1, "Sum")
        + block("DIV", 2, "Quotient", x=50)
        + wire(0, "1.SourceA")
        + wire(0, "1.SourceB")
        + wire(0, "2.SourceA")
        + reference("IRef", 3, "B")
        + wire(3, "2.SourceB")
        + block("LDLG", 4, "Lag", x=100)
        + wire("1.Dest", "4.In")
    )
    tags = {"FBD_MATH": "Sum Quotient", "LEAD_LAG": "Lag", "REAL": "A B"}
    run(
        sheets("Blocks", content),
        tags,
        10,
        ({"A": 1, "B": 2}, {"Sum.EnableOut": True, "Quotient.EnableOut": True, "Lag.EnableOut": True}),
        ({"A": 3e38}, {"Sum.EnableOut": False, "Quotient.EnableOut": True, "Lag.EnableOut": False}),
        ({"A": 1, "B": 0}, {"Sum.EnableOut": True, "Quotient.EnableOut": False}),
    )


NOT_KEPT = {
    # these start again, in the steady state of 9 [p. 333]
    "LPF": ("FILTER_LOW_PASS", {"WLag": "1"}, 5, 9),
    "HPF": ("FILTER_HIGH_PASS", {"WLead": "1"}, 0, 0),
    "NTCH": ("FILTER_NOTCH", {"WNotch": "4", "QFactor": "0.5"}, 5, 9),
    # (9 + 5 + 7 Out before)/9 with Lag 2, 2 Lag/DeltaT = 8
    "LDLG": ("LEAD_LAG", {"Lag": "2"}, 5, 49 / 9),
    # (9 - 5)/0.5
    "DERV": ("DERIVATIVE", {"Gain": "1"}, 0, 8),
    # 1 unit/s for 0.5 s
    "RLIM": ("RATE_LIMITER", {"IncRate": "1", "DecRate": "1"}, 5, 5.5),
}


@pytest.mark.parametrize("wrong", [float("nan"), float("inf"), -float("inf")])
@pytest.mark.parametrize("name", NOT_KEPT)
def test_a_block_keeps_no_value_that_is_not_finite(run, name, wrong):
    """ "Function Block Responses to Overflow Conditions": Out has it in its own call only."""
    kind, pins, steady, after = NOT_KEPT[name]
    diagram = around(name, "It", {"In": "A", **pins}, {"Out": "B"})
    run(
        diagram,
        {kind: "It", "REAL": "A B"},
        500,
        ({"A": 5}, {"It.EnableOut": True}),
        ({}, {"B": steady}),
        ({"A": wrong}, {"It.EnableOut": False}),
        ({"A": 9}, {"B": after, "It.EnableOut": True}),
    )


@pytest.mark.parametrize("wrong", [float("nan"), float("inf")])
def test_a_deadtime_keeps_no_value_that_is_not_finite(run, wrong):
    """Two elements of 500 ms. The buffer stays in such a call; without a deadtime Out is the input."""
    diagram = around("DEDT", "Wait", {"In": "A", "Deadtime": "Time"}, {"Out": "B"}, StorageArray="Buffer")
    run(
        diagram,
        {"DEADTIME": "Wait", "REAL": "A B Time", "REAL[4]": "Buffer"},
        500,
        ({"A": wrong, "Time": 1}, {"Buffer[0]": 0, "Wait.EnableOut": False}),
        ({"A": 5}, {"B": 5, "Buffer[0]": 5, "Buffer[1]": 5, "Wait.EnableOut": True}),
        ({"A": 7}, {"B": 5, "Buffer[0]": 7, "Buffer[1]": 5}),
        ({"A": wrong}, {"B": 5, "Buffer[0]": 7, "Buffer[1]": 5}),
        ({"A": 9}, {"B": 5, "Buffer[0]": 9, "Buffer[1]": 7}),
        ({"Time": 0, "A": wrong}, {"Wait.EnableOut": False}),
        ({"A": 3}, {"B": 3}),
    )


@pytest.mark.parametrize(("rate", "out"), [(2.5, 0.1975), (0.5, 0.1995)])
def test_a_period_that_is_no_whole_number_of_milliseconds(run, rate, out):
    """DeltaT is the period of the task [p. 499]. In 200 ms each call but the first adds it."""
    diagram = around("INTG", "Sum", {"In": "1", "IGain": "1"}, {"Out": "Out"})
    calls = round(200 / rate)
    still: list[tuple[dict[str, float], dict[str, float]]] = [({}, {"Sum.DeltaT": rate / 1000})] * (calls - 1)
    run(diagram, {"INTEGRATOR": "Sum", "REAL": "Out"}, rate, *still, ({}, {"Out": out}))


@pytest.mark.parametrize("high", [-5, -6, float("nan")])
def test_an_integrator_whose_limits_are_crossed_is_at_the_low_one(run, high):
    """Out is LowLimit, with both alarms and bit 2 of Status; correct limits go on from there."""
    diagram = around("INTG", "Sum", {"In": "1", "IGain": "2", "HighLimit": "High"}, {"Out": "Out"})
    run(
        diagram,
        {"INTEGRATOR": "Sum", "REAL": "High Out"},
        500,
        ({"High": 10, "Sum.LowLimit": -5.0}, {"Out": 0, "Sum.HighAlarm": False, "Sum.LowAlarm": False}),
        ({}, {"Out": 1}),
        ({"High": high}, {"Out": -5, "Sum.HighAlarm": True, "Sum.LowAlarm": True, "Sum.Status": 1 | 1 << 2}),
        ({"High": 10}, {"Out": -4, "Sum.HighAlarm": False, "Sum.LowAlarm": False, "Sum.Status": 0}),
    )


def test_a_step_of_the_feed_forward_waits_for_a_call_with_time(run):
    """OversampleDT 0 runs nothing; then CV is 50 + 10, then 60 - 3."""
    pins = {"PV": "50", "SPProg": "50", "CVInitValue": "50", "FF": "FF", "TimingMode": "1"}
    diagram = around("PIDE", "Loop", {**pins, **IN_AUTO, "OversampleDT": "Time"}, {"CV": "CV"})
    run(
        diagram,
        {"PID_ENHANCED": "Loop", "REAL": "FF Time CV"},
        100,
        ({"Time": 1}, {"CV": 50}),
        ({"Time": 0, "FF": 10}, {"CV": 50}),
        ({"Time": 1}, {"CV": 60}),
        ({"FF": 7}, {"CV": 57}),
        ({}, {"CV": 57}),
    )


def test_a_setpoint_that_is_no_number_is_a_fault_of_its_call(run):
    """CV stays at 50, and the next setpoint moves it at once: 50 + 60 - 50."""
    pins = {"PV": "50", "SPProg": "SP", "CVInitValue": "50", "PGain": "1"}
    diagram = around("PIDE", "Loop", {**pins, **IN_AUTO}, {"CV": "CV"})
    run(
        diagram,
        {"PID_ENHANCED": "Loop", "REAL": "SP CV"},
        1000,
        ({"SP": 50}, {"CV": 50, "Loop.SPProgInv": False}),
        ({"SP": float("nan")}, {"CV": 50, "Loop.SPProgInv": True, "Loop.InstructFault": True}),
        ({"SP": 60}, {"CV": 60, "Loop.SPProgInv": False, "Loop.InstructFault": False}),
    )
