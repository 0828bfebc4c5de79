"""Readings: what the pages leave open about the drives, and the choice made.

Confidence: A follows from two sources, B is an analogy with the 3601 or a neighbor model, C is a guess. An
option switches a guess that another unit may settle otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class DriveReading:
    """A choice where the pages are silent or contradict each other.

    Attributes:
        id: such as "R-15".
        place: what is open.
        text: what scanrack does.
        confidence: "A", "B" or "C".
        options: names of the options of a simulated drive that switch it; empty for none.
        fixed_because: why a reading of confidence C has no option.
    """

    id: str
    place: str
    text: str
    confidence: str
    options: tuple[str, ...] = ()
    fixed_because: str = ""


_NO_DEVICE = "no other choice is known"

READINGS: tuple[DriveReading, ...] = (
    DriveReading(
        "R-01",
        "Codes of the input functions: their page is not known; SMD p. 13 lists eight functions.",
        "0 general purpose, 1 CW limit, 2 CCW limit, 3 start indexed move, 4 stop jog or registration move, "
        "5 capture encoder, 6 emergency stop, 7 home.",
        "C",
        ("input_codes",),
    ),
    DriveReading(
        "R-02",
        "Place of Binary_Endian: the EDS names bits 8 and 9 only, SMD p. 67 three bits.",
        "Bit 10 of configuration word 1: 0 is the high word first, 1 the low word first.",
        "C",
        ("low_word_first",),
    ),
    DriveReading("R-03", "Not used.", "Not used.", "A"),
    DriveReading(
        "R-04",
        "Format of the starting speed when binary formats are configured.",
        "It is always in thousands: SMD p. 59 introduces the two words for it, p. 67 does not list it.",
        "B",
    ),
    DriveReading("R-05", "Configuration words 5 and 9.", "They must be 0.", "B"),
    DriveReading(
        "R-06",
        "Bits of configuration word 1 that save to flash and read back.",
        "Bit 14 saves a valid configuration when configuration mode is left. Bit 11 shows the present "
        "configuration; no new values are taken while it is on. Bit 15 is ignored.",
        "C",
        ("save_bit", "read_back_bit"),
    ),
    DriveReading(
        "R-07",
        "The list of invalid configurations is that of the SD17060E (SD p. 55).",
        "It applies to the whole SMD family. Two inputs may be general purpose. The encoder of a unit "
        "without one is an error, and so is a starting speed above 1,999,999.",
        "B",
    ),
    DriveReading(
        "R-08",
        "Bits 2 and 3 of command word 1: reserved in SMD p. 72, bit 2 an encoder move in EDS and K p. 69.",
        "Bit 2 works with an encoder. Another reserved bit is a command error with the next command.",
        "B",
    ),
    DriveReading(
        "R-09",
        "Status at power-up.",
        "6408h: module OK, configuration error, position invalid, stopped.",
        "A",
    ),
    DriveReading(
        "R-10",
        "Bit 5 of status word 1: PLC in program mode in the EDS, reserved in 17 p. 84.",
        "It shows an idle scanner or a PLC that is not in run mode; over Modbus it is 0.",
        "B",
    ),
    DriveReading("R-11", "Rate of the heartbeat.", "It changes every 500 ms.", "C", ("heartbeat_ms",)),
    DriveReading(
        "R-12",
        "Positions beyond 32,767,999 steps in thousands, which the manual calls indeterminate.",
        "The upper word wraps as on a 3601. Targets are limited to -8,388,608 to 8,388,607 in each format.",
        "B",
    ),
    DriveReading(
        "R-13",
        "Moves too short for their speed, with jerk.",
        "The top speed is lowered until both ramps fit the distance; the final position is exact.",
        "B",
    ),
    DriveReading(
        "R-14",
        "Bit 13 of command word 1, encoder to position.",
        "Preset Position takes the encoder's value and ignores words 2 and 3.",
        "C",
        fixed_because=_NO_DEVICE,
    ),
    DriveReading(
        "R-15",
        "Hold in states that SD p. 23 does not describe.",
        "An assembled move makes a controlled stop and can't be resumed. During a jog, a registration "
        "move or a home search Hold is a command error, and the motion continues. At rest it is a command"
        " error, too.",
        "C",
        ("hold_at_rest_refused",),
    ),
    DriveReading(
        "R-16",
        "A jog with invalid new values.",
        "The jog continues with the old values. INVALID_JOG_CHANGE clears with the next good change or "
        "with Reset Errors.",
        "C",
        ("jog_stops_on_bad_values",),
    ),
    DriveReading(
        "R-17",
        "Registration move: order of the words of its minimum distance, and checks.",
        "Words 8 and 9 are in the order of the other numbers. The stopping distance must be at least that"
        " of the ramp. The rest is as on a 3601.",
        "C",
        fixed_because=_NO_DEVICE,
    ),
    DriveReading(
        "R-18",
        "Indexed move.",
        "The command is checked and stored, and the input's edge starts it. Removing the command bit "
        "before the edge cancels it.",
        "C",
        fixed_because=_NO_DEVICE,
    ),
    DriveReading(
        "R-19",
        "Sequence of a home search.",
        "That of a 3601 with a home switch, its pause of 2 s at a limit included. Position and encoder "
        "are 0 at its end.",
        "B",
    ),
    DriveReading(
        "R-20",
        "Arithmetic of assembled moves.",
        "Blend: each segment begins with a ramp to its speed at its own rate; the last one includes the "
        "final ramp. Dwell: relative moves with a pause between them, at which no motion bit is on.",
        "B",
    ),
    DriveReading(
        "R-21",
        "A request for configuration mode during a motion.",
        "The motion is cut, the driver is off, the position is invalid.",
        "C",
        fixed_because="the client SMD_Control_Server says so",
    ),
    DriveReading(
        "R-22",
        "Loss of the controlling connection.",
        "A closed Modbus connection stops nothing. An EtherNet/IP time-out is an immediate stop, and the "
        "driver is off. After the loss of the cable the position is invalid; its return sets "
        "CONNECTION_LOST and INPUT_ERROR.",
        "C",
        ("timeout_stops",),
    ),
    DriveReading(
        "R-23",
        "Two command bits that rise together.",
        "COMMAND_ERROR, and nothing is carried out. A bit that is on already does not count.",
        "B",
    ),
    DriveReading(
        "R-24",
        "Commands while COMMAND_ERROR is set.",
        "Moves are refused until Reset Errors; Immediate Stop works.",
        "C",
        ("error_locks_stop",),
    ),
    DriveReading(
        "R-25",
        "A move command during a move.",
        "COMMAND_ERROR; the running move continues.",
        "B",
    ),
    DriveReading(
        "R-26",
        "Program_Assembled is bit 12 in SMD p. 72, and bit 11 in 17 p. 72, p. 80 and EDS.",
        "Bit 11.",
        "A",
    ),
    DriveReading(
        "R-27",
        "SMD p. 120 shows 16,543 as the last coil; p. 13 has 4,069 counts.",
        "16 coils for each register; 4,096 counts.",
        "A",
    ),
    DriveReading(
        "R-28",
        "Parameters out of range.",
        "COMMAND_ERROR alone: the family has no bit for an invalid profile.",
        "A",
    ),
    DriveReading(
        "R-29",
        "A move with the driver disabled.",
        "COMMAND_ERROR, no motion.",
        "C",
        fixed_because="a move without current can't be carried out",
    ),
    DriveReading(
        "R-30",
        "A segment with a bad value.",
        "COMMAND_ERROR; assembled mode ends, and no profile is stored.",
        "B",
    ),
    DriveReading(
        "R-31", "A command bit that stays on.", "ACKNOWLEDGE stays on until word 0 loses the bit.", "A"
    ),
    DriveReading(
        "R-32", "Enabling the driver without a valid configuration.", "The driver stays off (SD2 p. 59).", "A"
    ),
    DriveReading(
        "R-33",
        "The enable bit is removed during a move.",
        "The current is off, so the motion is cut, and the position is invalid.",
        "C",
        fixed_because="a motor without current loses its position",
    ),
    DriveReading(
        "R-34",
        "STOPPED of an ANF2.",
        "It means no motion, since the driver of EPICS waits for it at the end of each move.",
        "B",
    ),
    DriveReading(
        "R-35",
        "Configuration data of an EtherNet/IP connection.",
        "None, or 16 bytes; another size is refused.",
        "C",
        fixed_because="the EDS declares both sizes",
    ),
    DriveReading(
        "R-36", "Preset Encoder without an encoder.", "COMMAND_ERROR.", "C", fixed_because=_NO_DEVICE
    ),
    DriveReading("R-37", "A move of no distance.", "It is complete at once, as on a 3601.", "B"),
    DriveReading(
        "R-38",
        "A jog command in the direction of a jog that still ramps down, as the client SMD_Control_Server "
        "sends it.",
        "The jog continues with the new values.",
        "C",
        fixed_because="the client jogs that way",
    ),
    DriveReading(
        "R-39",
        "A move that begins with an end limit active.",
        "Toward the limit it is an input error, and nothing moves. Away from it the move runs: only a "
        "limit that becomes active stops a move. An ANF2 leaves a limit by jogging only (README of its "
        "EPICS driver).",
        "C",
        fixed_because="the EPICS driver of the ANG1 leaves a limit with a relative move",
    ),
    DriveReading(
        "R-40",
        "Commands without a valid configuration.",
        "Reset Errors is acknowledged; any other command is a command error.",
        "C",
        fixed_because="the format of its numbers is unknown without a configuration",
    ),
    DriveReading(
        "R-41",
        "Period in which inputs are sampled.",
        "250 us, as on a 3601; the words act when they arrive.",
        "C",
        ("input_scan_us",),
    ),
    DriveReading(
        "R-42",
        "When a stall is detected.",
        "When the shaft is an eighth of a turn behind the motor.",
        "C",
        ("stall_degrees",),
    ),
    DriveReading(
        "R-43",
        "A home search without a home input.",
        "It is a command error: the search would not end.",
        "C",
        fixed_because=_NO_DEVICE,
    ),
    DriveReading(
        "R-44",
        "End of a home search that runs out of the time-out of an ANF2's configuration.",
        "It is cut, with an input error; a time-out of 0 is without end.",
        "C",
        fixed_because=_NO_DEVICE,
    ),
)
"""The readings by number; those from R-38 on were found while the drives were built."""
