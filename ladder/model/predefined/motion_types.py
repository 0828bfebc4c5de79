"""Data types of motion: axes, motion instructions, groups, coordinate systems, cams.

Bits and members are as in the motion reference manual [MOTION-RM002, appendix "Axis Data Types" and
chapter "Motion Instruction Structure"]. All axis types have the same members here: the members that programs
use most. A program that uses another member is refused at that line. If an L5X uses another member, the
member is added to the type.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..types import BOOL, DINT, DataType, Member, Structure, for_each, members_of, packed_in


def _word(host: str, names: str) -> tuple[Member, ...]:
    """Return a DINT and its bits, starting at bit 0; `-` is a bit without a name."""
    bits = {name: bit for bit, name in enumerate(names.split()) if name != "-"}
    return packed_in(Member(host, DINT), bits)


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
    packed_in(Member("FLAGS", DINT), MOTION_BITS)
    + members_of("INT ERR SINT STATUS STATE DINT SEGMENT SINT EXERR"),
    hidden=members_of("LINT started_ns DINT ticket number"),
)
"""Status of a motion instruction; `ticket` is the number of its request to the axis, `number` the number of
the instruction."""

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
    *members_of(f"REAL {_AXIS_REALS} DINT {_AXIS_NUMBERS}"),
)

PLANNERS = ("move", "jog", "gear", "whole")
"""Motions that an ideal axis can superimpose (see `ideal_axis`); `whole` is for paths and for MAS of All."""


_COURSE = "DINT #kind LINT #begun_ns #claim LREAL #entry #goal #speed #up #down #up_share #down_share"
"""Hidden members of a course (see `courses`); `#` is the prefix of its planner."""

_OF_AXES = members_of(
    "LREAL position LINT shown_ns DINT axis BOOL active "
    f"{for_each(_COURSE, *(f'{planner}_' for planner in PLANNERS))} "
    "LREAL start target ratio watched DINT master watch LINT watch_claim"
)

_ANALOG_MEMBERS = tuple(
    Member("DriveFault", BOOL, at="ServoFault.9") if member.name == "DriveFault" else member
    for member in AXIS_MEMBERS
)
"""Members of an axis with an analog drive. The fault of the drive is a bit of ServoFault."""

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
    """Return whether a type is one of `AXIS_TYPES`, possibly with more members."""
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
        *members_of(
            "DINT Cycle AutoTagUpdate CoarseUpdatePeriod Instance TaskAverageIOTime TaskAverageScanTime "
            "TaskLastIOTime TaskLastScanTime TaskMaximumIOTime TaskMaximumScanTime TimeOffset "
            "LINT CycleStartTime MaximumInterval MinimumInterval StartTime"
        ),
    ),
)

_ENDS = (
    f"LREAL {for_each('from#', *range(6))} {for_each('to#', *range(6))} {for_each('next#', *range(6))} "
    "next_speed next_up next_down next_up_share next_down_share LINT next_claim"
)
"""Start and end of a path, followed by the end and the dynamics of the pending path."""

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
        *members_of(
            "DINT AxesInhibitedStatus AxesShutdownStatus AxesServoOnStatus AxesConfigurationFaulted "
            "REAL ActualPosition[6] CommandPosition[6] "
            "MovePercentComplete DynamicsPercent ActualPositionTolerance CommandPositionTolerance"
        ),
    ),
    hidden=members_of(f"{for_each(_COURSE, '')} DINT number waiting LINT transform {_ENDS}"),
)

CAM = Structure("CAM", members_of("REAL Master Slave DINT SegmentType"))

CAM_PROFILE = Structure(
    "CAM_PROFILE", members_of("DINT Status"), hidden=members_of("REAL master slave c0 c1 c2 c3 DINT kind")
)

OUTPUT_CAM = Structure(
    "OUTPUT_CAM",
    members_of("DINT OutputBit LatchType UnlatchType REAL Left Right Duration DINT EnableType EnableBit"),
)

OUTPUT_COMPENSATION = Structure(
    "OUTPUT_COMPENSATION",
    members_of("REAL Offset LatchDelay UnlatchDelay DINT Mode REAL CycleTime DutyCycle"),
)

BY_CLASS: Mapping[str, Structure] = {
    "AXIS": AXIS_TYPES["AXIS_CIP_DRIVE"],
    "MOTIONGROUP": MOTION_GROUP,
    "COORDINATESYSTEM": COORDINATE_SYSTEM,
}
"""Type of the instances of a class in GSV and SSV, by class in capitals."""

MOTION_TYPES: Mapping[str, Structure] = {
    kind.name: kind
    for kind in (
        *(MOTION_INSTRUCTION, *AXIS_TYPES.values(), MOTION_GROUP, COORDINATE_SYSTEM),
        *(CAM, CAM_PROFILE, OUTPUT_CAM, OUTPUT_COMPENSATION),
    )
}
