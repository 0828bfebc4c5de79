"""Predefined types that no instruction here works on: their members, for logic that reads them.

Of an axis or a motion group it is the members that programs use most; one that is missing is refused where
it is named. Values in the document have the other members.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..types import BOOL, DINT, INT, REAL, SINT, DataType, Member, Structure


def _members(kind: DataType, names: str, *dims: int) -> tuple[Member, ...]:
    return tuple(Member(name, kind, dims) for name in names.split())


def _bits(host: str, names: str, *, first: int = 0) -> tuple[Member, ...]:
    """Return a DINT and the bits in it."""
    bits = enumerate(names.split(), first)
    return (
        Member(host, DINT),
        *(Member(name, BOOL, at=f"{host}.{bit}") for bit, name in bits if name != "-"),
    )


MOTION_INSTRUCTION = Structure(
    "MOTION_INSTRUCTION",
    (
        Member("FLAGS", DINT),
        *(
            Member(name, BOOL, at=f"FLAGS.{bit}")
            for name, bit in {
                "EN": 31,
                "DN": 29,
                "ER": 28,
                "PC": 27,
                "IP": 26,
                "AC": 23,
                "ACCEL": 1,
                "DECEL": 0,
                "TrackingMaster": 2,
                "CalculatedDataAvailable": 3,
            }.items()
        ),
        *_members(INT, "ERR"),
        *_members(SINT, "STATUS STATE"),
        *_members(DINT, "SEGMENT EXERR"),
    ),
)

_AXIS = (
    *_bits(
        "AxisFault",
        "PhysicalAxisFault ModuleFault ConfigFault GroupFault MotionFault GuardFault InitializationFault "
        "APRFault SafetyFault",
    ),
    *_bits(
        "AxisStatus",
        "ServoActionStatus DriveEnableStatus ShutdownStatus ConfigUpdateInProcess InhibitStatus",
    ),
    *_bits(
        "MotionStatus",
        "AccelStatus DecelStatus MoveStatus JogStatus GearingStatus HomingStatus StoppingStatus "
        "AxisHomedStatus PositionCamStatus TimeCamStatus PositionCamPendingStatus TimeCamPendingStatus "
        "GearingLockStatus PositionCamLockStatus TimeCamLockStatus MasterOffsetMoveStatus "
        "CoordinatedMotionStatus TransformStateStatus ControlledByTransformStatus",
    ),
    *_bits(
        "AxisEvent",
        "WatchEventArmedStatus WatchEventStatus RegEvent1ArmedStatus RegEvent1Status RegEvent2ArmedStatus "
        "RegEvent2Status HomeEventArmedStatus HomeEventStatus",
    ),
    *_bits("OutputCamStatus", ""),
    *_bits("OutputCamPendingStatus", ""),
    *_bits("OutputCamLockStatus", ""),
    *_bits("OutputCamTransitionStatus", ""),
    *_members(
        REAL,
        "ActualPosition StrobeActualPosition StartActualPosition AverageVelocity ActualVelocity "
        "ActualAcceleration WatchPosition Registration1Position Registration2Position CommandPosition "
        "StrobeCommandPosition StartCommandPosition CommandVelocity CommandAcceleration "
        "InterpolatedActualPosition InterpolatedCommandPosition MasterOffset StrobeMasterOffset "
        "StartMasterOffset PositionError PositionIntegratorError VelocityCommand VelocityFeedback "
        "VelocityError VelocityIntegratorError TorqueCommand TorqueFeedback CurrentCommand CurrentFeedback "
        "AccelerationCommand AccelerationFeedback MotorElectricalAngle ServoOutputLevel MarkerDistance "
        "PositionCommand PositionFeedback PositiveDynamicTorqueLimit NegativeDynamicTorqueLimit "
        "MotorCapacity DriveCapacity BusRegulatorCapacity PowerCapacity OutputCurrent OutputVoltage "
        "OutputPower DCBusVoltage PositionLockTolerance MaximumSpeed MaximumAcceleration "
        "MaximumDeceleration HomePosition HomeOffset HomeSpeed HomeReturnSpeed ConversionConstant "
        "SoftTravelLimitPositive SoftTravelLimitNegative MaxPositiveSoftwareTravelLimit "
        "MaxNegativeSoftwareTravelLimit PositionErrorTolerance ActualPositionEnd AverageVelocityTimebase",
    ),
    *_members(DINT, "Registration1Time Registration2Time InterpolationTime ModuleFaults AttributeErrorCode"),
    *_members(DINT, "AttributeErrorID DriveFault AxisState CIPAxisState GuardStatus GuardFaults"),
    *_bits(
        "DriveStatus",
        "AxisEnableStatus AxisReadyStatus AxisInhibitStatus AxisShutdownStatus AbsoluteReferenceStatus "
        "PositionLockStatus VelocityLockStatus VelocityStandstillStatus VelocityThresholdStatus "
        "VelocityLimitStatus AccelerationLimitStatus DecelerationLimitStatus TorqueThresholdStatus "
        "TorqueLimitStatus CurrentLimitStatus ThermalLimitStatus HomeInputStatus Reg1InputStatus "
        "Reg2InputStatus PosOvertravelInputStatus NegOvertravelInputStatus EnableInputStatus "
        "ProcessStatus InPositionStatus DCBusUpStatus",
    ),
    *_bits("CIPAxisFaults", ""),
    *_bits("CIPAxisStatus", ""),
    *_bits("CIPAxisIOStatus", ""),
    *_bits("CIPAxisAlarms", ""),
    *_bits("CIPInitializationFaults", ""),
    *_bits("CIPStartInhibits", ""),
    *_bits("CIPAPRFaults", ""),
    *_bits("ServoStatus", ""),
    *_bits("ServoFault", ""),
    *_bits(
        "ServoFaultBits",
        "PosSoftOvertravelFault NegSoftOvertravelFault PosHardOvertravelFault NegHardOvertravelFault "
        "FeedbackFault FeedbackNoiseFault PositionErrorFault DriveHardFault ExcessivePositionFault "
        "SoftTravelLimitFault OvertravelFault",
    ),
)

_GROUP = (
    *_bits("GroupStatus", "InhibStatus GroupSynced AxisInhibitStatus TimerEvent"),
    *_members(DINT, "MotionFault ServoFault GroupFault"),
    *_members(DINT, "AutoTagUpdate Cycle CoarseUpdatePeriod"),
    *_members(BOOL, "ACAsyncConnFault ACSyncConnFault GroupOverlapFault"),
)

_COORDINATE = (
    *_bits(
        "CoordinateSystemStatus",
        "ServoActStatus ShutdownStatus ReadyStatus MotionStatus",
    ),
    *_bits(
        "CoordinateMotionStatus",
        "AccelStatus DecelStatus ActualPosToleranceStatus CommandPosToleranceStatus StoppingStatus "
        "MoveStatus TransitionStatus MovePendingStatus MovePendingQueueFullStatus TransformSourceStatus "
        "TransformTargetStatus",
    ),
    *_bits("AxisFault", "PhysicalAxisFault ModuleFault ConfigFault"),
    *_members(DINT, "AxesInhibitedStatus AxesShutdownStatus AxesServoOnStatus AxesConfigurationFaulted"),
    *_members(REAL, "ActualPosition CommandPosition", 6),
    *_members(REAL, "MovePercentComplete DynamicsPercent"),
)

_PHASE = (
    *_members(DINT, "State Substate StepIndex Failure UnitID Owner PendingRequest"),
    *_members(
        BOOL,
        "Running Holding Restarting Stopping Aborting Resetting Idle Held Complete Stopped Aborted "
        "Pausing Paused AutoPause Step NewInputParameters Producing Standby",
    ),
)

PREDEFINED: Mapping[str, DataType] = {
    each.name: each
    for each in (
        MOTION_INSTRUCTION,
        *(
            Structure(name, _AXIS)
            for name in (
                *("AXIS_CIP_DRIVE", "AXIS_SERVO", "AXIS_SERVO_DRIVE", "AXIS_VIRTUAL", "AXIS_CONSUMED"),
                *("AXIS_GENERIC", "AXIS_GENERIC_DRIVE"),
            )
        ),
        Structure("MOTION_GROUP", _GROUP),
        Structure("COORDINATE_SYSTEM", _COORDINATE),
        Structure("PHASE", _PHASE),
        Structure(
            "CAM",
            (*_members(REAL, "Master Slave"), *_members(DINT, "SegmentType")),
        ),
        Structure(
            "CAM_PROFILE",
            (*_members(DINT, "Status CurveType"), *_members(REAL, "Start C0 C1 C2 C3")),
        ),
        Structure(
            "OUTPUT_CAM",
            (
                *_members(DINT, "OutputBit LatchType UnlatchType"),
                *_members(REAL, "Left Right Duration"),
                *_members(DINT, "EnableType EnableBit"),
            ),
        ),
        Structure(
            "OUTPUT_COMPENSATION",
            (
                *_members(REAL, "Offset LatchDelay UnlatchDelay"),
                *_members(DINT, "Mode"),
                *_members(REAL, "CycleTime DutyCycle"),
            ),
        ),
        Structure(
            "CONNECTION_STATUS",
            (*_members(BOOL, "RunMode ConnectionFaulted"),),
        ),
        Structure("PHASE_INSTRUCTION", (*_members(DINT, "Status"), *_members(BOOL, "EN DN ER WA ABORT"))),
        Structure(
            "SFC_STEP",
            (
                *_members(DINT, "Status"),
                *_members(BOOL, "X FS SA LS DN OV AlarmEn AlarmLow AlarmHigh Reset PauseTimer"),
                *_members(DINT, "PRE T TMax Count LimitLow LimitHigh"),
            ),
        ),
        Structure(
            "SFC_ACTION",
            (*_members(DINT, "Status"), *_members(BOOL, "A Q"), *_members(DINT, "PRE T Count")),
        ),
        Structure("SFC_STOP", (*_members(DINT, "X Count"), *_members(BOOL, "Reset"))),
        Structure(
            "SERIAL_PORT_CONTROL",
            (
                *_members(BOOL, "EN EU DN RN EM ER FD"),
                *_members(DINT, "LEN POS ERROR"),
            ),
        ),
        Structure("DATALOG_INSTRUCTION", (*_members(BOOL, "EN DN ER IP"), *_members(DINT, "ERR"))),
        Structure("EXT_ROUTINE_CONTROL", (*_members(SINT, "ErrorCode NumParams"), *_members(DINT, "Flags"))),
        Structure("ALARM_SET_CONTROL", (*_members(BOOL, "LastState"), *_members(DINT, "InstanceID"))),
    )
}
"""By name in capitals."""
