"""Data types of motion: axes, motion instructions, groups, coordinate systems, cams.

Bits and members are those of the motion reference manual [MOTION-RM002, appendix "Axis Data Types" and
chapter "Motion Instruction Structure"]. All types of axis have the same members here: the ones that programs
use most. A missing member is an error at its line; an L5X adds it to the type.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..types import BOOL, DINT, INT, LINT, LREAL, REAL, SINT, DataType, Member, Structure, members


def _word(host: str, names: str = "") -> tuple[Member, ...]:
    """Return a DINT, and its bits from bit 0 on; `-` is a bit without a name."""
    bits = enumerate(names.split())
    return (
        Member(host, DINT),
        *(Member(name, BOOL, at=f"{host}.{bit}") for bit, name in bits if name != "-"),
    )


MOTION_BITS = {
    "EN": 31,
    "DN": 29,
    "ER": 28,
    "PC": 27,
    "IP": 26,
    "AC": 23,
    "DECEL": 1,
    "ACCEL": 0,
    "TrackingMaster": 2,
    "CalculatedDataAvailable": 3,
}
"""Bits of FLAGS of a MOTION_INSTRUCTION."""

MOTION_INSTRUCTION = Structure(
    "MOTION_INSTRUCTION",
    (
        Member("FLAGS", DINT),
        *(Member(name, BOOL, at=f"FLAGS.{bit}") for name, bit in MOTION_BITS.items()),
        *(Member("ERR", INT), Member("STATUS", SINT), Member("STATE", SINT)),
        *(Member("SEGMENT", DINT), Member("EXERR", SINT)),
    ),
    hidden=(Member("started_ns", LINT), *members(DINT, "ticket number")),
)
"""Status of a motion instruction; `ticket` is the number of its request to the axis, `number` its own."""

_MOTION_STATUS = (
    "AccelStatus DecelStatus MoveStatus JogStatus GearingStatus HomingStatus StoppingStatus AxisHomedStatus "
    "PositionCamStatus TimeCamStatus PositionCamPendingStatus TimeCamPendingStatus GearingLockStatus "
    "PositionCamLockStatus TimeCamLockStatus MasterOffsetMoveStatus CoordinatedMotionStatus "
    "TransformStateStatus ControlledByTransformStatus DirectVelocityControlStatus DirectTorqueControlStatus"
)
_DRIVE_STATUS = (
    "ServoActionStatus DriveEnableStatus ShutdownStatus ConfigUpdateInProcess InhibitStatus "
    "DirectControlStatus AxisUpdateStatus"
)
_AXIS_EVENT = (
    "WatchEventArmedStatus WatchEventStatus RegEvent1ArmedStatus RegEvent1Status RegEvent2ArmedStatus "
    "RegEvent2Status HomeEventArmedStatus HomeEventStatus"
)
_AXIS_FAULT = (
    "PhysicalAxisFault ModuleFault ConfigFault GroupFault MotionFault GuardFault InitializationFault "
    "APRFault SafetyFault"
)
_SERVO_FAULT = (
    "PosSoftOvertravelFault NegSoftOvertravelFault PosHardOvertravelFault NegHardOvertravelFault "
    "FeedbackFault FeedbackNoiseFault AuxFeedbackFault AuxFeedbackNoiseFault PositionErrorFault "
    "DriveHardFault DriveFaultBit SoftTravelLimitFault OvertravelFault ExcessivePositionFault "
    "ExcessiveVelocityFault MotorFeedbackFault CommutationFault GroundShortFault DriveOvertempFault "
    "DriveUndervoltageFault DriveOvervoltageFault MotorOvertempFault DriveOvercurrentFault"
)
_CIP_STATUS = (
    "LocalControlStatus AlarmStatus DCBusUpStatus PowerStructureEnabledStatus MotorFluxUpStatus "
    "TrackingCommandStatus PositionLockStatus VelocityLockStatus VelocityStandstillStatus "
    "VelocityThresholdStatus VelocityLimitStatus AccelerationLimitStatus DecelerationLimitStatus "
    "TorqueThresholdStatus TorqueLimitStatus CurrentLimitStatus ThermalLimitStatus "
    "FeedbackIntegrityStatus ShutdownCIPStatus InProcessStatus DCBusUnloadStatus ACPowerLossStatus "
    "PositionControlModeStatus VelocityControlModeStatus TorqueControlModeStatus InPositionStatus "
    "AxisReadyStatus AxisInhibitStatus AbsoluteReferenceStatus EnableInputStatus ProcessStatus"
)
_IO_STATUS = (
    "HomeInputStatus Reg1InputStatus Reg2InputStatus PosOvertravelInputStatus NegOvertravelInputStatus "
    "AxisEnableStatus AxisShutdownStatus"
)

_AXIS_REALS = (
    "ActualPosition StrobeActualPosition StartActualPosition AverageVelocity ActualVelocity "
    "ActualAcceleration WatchPosition Registration1Position Registration2Position CommandPosition "
    "StrobeCommandPosition StartCommandPosition CommandVelocity CommandAcceleration "
    "InterpolatedActualPosition InterpolatedCommandPosition MasterOffset StrobeMasterOffset "
    "StartMasterOffset PositionCommand PositionFeedback AuxPositionFeedback PositionError "
    "PositionIntegratorError VelocityCommand VelocityFeedback VelocityError VelocityIntegratorError "
    "AccelerationCommand AccelerationFeedback MarkerDistance VelocityOffset TorqueOffset TorqueCommand "
    "TorqueFeedback TorqueReference CurrentCommand CurrentReference CurrentFeedback CurrentError "
    "PositiveDynamicTorqueLimit NegativeDynamicTorqueLimit MotorCapacity DriveCapacity PowerCapacity "
    "BusRegulatorCapacity MotorElectricalAngle OutputCurrent OutputVoltage OutputPower OutputFrequency "
    "DCBusVoltage ServoOutputLevel ConversionConstant AverageVelocityTimebase PositionUnwind "
    "PositionLockTolerance PositionErrorTolerance MaximumSpeed MaximumAcceleration MaximumDeceleration "
    "MaximumAccelerationJerk MaximumDecelerationJerk HomePosition HomeOffset HomeSpeed HomeReturnSpeed "
    "SoftTravelLimitPositive SoftTravelLimitNegative MaximumPositiveTravel MaximumNegativeTravel "
    "PositionServoBandwidth VelocityServoBandwidth PositionProportionalGain PositionIntegralGain "
    "VelocityProportionalGain VelocityIntegralGain VelocityFeedforwardGain AccelerationFeedforwardGain "
    "TorqueLimitPositive TorqueLimitNegative VelocityLimitPositive VelocityLimitNegative TorqueThreshold "
    "MotorOverloadLimit RegistrationPosition SystemInertia LoadInertiaRatio BusVoltage"
)
_AXIS_NUMBERS = (
    "Registration1Time Registration2Time Registration1NegEdgePosition Registration2NegEdgePosition "
    "InterpolationTime StrobeTime AxisState CIPAxisState ModuleFaults AttributeErrorCode AttributeErrorID "
    "CIPAxisFaults CIPAxisAlarms CIPAxisIOStatus CIPInitializationFaults CIPStartInhibits CIPAPRFaults "
    "GuardStatus GuardFaults DriveFault DriveWarning ServoStatus AxisInstance GroupInstance MapInstance "
    "MemoryUse MemoryUsage AxisType OutputCamStatus OutputCamPendingStatus OutputCamLockStatus "
    "OutputCamTransitionStatus OutputCamExecutionTargets HomeMode HomeDirection HomeSequence "
    "MotionResolution StoppingAction ShutdownAction"
)

AXIS_MEMBERS: tuple[Member, ...] = (
    *_word("AxisFault", _AXIS_FAULT),
    *_word("AxisStatus", _DRIVE_STATUS),
    *_word("MotionStatus", _MOTION_STATUS),
    *_word("AxisEvent", _AXIS_EVENT),
    *_word("ServoFault", _SERVO_FAULT),
    *_word("CIPAxisStatus", _CIP_STATUS),
    *_word("DriveStatus", _IO_STATUS),
    *members(REAL, _AXIS_REALS),
    *members(DINT, _AXIS_NUMBERS),
)

PLANNERS = ("move", "jog", "gear", "whole")
"""Motions that an ideal axis can superimpose, see `ideal_axis`; `whole` is for paths and for MAS of All."""


def _course(prefix: str = "") -> tuple[Member, ...]:
    """Return the members of a course, see `courses`."""
    names = (DINT, "kind"), (LINT, "begun_ns claim"), (LREAL, "entry goal speed up down up_share down_share")
    return tuple(Member(f"{prefix}{each}", kind) for kind, some in names for each in some.split())


_OF_AXES = (
    *(Member("position", LREAL), Member("shown_ns", LINT), Member("axis", DINT), Member("active", BOOL)),
    *(member for planner in PLANNERS for member in _course(f"{planner}_")),
    *members(LREAL, "start target ratio watched"),
    *members(DINT, "master watch"),
    *members(LINT, "watch_claim"),
)

_ANALOG_MEMBERS = tuple(
    Member("DriveFault", BOOL, at="ServoFault.9") if each.name == "DriveFault" else each
    for each in AXIS_MEMBERS
)
"""Members of an axis with an analog drive, whose fault is a bit of ServoFault."""

AXIS_TYPES: Mapping[str, Structure] = {
    **{
        name: Structure(name, AXIS_MEMBERS, hidden=_OF_AXES)
        for name in (
            "AXIS_CIP_DRIVE",
            "AXIS_SERVO_DRIVE",
            "AXIS_VIRTUAL",
            "AXIS_CONSUMED",
            "AXIS_GENERIC_DRIVE",
        )
    },
    **{name: Structure(name, _ANALOG_MEMBERS, hidden=_OF_AXES) for name in ("AXIS_SERVO", "AXIS_GENERIC")},
}
"""The axis types by name. `position` is ActualPosition in double precision at `shown_ns`. `axis` is the axis
number: above 0 on a 3601, below 0 for an ideal axis. Other hidden members are the state of an ideal axis."""


def is_axis(kind: DataType) -> bool:
    """Whether a type is one of `AXIS_TYPES`, possibly with more members."""
    return isinstance(kind, Structure) and kind.name in AXIS_TYPES and kind.hidden == _OF_AXES


MOTION_GROUP = Structure(
    "MOTION_GROUP",
    (
        *_word("GroupStatus", "InhibStatus GroupSynced TimerEvent"),
        *_word("MotionFault", "ACAsyncConnFault ACSyncConnFault"),
        *_word(
            "ServoFault",
            "POtrvlFault NOtrvlFault PosErrorFault EncCHALossFault EncCHBLossFault EncCHZLossFault "
            "EncNsFault DriveFault SyncConnFault HardFault",
        ),
        *_word("GroupFault", "GroupOverlapFault CSTLossFault GroupTaskLoadingFault"),
        *_word(
            "AxisFault",
            "PhysicalAxisFault ModuleFault ConfigFault AxisMotionFault AxisGuardFault InitializationFault",
        ),
        *members(
            DINT, "Cycle AutoTagUpdate CoarseUpdatePeriod Instance TaskAverageIOTime TaskAverageScanTime"
        ),
        *members(DINT, "TaskLastIOTime TaskLastScanTime TaskMaximumIOTime TaskMaximumScanTime TimeOffset"),
        *members(LINT, "CycleStartTime MaximumInterval MinimumInterval StartTime"),
    ),
)

_ENDS = (
    *(Member(f"{end}{place}", LREAL) for end in ("from", "to", "next") for place in range(6)),
    *members(LREAL, "next_speed next_up next_down next_up_share next_down_share"),
    *members(LINT, "next_claim"),
)
"""Start and end of a path, then the end and the dynamics of the pending path."""

COORDINATE_SYSTEM = Structure(
    "COORDINATE_SYSTEM",
    (
        *_word("CoordinateSystemStatus", "ServoActStatus ShutdownStatus ReadyStatus MotionStatus"),
        *_word(
            "CoordinateMotionStatus",
            "AccelStatus DecelStatus ActualPosToleranceStatus CommandPosToleranceStatus StoppingStatus - "
            "MoveStatus MoveTransitionStatus MovePendingStatus MovePendingQueueFullStatus "
            "TransformSourceStatus TransformTargetStatus CoordMotionLockStatus",
        ),
        *_word("AxisFault", "PhysicalAxisFault ModuleFault ConfigFault"),
        *members(DINT, "AxesInhibitedStatus AxesShutdownStatus AxesServoOnStatus AxesConfigurationFaulted"),
        *members(REAL, "ActualPosition CommandPosition", 6),
        *members(
            REAL, "MovePercentComplete DynamicsPercent ActualPositionTolerance CommandPositionTolerance"
        ),
    ),
    hidden=(*_course(), *members(DINT, "number waiting"), *members(LINT, "transform"), *_ENDS),
)

CAM = Structure("CAM", (*members(REAL, "Master Slave"), Member("SegmentType", DINT)))

CAM_PROFILE = Structure(
    "CAM_PROFILE",
    (Member("Status", DINT),),
    hidden=(*members(REAL, "master slave c0 c1 c2 c3"), Member("kind", DINT)),
)

OUTPUT_CAM = Structure(
    "OUTPUT_CAM",
    (
        *members(DINT, "OutputBit LatchType UnlatchType"),
        *members(REAL, "Left Right Duration"),
        *members(DINT, "EnableType EnableBit"),
    ),
)

OUTPUT_COMPENSATION = Structure(
    "OUTPUT_COMPENSATION",
    (
        *members(REAL, "Offset LatchDelay UnlatchDelay"),
        Member("Mode", DINT),
        *members(REAL, "CycleTime DutyCycle"),
    ),
)

BY_CLASS: Mapping[str, Structure] = {
    "AXIS": AXIS_TYPES["AXIS_CIP_DRIVE"],
    "MOTIONGROUP": MOTION_GROUP,
    "COORDINATESYSTEM": COORDINATE_SYSTEM,
}
"""Type of the instances of a class in GSV and SSV, by class in capitals."""

MOTION_TYPES: Mapping[str, Structure] = {
    each.name: each
    for each in (
        *(MOTION_INSTRUCTION, *AXIS_TYPES.values(), MOTION_GROUP, COORDINATE_SYSTEM),
        *(CAM, CAM_PROFILE, OUTPUT_CAM, OUTPUT_COMPENSATION),
    )
}
