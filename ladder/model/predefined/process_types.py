"""Structures of the function blocks of process control, as tables of their parameters.

[1756-RM006K, structure of each instruction; 1756-RM003N, Function Block Attributes, timing modes]
"""

from __future__ import annotations

from collections.abc import Mapping

from ..types import Structure, for_each, members_of

TIMING = "DINT TimingMode REAL OversampleDT DINT RTSTime=1 RTSTimeStamp"
"""Inputs of blocks with timing modes."""

TIMING_FAULTS = ("TimingModeInv", "RTSMissed", "RTSTimeInv", "RTSTimeStampInv", "DeltaTInv")
FIRST_TIMING_BIT = 27

STATUS_BITS: dict[str, dict[str, tuple[str, int]]] = {}
"""Status word and bit of each fault indicator, by structure."""


def block_structure(
    name: str, inputs: str, outputs: str, faults: str | None = None, *, hidden: str = "", more: str = ""
) -> Structure:
    """Return the structure of a block: EnableIn, inputs, EnableOut, outputs, status.

    Args:
        name: name of the type.
        inputs: its input parameters (see `members_of`); `TIMING` has the inputs of timing modes.
        outputs: its output parameters.
        faults: names of bits 1, 2, ... of Status; bit 0 is InstructFault. None if there is no Status.
        hidden: members that keep values between calls; see `members_of`.
        more: names of bits 1, 2, ... of Status2, if there are two words.
    """
    words = [] if faults is None else ["Status1", "Status2"] if more else ["Status"]
    bits: dict[str, tuple[str, int]] = {}
    if faults is not None:
        bits = {fault: (words[0], number) for number, fault in enumerate(("InstructFault", *faults.split()))}
    bits |= {fault: (words[-1], number) for number, fault in enumerate(more.split(), start=1)}
    if TIMING in inputs:
        hidden = f"{hidden} BOOL begun LINT last_ns DINT stamp"
        bits |= {fault: (words[-1], FIRST_TIMING_BIT + n) for n, fault in enumerate(TIMING_FAULTS)}
    STATUS_BITS[name] = bits
    text = f"BOOL EnableIn=1 {inputs} BOOL EnableOut {outputs} DINT {' '.join(words)} BOOL {' '.join(bits)}"
    return Structure(name, members_of(text), hidden=members_of(hidden))


_CONTROL = "ProgProgReq ProgOperReq"
_OF_OPERATOR = "OperProgReq OperOperReq"
_DEVICE_REQUESTS = f"{_CONTROL} ProgOverrideReq ProgHandReq {_OF_OPERATOR} ProgValueReset"
_DEVICE = "FaultAlarm ModeAlarm ProgOper Override Hand"
_DEVICE_STATE = "BOOL ran begun timing LINT since_ns DINT state asked"
_PAST = "LREAL x1 x2 x3 x4 y1 y2 y3 y4"
_CYCLE = "BOOL begun LINT last_ns timer"
_INTEGRATES = "REAL In BOOL Initialize REAL InitialValue"
_BOUNDS = "REAL HighLimit=max LowLimit=-max BOOL HoldHigh HoldLow"
_LEVELS = "HHLimit=max HLimit=max LLimit=-max LLLimit=-max"


PROCESS: Mapping[str, Structure] = {
    "ALM": block_structure(
        "ALARM",
        f"REAL In {_LEVELS} Deadband ROCPosLimit ROCNegLimit ROCPeriod",
        "HHAlarm HAlarm LAlarm LLAlarm ROCPosAlarm ROCNegAlarm REAL ROC",
        "DeadbandInv ROCPosLimitInv ROCNegLimitInv ROCPeriodInv",
        hidden="BOOL begun LINT sampled_ns LREAL sample",
    ),
    "D2SD": block_structure(
        "DISCRETE_2STATE",
        "ProgCommand Oper0Req Oper1Req State0Perm=1 State1Perm=1 FB0 FB1 HandFB REAL FaultTime "
        "BOOL FaultAlarmLatch FaultAlmUnlatch OverrideOnInit OverrideOnFault OutReverse OverrideState "
        f"FB0State0 FB0State1=1 FB1State0 FB1State1=1 {_DEVICE_REQUESTS}",
        f"Out Device0State Device1State CommandStatus {_DEVICE}",
        "FaultTimeInv OperReqInv",
        hidden=_DEVICE_STATE,
    ),
    "D3SD": block_structure(
        "DISCRETE_3STATE",
        f"{for_each('Prog#Command', 0, 1, 2)} {for_each('Oper#Req', 0, 1, 2)} "
        f"{for_each('State#Perm=1', 0, 1, 2)} FB0 FB1 FB2 FB3 HandFB0 HandFB1 HandFB2 "
        "REAL FaultTime BOOL FaultAlarmLatch FaultAlmUnlatch OverrideOnInit OverrideOnFault "
        f"{for_each('Out#State0 Out#State1 Out#State2', 0, 1, 2)} DINT OverrideState "
        f"BOOL {for_each('FB#State0 FB#State1 FB#State2', 0, 1, 2, 3)} {_DEVICE_REQUESTS}",
        f"{for_each('Out#', 0, 1, 2)} {for_each('Device#State', 0, 1, 2)} "
        f"{for_each('Command#Status', 0, 1, 2)} {_DEVICE}",
        "FaultTimeInv OverrideStateInv ProgCommandInv OperReqInv HandCommandInv",
        hidden=_DEVICE_STATE,
    ),
    "DEDT": block_structure(
        "DEADTIME",
        f"REAL In BOOL InFault REAL Deadtime Gain=1.0 Bias {TIMING}",
        "REAL Out DeltaT",
        "InFaulted DeadtimeInv",
        hidden="BOOL faulted DINT held",
    ),
    "DERV": block_structure(
        "DERIVATIVE",
        f"REAL In Gain=1.0 BOOL ByPass {TIMING}",
        "REAL Out DeltaT",
        "",
        hidden="LREAL x1",
    ),
    "ESEL": block_structure(
        "SELECT_ENHANCED",
        f"REAL {for_each('In#', *range(1, 7))} BOOL {for_each('In#Fault', *range(1, 7))} DINT InsUsed=1 "
        f"SelectorMode ProgSelector OperSelector BOOL {_CONTROL} ProgOverrideReq {_OF_OPERATOR} "
        "ProgValueReset",
        "REAL Out DINT SelectedIn BOOL ProgOper Override",
        "InsFaulted InsUsedInv SelectorModeInv ProgSelectorInv OperSelectorInv",
        hidden="BOOL ran begun",
    ),
    "FGEN": block_structure(
        "FUNCTION_GENERATOR",
        "REAL In DINT XY1Size=1 XY2Size BOOL Select",
        "REAL Out",
        "XY1SizeInv XY2SizeInv XisOutofOrder",
    ),
    "HLL": block_structure(
        "HL_LIMIT",
        "REAL In HighLimit=max LowLimit=-max DINT SelectLimit",
        "REAL Out BOOL HighAlarm LowAlarm",
        "LimitsInv SelectLimitInv",
    ),
    "HPF": block_structure(
        "FILTER_HIGH_PASS",
        f"REAL In BOOL Initialize REAL WLead DINT Order=1 {TIMING}",
        "REAL Out DeltaT",
        "WLeadInv OrderInv",
        hidden=_PAST,
    ),
    "INTG": block_structure(
        "INTEGRATOR",
        "REAL In BOOL Initialize REAL InitialValue IGain HighLimit=max LowLimit=-max "
        f"BOOL HoldHigh HoldLow {TIMING}",
        "REAL Out BOOL HighAlarm LowAlarm REAL DeltaT",
        "IGainInv HighLowLimsInv",
        hidden="LREAL x1 exact",
    ),
    "LDLG": block_structure(
        "LEAD_LAG",
        f"REAL In BOOL Initialize REAL Lead Lag Gain=1.0 Bias {TIMING}",
        "REAL Out DeltaT",
        "LeadInv LagInv",
        hidden=_PAST,
    ),
    "LDL2": block_structure(
        "LEAD_LAG_SEC_ORDER",
        f"REAL In BOOL Initialize REAL WLead WLag ZetaLead ZetaLag=0.05 DINT Order=2 {TIMING}",
        "REAL Out DeltaT",
        "WLeadInv WLagInv ZetaLeadInv ZetaLagInv OrderInv WLagRatioInv",
        hidden=_PAST,
    ),
    "LPF": block_structure(
        "FILTER_LOW_PASS",
        f"REAL In BOOL Initialize REAL WLag=max DINT Order=1 {TIMING}",
        "REAL Out DeltaT",
        "WLagInv OrderInv",
        hidden=_PAST,
    ),
    "MAVE": block_structure(
        "MOVING_AVERAGE",
        "REAL In BOOL InFault Initialize SampleEnable=1 DINT NumberOfSamples=1 BOOL UseWeights",
        "REAL Out",
        "InFaulted NumberOfSampInv",
        hidden="BOOL begun DINT held",
    ),
    "MSTD": block_structure(
        "MOVING_STD_DEV",
        "REAL In BOOL InFault Initialize SampleEnable=1 DINT NumberOfSamples=1",
        "REAL Out Average",
        "InFaulted NumberOfSampInv",
        hidden="BOOL begun DINT held",
    ),
    "NTCH": block_structure(
        "FILTER_NOTCH",
        f"REAL In BOOL Initialize REAL WNotch=max QFactor=0.5 DINT Order=2 {TIMING}",
        "REAL Out DeltaT",
        "WNotchInv QFactorInv OrderInv",
        hidden=_PAST,
    ),
    "PI": block_structure(
        "PROP_INT",
        f"{_INTEGRATES} REAL Kp=min Wld {_BOUNDS} REAL ShapeKpPlus=1.0 ShapeKpMinus=1.0 KpInRange=max "
        f"ShapeWldPlus=1.0 ShapeWldMinus=1.0 WldInRange=max BOOL NonLinearMode ParabolicLinear {TIMING}",
        "REAL Out BOOL HighAlarm LowAlarm REAL DeltaT",
        "KpInv WldInv HighLowLimsInv ShapeKpPlusInv ShapeKpMinusInv KpInRangeInv ShapeWldPlusInv "
        "ShapeWldMinusInv WldInRangeInv",
        hidden="LREAL x1 exact",
    ),
    "PIDE": block_structure(
        "PID_ENHANCED",
        "REAL PV BOOL PVFault REAL PVEUMax=100.0 PVEUMin SPProg SPOper SPCascade SPHLimit=100.0 SPLLimit "
        "BOOL UseRatio REAL RatioProg=1.0 RatioOper=1.0 RatioHLimit=1.0 RatioLLimit=1.0 "
        "BOOL CVFault CVInitReq REAL CVInitValue CVProg CVOper CVOverride CVPrevious "
        "BOOL CVSetPrevious CVManLimiting REAL CVEUMax=100.0 CVEUMin CVHLimit=100.0 CVLLimit CVROCLimit FF "
        "FFPrevious BOOL FFSetPrevious REAL HandFB BOOL HandFBFault WindupHIn WindupLIn ControlAction "
        "DependIndepend REAL PGain IGain DGain BOOL PVEProportional PVEDerivative=1 DSmoothing PVTracking "
        "REAL ZCDeadband BOOL ZCOff REAL PVHHLimit=max PVHLimit=max PVLLimit=-max PVLLLimit=-max PVDeadband "
        "PVROCPosLimit PVROCNegLimit PVROCPeriod DevHHLimit=max DevHLimit=max DevLLimit=max DevLLLimit=max "
        f"DevDeadband BOOL AllowCasRat ManualAfterInit {_CONTROL} ProgCasRatReq ProgAutoReq ProgManualReq "
        f"ProgOverrideReq ProgHandReq {_OF_OPERATOR} OperCasRatReq OperAutoReq OperManualReq ProgValueReset "
        f"{TIMING} BOOL AtuneAcquire AtuneStart AtuneUseGains AtuneAbort AtuneUnacquire",
        "REAL CVEU CV BOOL CVInitializing CVHAlarm CVLAlarm CVROCAlarm REAL SP SPPercent BOOL SPHAlarm "
        "SPLAlarm REAL PVPercent E EPercent BOOL InitPrimary WindupHOut WindupLOut REAL Ratio "
        "BOOL RatioHAlarm RatioLAlarm ZCDeadbandOn PVHHAlarm PVHAlarm PVLAlarm PVLLAlarm PVROCPosAlarm "
        "PVROCNegAlarm DevHHAlarm DevHAlarm DevLAlarm DevLLAlarm ProgOper CasRat Auto Manual Override Hand "
        "REAL DeltaT BOOL AtuneReady AtuneOn AtuneDone AtuneAborted AtuneBusy",
        "PVFaulted CVFaulted HandFBFaulted PVSpanInv SPProgInv SPOperInv SPCascadeInv SPLimitsInv "
        "RatioProgInv RatioOperInv RatioLimitsInv CVProgInv CVOperInv CVOverrideInv CVPreviousInv "
        "CVEUSpanInv CVLimitsInv CVROCLimitInv FFInv FFPreviousInv HandFBInv PGainInv IGainInv DGainInv "
        "ZCDeadbandInv PVDeadbandInv PVROCLimitsInv DevHLLimitsInv DevDeadbandInv",
        hidden="BOOL ran LREAL e1 e2 q1 q2 ff LINT sampled_ns LREAL sample",
        more="AtuneDataInv",
    ),
    "PMUL": block_structure(
        "PULSE_MULTIPLIER",
        "DINT In BOOL Initialize DINT InitialValue BOOL Mode=1 DINT WordSize=14 Multiplier=100000",
        "REAL Out",
        "WordSizeInv OutOverflow LostPrecision MultiplierInv",
        hidden="BOOL begun initializing DINT before LINT remainder",
    ),
    "POSP": block_structure(
        "POSITION_PROP",
        "REAL SP Position BOOL OpenedFB ClosedFB REAL PositionEUMax=100.0 PositionEUMin CycleTime OpenRate "
        "CloseRate MaxOnTime MinOnTime Deadtime",
        "OpenOut CloseOut REAL PositionPercent SPPercent OpenTime CloseTime",
        "CycleTimeInv OpenRateInv CloseRateInv MaxOnTimeInv MinOnTimeInv DeadtimeInv PositionPctInv "
        "SPPercentInv PositionSpanInv",
        hidden=_CYCLE,
    ),
    "RLIM": block_structure(
        "RATE_LIMITER",
        f"REAL In IncRate DecRate BOOL ByPass {TIMING}",
        "REAL Out DeltaT",
        "IncRateInv DecRateInv",
        hidden="LREAL exact",
    ),
    "RMPS": block_structure(
        "RAMP_SOAK",
        "REAL PV BOOL PVFault DINT NumberOfSegs=1 BOOL ManHoldAftInit CyclicSingle TimeRate GuarRamp "
        "REAL RampDeadband BOOL GuarSoak REAL SoakDeadband DINT CurrentSegProg REAL OutProg SoakTimeProg "
        f"DINT CurrentSegOper REAL OutOper SoakTimeOper BOOL {_CONTROL} ProgAutoReq ProgManualReq "
        f"ProgHoldReq {_OF_OPERATOR} OperAutoReq OperManualReq Initialize ProgValueReset",
        "REAL Out DINT CurrentSeg REAL SoakTimeLeft BOOL GuarRampOn GuarSoakOn ProgOper Auto Manual Hold",
        "PVFaulted NumberOfSegsInv RampDeadbandInv SoakDeadbandInv CurrSegProgInv SoakTimeProgInv "
        "CurrSegOperInv SoakTimeOperInv RampValueInv SoakTimeInv",
        hidden="BOOL ran begun soaking LINT last_ns LREAL exact origin left",
    ),
    "SCL": block_structure(
        "SCALE",
        "REAL In InRawMax InRawMin InEUMax InEUMin BOOL Limiting",
        "REAL Out BOOL MaxAlarm MinAlarm",
        "InRawRangeInv",
    ),
    "SCRV": block_structure(
        "S_CURVE",
        "REAL In BOOL Initialize REAL InitialValue BOOL AbsAlgRamp=1 REAL AccelRate DecelRate JerkRate "
        f"BOOL HoldMode HoldEnable {TIMING}",
        "BOOL S_Mode REAL Out Rate DeltaT",
        "AccelRateInv DecelRateInv JerkRateInv",
        hidden="LREAL exact rate",
    ),
    "SOC": block_structure(
        "SEC_ORDER_CONTROLLER",
        f"{_INTEGRATES} REAL Gain=min WLag WLead ZetaLead {_BOUNDS} {TIMING}",
        "REAL Out BOOL HighAlarm LowAlarm REAL DeltaT",
        "GainInv WLagInv WLeadInv ZetaLeadInv HighLowLimsInv",
        hidden="LREAL x1 y1 exact",
    ),
    "SRTP": block_structure(
        "SPLIT_RANGE",
        "REAL In CycleTime MaxHeatIn=100.0 MinHeatIn=50.0 MaxCoolIn MinCoolIn=50.0 MaxHeatTime MinHeatTime "
        "MaxCoolTime MinCoolTime",
        "HeatOut CoolOut REAL HeatTimePercent CoolTimePercent",
        "CycleTimeInv MaxHeatTimeInv MinHeatTimeInv MaxCoolTimeInv MinCoolTimeInv HeatSpanInv CoolSpanInv",
        hidden=_CYCLE,
    ),
    "SSUM": block_structure(
        "SELECTED_SUMMER",
        " ".join(f"REAL In{n} Gain{n}=1.0 BOOL Select{n}" for n in range(1, 9)) + " REAL Bias",
        "REAL Out",
    ),
    "TOT": block_structure(
        "TOTALIZER",
        "REAL In BOOL InFault DINT TimeBase REAL Gain=1.0 ResetValue Target TargetDev1 TargetDev2 "
        f"LowInCutoff BOOL {_CONTROL} ProgStartReq ProgStopReq ProgResetReq {_OF_OPERATOR} OperStartReq "
        f"OperStopReq OperResetReq ProgValueReset {TIMING}",
        "REAL Total OldTotal BOOL ProgOper RunStop ProgResetDone TargetFlag TargetDev1Flag TargetDev2Flag "
        "LowInCutoffFlag REAL DeltaT",
        "InFaulted TimeBaseInv",
        hidden="BOOL ran running asked LREAL x1 exact",
    ),
}
"""Structure of each instruction."""

ARRAYS: Mapping[str, tuple[str, ...]] = {
    "DEDT": ("Storage",),
    "FGEN": ("X1", "Y1", "X2", "Y2"),
    "MAVE": ("Storage", "Weight"),
    "MSTD": ("Storage",),
    "RMPS": ("RampValue", "SoakValue", "SoakTime"),
}
"""Arrays of REAL that a block uses in addition to its structure, in the order of structured text.

Their names in an export can end in `Array`.
"""
