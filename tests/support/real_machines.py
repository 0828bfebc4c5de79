"""What three kinds of real machines have beside the mix: drives, messages with parameters, alarms and queues.

A drive is an add-on of twenty rungs that looks up a fault in a table when its word says so. A message is a
routine that gets numbers by value and returns one. Each alarm, queue and stack has tags of its own.
"""

from collections.abc import Callable
from random import Random

from l5x_files import add_on, ladder, parameter, tag
from real_types import Part

Pick = Callable[[str], str]
"""Draws a tag of a kind."""

Need = Callable[[str, int], str]
"""Declares a tag of a type and length; returns its name."""

FAULTS, LEVELS = 20, 12
"""Codes in the table of a drive; elements of a queue."""


def drive_add_on() -> str:
    """Return the add-on of a drive: command, reference, feedback, and the place of a fault in a table."""
    inputs = [parameter(name, kind, "Input") for name, kind in (("Status", "DINT"), ("Reference", "REAL"))]
    outputs = [
        parameter(name, kind, "Output")
        for name, kind in (("Command", "DINT"), ("Speed", "REAL"), ("Fault", "DINT"))
    ]
    local = [
        ("Look", "CONTROL", 0),
        ("Codes", "DINT", FAULTS),
        ("Ready", "BOOL", 0),
        ("Active", "BOOL", 0),
        ("Faulted", "BOOL", 0),
        ("Late", "TIMER", 0),
        ("Starts", "DINT", 0),
        ("Edge", "BOOL", 0),
        ("Raw", "DINT", 0),
        ("Code", "DINT", 0),
        ("Filtered", "REAL", 0),
        ("Names", "CONTROL", 0),
    ]
    return add_on(
        "Drive",
        [*inputs, *outputs],
        [tag(name, kind, str(length or "")).replace("Tag", "LocalTag") for name, kind, length in local],
        ladder(
            "Logic",
            "XIC(Status.1)OTE(Ready);",
            "XIC(Status.2)OTE(Active);",
            "XIC(Status.3)OTE(Faulted);",
            "AND(Status,31,Code);",
            f"XIO(Look.EN)FAL(Names,{FAULTS},0,ALL,Codes[Names.POS],Names.POS*3);",
            f"XIC(Faulted)FSC(Look,{FAULTS},0,ALL,Codes[Look.POS]=Code);",
            "XIC(Look.FD)ADD(Look.POS,1,Fault);",
            "XIC(Look.DN)MOV(-1,Fault);",
            "XIO(Faulted)CLR(Fault);",
            "XIC(Ready)XIO(Faulted)OTE(Command.0);",
            "XIC(Active)XIO(Command.0)TON(Late,200,0);",
            "XIC(Late.DN)OTE(Command.1);",
            "XIC(Active)ONS(Edge)LES(Starts,100000)ADD(Starts,1,Starts);",
            "CPT(Filtered,Filtered*0.75+Reference*0.25);",
            "LIM(-1000.0,Filtered,1000.0)MOV(Filtered,Raw);",
            "GRT(Filtered,1000.0)MOV(1000,Raw);",
            "LES(Filtered,-1000.0)MOV(-1000,Raw);",
            "BTD(Raw,0,Command,8,12);",
            "CPT(Speed,Raw/8.0);",
            "EQU(Fault,0)XIC(Ready)OTE(Command.2);",
        ),
    )


def message_routine() -> str:
    """Return a routine that is passed numbers by value, and builds a text of them."""
    return ladder(
        "Compose",
        "SBR(Asked,Urgency,Amount)NOP();",
        "DTOS(Asked,Text_a)CONCAT('No. ',Text_a,Text_b);",
        "GRT(Urgency,5)CONCAT(Text_b,' urgent',Text_c);",
        "LEQ(Urgency,5)MID(Text_b,3,2,Text_c);",
        "LES(Urgency,3)RTOS(Amount,Text_a)CONCAT(Text_c,Text_a,Text_b);",
        "ADD(Asked,Urgency,Answer)RET(Answer);",
    )


MESSAGE_TAGS = (
    *(Part(name, "DINT") for name in ("Asked", "Urgency", "Answer")),
    Part("Amount", "REAL"),
)


def _drive(draw: Random, pick: Pick, need: Need) -> str:
    noise = f"Noise_{draw.randrange(4)}"
    return f"Drive({need('Drive', 0)},{noise},{pick('REAL')},{pick('DINT')},{pick('REAL')},{pick('DINT')})"


def _call(draw: Random, pick: Pick, _need: Need) -> str:
    return f"JSR(Compose,3,Ix_{draw.randrange(4)},{draw.randrange(9)},{pick('REAL')},Place)"


def _alarm(draw: Random, pick: Pick, need: Need) -> str:
    if draw.random() < 0.6:
        return f"ALMD({need('ALARM_DIGITAL', 0)},0,0,0,0,?,?)"
    return f"ALMA({need('ALARM_ANALOG', 0)},{pick('REAL')},0,0,0,?,?,?,?)"


def _queue(draw: Random, pick: Pick, need: Need) -> str:
    row, control = need("DINT", LEVELS), need("CONTROL", 0)
    bits = [f"{draw.choice(('XIC', 'XIO'))}(In_{draw.randrange(16)})" for _ in range(2)]
    load, unload = draw.choice((("FFL", "FFU"), ("FFL", "FFU"), ("LFL", "LFU")))
    rest = f"{control},{LEVELS - 2},0)"
    put = f"{bits[0]}{load}(Ix_{draw.randrange(4)},{row}[0],{rest}"
    return f"[{put},{bits[1]}{unload}({row}[0],{pick('DINT')},{rest}]"


SPECIALS: dict[str, Callable[[Random, Pick, Need], str]] = {
    "drive": _drive,
    "call": _call,
    "alarm": _alarm,
    "queue": _queue,
}
"""Outputs of rungs, by their kind."""
