"""Attributes for GSV and SSV that the runtime only stores.

Each attribute is a number in the program's memory, with the initial value in its row. SSV and tests may set
it; GSV reads it. Modules run without faults, and a scan takes no time [1756-RM003N, GSV/SSV objects].
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


def _settings(size: int, *names: str) -> dict[str, StoredValue]:
    """Return attributes that SSV may set and that start at 0."""
    return {name: StoredValue(size, set=True) for name in names}


_SCAN_TIMES = {"LASTSCANTIME": StoredValue(DINT, set=True), "MAXSCANTIME": StoredValue(DINT, set=True)}

OBJECTS: Mapping[str, Mapping[str, StoredValue]] = {
    "ADDONINSTRUCTIONDEFINITION": {
        "LASTEDITDATE": StoredValue(LINT),
        "MAJORREVISION": StoredValue(DINT, 1),
        "MINORREVISION": StoredValue(DINT),
        "REVISIONEXTENDEDTEXT": StoredValue(STRING),
        "SAFETYSIGNATUREID": StoredValue(DINT),
        "SIGNATUREID": StoredValue(DINT),
        "VENDOR": StoredValue(STRING),
    },
    "CONTROLLER": {
        "AUDITVALUE": StoredValue(LINT),
        "CANUSERPIFROMPRODUCER": StoredValue(DINT),
        "CHANGESTODETECT": StoredValue(LINT, set=True),
        "CONTROLLERLOGEXECUTIONMODIFICATIONCOUNT": StoredValue(DINT, set=True),
        "CONTROLLERLOGTOTALENTRYCOUNT": StoredValue(DINT, set=True),
        "CONTROLLERLOGUNSAVEDENTRYCOUNT": StoredValue(DINT, set=True),
        "DATATABLEPADPERCENTAGE": StoredValue(INT),
        "IGNOREARRAYFAULTSDURINGPOSTSCAN": StoredValue(SINT, set=True),
        "INHIBITAUTOMATICFIRMWAREUPDATE": StoredValue(INT, set=True),
        "KEEPTESTEDITSONSWITCHOVER": StoredValue(SINT),
        "REDUNDANCYENABLED": StoredValue(SINT),
        "SHAREUNUSEDTIMESLICE": StoredValue(INT, 1, set=True),
        "TIMESLICE": StoredValue(INT, 20, set=True),
    },
    "CONTROLLERDEVICE": {
        "DEVICENAME": StoredValue(33),
        "PRODUCTCODE": StoredValue(INT),
        "PRODUCTREV": StoredValue(INT),
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
        "FANSPEEDS": StoredValue(SINT),
        "FANSTATUS": StoredValue(SINT),
        "TEMPERATUREFAULTLEVELS": StoredValue(SINT),
        "TEMPERATURES": StoredValue(SINT),
        "UPSBATTERYFAILURE": StoredValue(SINT),
        "UPSBUFFERING": StoredValue(SINT),
        "UPSINHIBITED": StoredValue(SINT),
        "UPSREADY": StoredValue(SINT),
        "UPSSUPPORTED": StoredValue(SINT),
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
        "FIRMWARESUPERVISORSTATUS": StoredValue(INT),
        "FORCESTATUS": StoredValue(INT),
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
        **_SCAN_TIMES,
    },
    "REDUNDANCY": {
        "CHASSISREDUNDANCYSTATE": StoredValue(INT),
        "COMPATIBILITYRESULTS": StoredValue(SINT),
        "MODULEREDUNDANCYSTATE": StoredValue(INT),
        "KEEPTESTEDITSONSWITCHOVER": StoredValue(SINT),
        "LASTDATATRANSFERSIZE": StoredValue(DINT),
        "MAXDATATRANSFERSIZE": StoredValue(DINT, set=True),
        "PARTNERCHASSISREDUNDANCYSTATE": StoredValue(INT),
        "PARTNERKEYSWITCH": StoredValue(DINT),
        "PARTNERMINORFAULTS": StoredValue(DINT),
        "PARTNERMODULEREDUNDANCYSTATE": StoredValue(INT),
        "PHYSICALCHASSISID": StoredValue(INT),
        "SRMSLOTNUMBER": StoredValue(INT),
        "PARTNERMODE": StoredValue(DINT),
        "QUALIFICATIONINPROGRESS": StoredValue(INT),
    },
    "ROUTINE": {
        "INSTANCE": StoredValue(DINT),
        "SFCPAUSED": StoredValue(INT, set=True),
        "SFCRESUMING": StoredValue(INT, set=True),
        "SFCRESUMEBITS": StoredValue(INT, set=True),
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
        "RTSOFFDELAY": StoredValue(INT),
        "RTSSENDDELAY": StoredValue(INT),
        "STOPBITS": StoredValue(SINT, 1),
        **_settings(SINT, "PENDINGDATABITS", "PENDINGPARITY", "PENDINGSTOPBITS"),
        **_settings(INT, "PENDINGRTSOFFDELAY", "PENDINGRTSSENDDELAY"),
        **_settings(DINT, "PENDINGBAUDRATE"),
    },
    "TASK": {
        "DISABLEUPDATEOUTPUTS": StoredValue(DINT, set=True),
        "ENABLETIMEOUT": StoredValue(DINT, set=True),
        "INHIBITTASK": StoredValue(DINT, set=True),
        "INSTANCE": StoredValue(DINT),
        "MAXINTERVAL": StoredValue(LINT, set=True),
        "MININTERVAL": StoredValue(LINT, set=True),
        "STARTTIME": StoredValue(LINT, set=True),
        "STATUS": StoredValue(DINT, set=True),
        "WATCHDOG": StoredValue(DINT, 500_000, set=True),
        **_SCAN_TIMES,
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
"""Attributes by class, both in capitals."""

ANY_NAME: Mapping[str, StoredValue] = {"DATALOG": StoredValue(DINT, set=True)}
"""Classes whose attribute list was not available: any attribute name has this value."""


def stored_value(kind: str, name: str) -> StoredValue | None:
    """Return a stored attribute by class and name in capitals; None if there is none."""
    return OBJECTS.get(kind, {}).get(name) or ANY_NAME.get(kind)
