"""Attributes for GSV and SSV that the runtime only stores.

Each attribute is a number in the program's memory, with the initial value from its row. SSV and tests can set
the number, and GSV reads it. Modules run without faults, and a scan takes no time [1756-RM003N, GSV/SSV
objects].
"""

from __future__ import annotations

from collections.abc import Mapping

from scanrack.io_images.dataclass import dataclass

SINT, INT, DINT, LINT = 1, 2, 4, 8
"""Sizes of attributes, in bytes."""

STRING = 4 + 82
"""Size of a text, in bytes; it is initially empty."""

RUNNING = 0x4000
"""EntryStatus of a module with open connections: 4 in the upper four bits."""


@dataclass(frozen=True, slots=True)
class StoredValue:
    """A stored attribute."""

    size: int  # size in bytes
    initial: int = 0  # initial value of the first eight bytes; the others are 0
    set: bool = False  # whether SSV may set it


def _zeros(size: int, *names: str) -> dict[str, StoredValue]:
    """Return attributes that start at 0 and that SSV can't set."""
    return {name: StoredValue(size) for name in names}


def _settings(size: int, *names: str) -> dict[str, StoredValue]:
    """Return attributes that start at 0 and that SSV can set."""
    return {name: StoredValue(size, set=True) for name in names}


OBJECTS: Mapping[str, Mapping[str, StoredValue]] = {
    "ADDONINSTRUCTIONDEFINITION": {
        "LASTEDITDATE": StoredValue(LINT),
        "MAJORREVISION": StoredValue(DINT, 1),
        "MINORREVISION": StoredValue(DINT),
        "REVISIONEXTENDEDTEXT": StoredValue(STRING),
        **_zeros(DINT, "SAFETYSIGNATUREID", "SIGNATUREID"),
        "VENDOR": StoredValue(STRING),
    },
    "CONTROLLER": {
        "AUDITVALUE": StoredValue(LINT),
        "CANUSERPIFROMPRODUCER": StoredValue(DINT),
        "CHANGESTODETECT": StoredValue(LINT, set=True),
        **_settings(
            DINT,
            "CONTROLLERLOGEXECUTIONMODIFICATIONCOUNT",
            "CONTROLLERLOGTOTALENTRYCOUNT",
            "CONTROLLERLOGUNSAVEDENTRYCOUNT",
        ),
        "DATATABLEPADPERCENTAGE": StoredValue(INT),
        "IGNOREARRAYFAULTSDURINGPOSTSCAN": StoredValue(SINT, set=True),
        "INHIBITAUTOMATICFIRMWAREUPDATE": StoredValue(INT, set=True),
        **_zeros(SINT, "KEEPTESTEDITSONSWITCHOVER", "REDUNDANCYENABLED"),
        "SHAREUNUSEDTIMESLICE": StoredValue(INT, 1, set=True),
        "TIMESLICE": StoredValue(INT, 20, set=True),
    },
    "CONTROLLERDEVICE": {
        "DEVICENAME": StoredValue(33),
        **_zeros(INT, "PRODUCTCODE", "PRODUCTREV"),
        "SERIALNUMBER": StoredValue(DINT),
        "STATUS": StoredValue(INT, 0x3060),
        "TYPE": StoredValue(INT, 14),
        "VENDOR": StoredValue(INT, 1),
    },
    "CST": {"CURRENTSTATUS": StoredValue(INT)},
    "DF1": {
        **_settings(
            SINT,
            *("DUPLICATEDETECTION", "EMBEDDEDRESPONSEENABLE", "ENABLESTOREFWD", "ENQTRANSMITLIMIT"),
            *("EOTSUPPRESSION", "ERRORDETECTION", "MASTERMESSAGETRANSMIT", "MAXSTATIONADDRESS"),
            *("NAKRECEIVELIMIT", "POLLINGMODE", "TOKENHOLDFACTOR", "TRANSMITRETRIES"),
        ),
        **_settings(INT, "NORMALPOLLGROUPSIZE", "STATIONADDRESS"),
        **_settings(DINT, "ACKTIMEOUT", "REPLYMESSAGEWAIT", "SLAVEPOLLTIMEOUT"),
    },
    "FAULTLOG": {
        "MAJOREVENTS": StoredValue(INT, set=True),
        "MAJORFAULTBITS": StoredValue(DINT, set=True),
        "MINOREVENTS": StoredValue(INT, set=True),
        "MINORFAULTBITS": StoredValue(DINT, set=True),
    },
    "HARDWARESTATUS": {  # no fans, sensors or UPS: the first SINT of each array is their number, 0
        **_zeros(
            SINT,
            *("FANSPEEDS", "FANSTATUS", "TEMPERATUREFAULTLEVELS", "TEMPERATURES"),
            *("UPSBATTERYFAILURE", "UPSBUFFERING", "UPSINHIBITED", "UPSREADY", "UPSSUPPORTED"),
        ),
    },
    "MESSAGE": {
        "CONNECTIONPATH": StoredValue(130, set=True),
        **_settings(SINT, "MESSAGETYPE", "PORT", "TIMEOUTMULTIPLIER"),
        **_settings(DINT, "CONNECTIONRATE", "UNCONNECTEDTIMEOUT"),
    },
    "MODULE": {
        "ENTRYSTATUS": StoredValue(INT, RUNNING),
        "FAULTCODE": StoredValue(INT),
        "FAULTINFO": StoredValue(DINT),
        **_zeros(INT, "FIRMWARESUPERVISORSTATUS", "FORCESTATUS"),
        "INSTANCE": StoredValue(DINT),
        "LEDSTATUS": StoredValue(INT, 3),
        "MODE": StoredValue(INT, set=True),
        "PATH": StoredValue(64, set=True),
    },
    "PROGRAM": {
        "DISABLEFLAG": StoredValue(SINT, set=True),
        "INSTANCE": StoredValue(DINT),
        "MINORFAULTRECORD": StoredValue(44, set=True),
        "SFCRESTART": StoredValue(INT, set=True),
        **_settings(DINT, "LASTSCANTIME", "MAXSCANTIME"),
    },
    "REDUNDANCY": {
        "CHASSISREDUNDANCYSTATE": StoredValue(INT),
        "COMPATIBILITYRESULTS": StoredValue(SINT),
        "MODULEREDUNDANCYSTATE": StoredValue(INT),
        "KEEPTESTEDITSONSWITCHOVER": StoredValue(SINT),
        "LASTDATATRANSFERSIZE": StoredValue(DINT),
        "MAXDATATRANSFERSIZE": StoredValue(DINT, set=True),
        "PARTNERCHASSISREDUNDANCYSTATE": StoredValue(INT),
        **_zeros(DINT, "PARTNERKEYSWITCH", "PARTNERMINORFAULTS"),
        **_zeros(INT, "PARTNERMODULEREDUNDANCYSTATE", "PHYSICALCHASSISID", "SRMSLOTNUMBER"),
        "PARTNERMODE": StoredValue(DINT),
        "QUALIFICATIONINPROGRESS": StoredValue(INT),
    },
    "ROUTINE": {
        "INSTANCE": StoredValue(DINT),
        **_settings(INT, "SFCPAUSED", "SFCRESUMING", "SFCRESUMEBITS"),
    },
    "SAFETY": {
        "SAFETYLOCKEDSTATE": StoredValue(SINT),
        "SAFETYSTATUS": StoredValue(INT),
        "SAFETYSIGNATUREEXISTS": StoredValue(SINT),
        "SAFETYTASKFAULTRECORD": StoredValue(44),
    },
    "SERIALPORT": {
        "BAUDRATE": StoredValue(DINT, 19_200),
        "DATABITS": StoredValue(SINT, 8),
        "PARITY": StoredValue(SINT),
        **_zeros(INT, "RTSOFFDELAY", "RTSSENDDELAY"),
        "STOPBITS": StoredValue(SINT, 1),
        **_settings(SINT, "PENDINGDATABITS", "PENDINGPARITY", "PENDINGSTOPBITS"),
        **_settings(INT, "PENDINGRTSOFFDELAY", "PENDINGRTSSENDDELAY"),
        **_settings(DINT, "PENDINGBAUDRATE"),
    },
    "TASK": {
        **_settings(DINT, "DISABLEUPDATEOUTPUTS", "ENABLETIMEOUT", "INHIBITTASK"),
        "INSTANCE": StoredValue(DINT),
        **_settings(LINT, "MAXINTERVAL", "MININTERVAL", "STARTTIME"),
        "STATUS": StoredValue(DINT, set=True),
        "WATCHDOG": StoredValue(DINT, 500_000, set=True),
        **_settings(DINT, "LASTSCANTIME", "MAXSCANTIME"),
    },
    "TIMESYNCHRONIZE": {
        "CLOCKTYPE": StoredValue(INT),
        "GRANDMASTERCLOCKINFO": StoredValue(24),
        "ISSYNCHRONIZED": StoredValue(DINT),
        "LOCALCLOCKINFO": StoredValue(20),
        "MANUFACTUREIDENTITY": StoredValue(DINT),
        "MAXOFFSETFROMMASTER": StoredValue(LINT, set=True),
        "MEANPATHDELAYTOMASTER": StoredValue(LINT),
        "NUMBEROFPORTS": StoredValue(INT),
        "OFFSETFROMMASTER": StoredValue(LINT),
        "PARENTCLOCKINFO": StoredValue(16),
        "PRODUCTDESCRIPTION": StoredValue(68),
        "PTPENABLE": StoredValue(DINT, set=True),
        "REVISIONDATA": StoredValue(36),
        "STEPSREMOVED": StoredValue(INT),
        "SYSTEMTIMEANDOFFSET": StoredValue(16),
        "USERDESCRIPTION": StoredValue(132, set=True),
        **_settings(SINT, "DOMAINNUMBER", "PRIORITY1", "PRIORITY2"),
    },
    "WALLCLOCKTIME": {
        "APPLYDST": StoredValue(DINT, set=True),
        "CSTOFFSET": StoredValue(LINT, set=True),
        "DSTADJUSTMENT": StoredValue(INT, set=True),
        "TIMEZONESTRING": StoredValue(84, set=True),
    },
}
"""Attributes by class; class and attribute names are in capitals."""

ANY_NAME: Mapping[str, StoredValue] = {"DATALOG": StoredValue(DINT, set=True)}
"""Classes whose attribute lists were not available, so any attribute name has this value."""


def stored_value(kind: str, name: str) -> StoredValue | None:
    """Return a stored attribute by class and name, both in capitals; None if unknown."""
    return OBJECTS.get(kind, {}).get(name) or ANY_NAME.get(kind)
