"""Attributes of objects that GSV reads and SSV sets, and that the runtime does not compute.

Each is a number in the program's memory: it begins as its row says, SSV sets it, tests may set it, GSV reads
it. A module is running and has no fault; a scan takes no time [1756-RM003N, GSV/SSV objects].
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

SINT, INT, DINT, LINT = 1, 2, 4, 8
"""Bytes of an attribute."""

STRING = 4 + 82
"""Bytes of a text; it is empty, as all begins with 0."""

RUNNING = 0x4000
"""EntryStatus of a module whose connections are open: 4 in the upper four bits."""


@dataclass(frozen=True, slots=True)
class Kept:
    """An attribute that is memory.

    Attributes:
        size: its bytes.
        initial: what it begins as, in its first eight bytes; the others are 0.
        set: whether SSV may set it.
    """

    size: int
    initial: int = 0
    set: bool = False


def _settings(size: int, *names: str) -> dict[str, Kept]:
    """Return attributes that SSV may set and that start at 0."""
    return {name: Kept(size, set=True) for name in names}


_SCAN_TIMES = {"LASTSCANTIME": Kept(DINT, set=True), "MAXSCANTIME": Kept(DINT, set=True)}

OBJECTS: Mapping[str, Mapping[str, Kept]] = {
    "ADDONINSTRUCTIONDEFINITION": {
        "LASTEDITDATE": Kept(LINT),
        "MAJORREVISION": Kept(DINT, 1),
        "MINORREVISION": Kept(DINT),
        "REVISIONEXTENDEDTEXT": Kept(STRING),
        "SAFETYSIGNATUREID": Kept(DINT),
        "SIGNATUREID": Kept(DINT),
        "VENDOR": Kept(STRING),
    },
    "CONTROLLER": {
        "AUDITVALUE": Kept(LINT),
        "CANUSERPIFROMPRODUCER": Kept(DINT),
        "CHANGESTODETECT": Kept(LINT, set=True),
        "CONTROLLERLOGEXECUTIONMODIFICATIONCOUNT": Kept(DINT, set=True),
        "CONTROLLERLOGTOTALENTRYCOUNT": Kept(DINT, set=True),
        "DATATABLEPADPERCENTAGE": Kept(INT),
        "IGNOREARRAYFAULTSDURINGPOSTSCAN": Kept(SINT, set=True),
        "INHIBITAUTOMATICFIRMWAREUPDATE": Kept(INT, set=True),
        "KEEPTESTEDITSONSWITCHOVER": Kept(SINT),
        "REDUNDANCYENABLED": Kept(SINT),
        "SHAREUNUSEDTIMESLICE": Kept(INT, 1, set=True),
        "TIMESLICE": Kept(INT, 20, set=True),
    },
    "CONTROLLERDEVICE": {
        "DEVICENAME": Kept(33),
        "PRODUCTCODE": Kept(INT),
        "PRODUCTREV": Kept(INT),
        "SERIALNUMBER": Kept(DINT),
        "STATUS": Kept(INT, 0x3060),
        "TYPE": Kept(INT, 14),
        "VENDOR": Kept(INT, 1),
    },
    "CST": {"CURRENTSTATUS": Kept(INT)},
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
        "MAJOREVENTS": Kept(INT, set=True),
        "MAJORFAULTBITS": Kept(DINT, set=True),
        "MINOREVENTS": Kept(INT, set=True),
        "MINORFAULTBITS": Kept(DINT, set=True),
    },
    "MESSAGE": {
        "CONNECTIONPATH": Kept(130, set=True),
        **_settings(SINT, "MESSAGETYPE", "PORT", "TIMEOUTMULTIPLIER"),
        **_settings(DINT, "CONNECTIONRATE", "UNCONNECTEDTIMEOUT"),
    },
    "MODULE": {
        "ENTRYSTATUS": Kept(INT, RUNNING),
        "FAULTCODE": Kept(INT),
        "FAULTINFO": Kept(DINT),
        "FIRMWARESUPERVISORSTATUS": Kept(INT),
        "FORCESTATUS": Kept(INT),
        "INSTANCE": Kept(DINT),
        "LEDSTATUS": Kept(INT, 3),
        "MODE": Kept(INT, set=True),
        "PATH": Kept(64, set=True),
    },
    "PROGRAM": {
        "DISABLEFLAG": Kept(SINT, set=True),
        "INSTANCE": Kept(DINT),
        "MINORFAULTRECORD": Kept(44, set=True),
        "SFCRESTART": Kept(INT, set=True),
        **_SCAN_TIMES,
    },
    "REDUNDANCY": {
        "CHASSISREDUNDANCYSTATE": Kept(INT),
        "COMPATIBILITYRESULTS": Kept(SINT),
        "MODULEREDUNDANCYSTATE": Kept(INT),
        "KEEPTESTEDITSONSWITCHOVER": Kept(SINT),
        "LASTDATATRANSFERSIZE": Kept(DINT),
        "MAXDATATRANSFERSIZE": Kept(DINT, set=True),
        "PARTNERCHASSISREDUNDANCYSTATE": Kept(INT),
        "PARTNERKEYSWITCH": Kept(DINT),
        "PARTNERMINORFAULTS": Kept(DINT),
        "PARTNERMODULEREDUNDANCYSTATE": Kept(INT),
        "PHYSICALCHASSISID": Kept(INT),
        "SRMSLOTNUMBER": Kept(INT),
        "PARTNERMODE": Kept(DINT),
        "QUALIFICATIONINPROGRESS": Kept(INT),
    },
    "ROUTINE": {
        "INSTANCE": Kept(DINT),
        "SFCPAUSED": Kept(INT, set=True),
        "SFCRESUMING": Kept(INT, set=True),
        "SFCRESUMEBITS": Kept(INT, set=True),
    },
    "SAFETY": {
        "SAFETYLOCKEDSTATE": Kept(SINT),
        "SAFETYSTATUS": Kept(INT),
        "SAFETYSIGNATUREEXISTS": Kept(SINT),
        "SAFETYTASKFAULTRECORD": Kept(44),
    },
    "SERIALPORT": {
        "BAUDRATE": Kept(DINT, 19_200),
        "DATABITS": Kept(SINT, 8),
        "PARITY": Kept(SINT),
        "RTSOFFDELAY": Kept(INT),
        "RTSSENDDELAY": Kept(INT),
        "STOPBITS": Kept(SINT, 1),
        **_settings(SINT, "PENDINGDATABITS", "PENDINGPARITY", "PENDINGSTOPBITS"),
        **_settings(INT, "PENDINGRTSOFFDELAY", "PENDINGRTSSENDDELAY"),
        **_settings(DINT, "PENDINGBAUDRATE"),
    },
    "TASK": {
        "DISABLEUPDATEOUTPUTS": Kept(DINT, set=True),
        "ENABLETIMEOUT": Kept(DINT, set=True),
        "INHIBITTASK": Kept(DINT, set=True),
        "INSTANCE": Kept(DINT),
        "MAXINTERVAL": Kept(LINT, set=True),
        "MININTERVAL": Kept(LINT, set=True),
        "STARTTIME": Kept(LINT, set=True),
        "STATUS": Kept(DINT, set=True),
        "WATCHDOG": Kept(DINT, 500_000, set=True),
        **_SCAN_TIMES,
    },
    "TIMESYNCHRONIZE": {
        "CLOCKTYPE": Kept(INT),
        "GRANDMASTERCLOCKINFO": Kept(24),
        "ISSYNCHRONIZED": Kept(DINT),
        "LOCALCLOCKINFO": Kept(20),
        "MANUFACTUREIDENTITY": Kept(DINT),
        "MAXOFFSETFROMMASTER": Kept(LINT, set=True),
        "MEANPATHDELAYTOMASTER": Kept(LINT),
        "NUMBEROFPORTS": Kept(INT),
        "OFFSETFROMMASTER": Kept(LINT),
        "PARENTCLOCKINFO": Kept(16),
        "PRODUCTDESCRIPTION": Kept(68),
        "PTPENABLE": Kept(DINT, set=True),
        "REVISIONDATA": Kept(36),
        "STEPSREMOVED": Kept(INT),
        "SYSTEMTIMEANDOFFSET": Kept(16),
        "USERDESCRIPTION": Kept(132, set=True),
        **_settings(SINT, "DOMAINNUMBER", "PRIORITY1", "PRIORITY2"),
    },
    "WALLCLOCKTIME": {
        "APPLYDST": Kept(DINT, set=True),
        "CSTOFFSET": Kept(LINT, set=True),
        "DSTADJUSTMENT": Kept(INT, set=True),
        "TIMEZONESTRING": Kept(84, set=True),
    },
}
"""Attributes by class, both in capitals."""
