"""Adapts the motion blocks of `USE axis3601` to a rack with a networked drive.

The library file does not change. Each row here replaces a line of its text, or inserts lines before a line.
Blocks still write the eight words of a 3601. Only `Amci3601` reads and writes the words of the drive, as
`io_images.drives.translation` does for axes in Python. `Model` selects whose words are used: 0 for a 3601, 1
for the SMD family, 2 for an ANF2.

    Axis.Setup      the ten words of Configure3601
    Axis.Formats    bit 0: the drive reads 32 bits; 1: it reports 32 bits; 2: the low word is first
    Axis.Sensors    the inputs that capture, bit 0 = input 1
    Module.Raw      the drive's input words, then its output words
"""

from __future__ import annotations

Row = tuple[str, str, str]
"""An instruction ("" for the library itself), one of its lines, and the lines that replace the line."""

ROWS: tuple[Row, ...] = (
    (
        "",
        "WasInvalid : BOOL, From : DINT)",
        "WasInvalid : BOOL, From : DINT, Model : DINT, Setup : INT[10], Formats : DINT, Sensors : DINT, "
        "StartSpeed : DINT, Minimum : DINT, TopSpeed : DINT, Cleared : DINT)",
    ),
    (
        "Amci3601",
        "LOCAL Change : BOOL",
        """LOCAL Change : BOOL
LOCAL Model : DINT  // module's words, set by the rack: 0 of a 3601, 1 of an SMD, 2 of an ANF2
LOCAL Raw : INT[10]
LOCAL Low : INT
LOCAL Value : DINT
LOCAL Parts : DINT
LOCAL Registers : BOOL""",
    ),
    # the drive's inputs in the words of a 3601
    (
        "Amci3601",
        "CPS(Inputs,Axis.In[0],8);",
        """MOV(Model,Axis.Model)MOV(1000000,Axis.TopSpeed)EQU(Model,1)MOV(2999999,Axis.TopSpeed);
EQU(Model,0)CPS(Inputs,Axis.In[0],8);
NEQ(Model,0)CPS(Inputs,Raw[0],10);
// Formats and inputs of a configuration that the drive accepts
EQU(Model,1)EQU(Axis.Step,2)EQU(Axis.RunKind,14)BTD(Axis.Setup[1],8,Axis.Formats,0,3)CPT(Axis.StartSpeed,Axis.Setup[2]*1000+Axis.Setup[3])CLR(Axis.Sensors)[XIC(Axis.Setup[0].0)XIO(Axis.Setup[0].1)XIC(Axis.Setup[0].2)OTL(Axis.Sensors.0),XIC(Axis.Setup[0].3)XIO(Axis.Setup[0].4)XIC(Axis.Setup[0].5)OTL(Axis.Sensors.1)];
EQU(Model,2)MOV(3,Axis.Formats);
CLR(Low)XIC(Axis.Formats.2)MOV(1,Low);
// Bits 8 and 9 are of a blend; bit 9 of a 3601, a jog's new speed, is in status word 1
NEQ(Model,0)AND(Raw[0],-769,Axis.In[0])CLR(Axis.In[1]);
EQU(Model,1)XIC(Raw[1].9)OTL(Axis.In[0].9);
EQU(Model,1)[XIC(Axis.Sensors.0)XIC(Raw[1].0),XIC(Axis.Sensors.1)XIC(Raw[1].1)]OTL(Axis.In[1].0);
EQU(Model,1)XIC(Raw[0].8)[EQU(Axis.Out[7],-1)EQU(Axis.Out[1],768)XIC(Raw[0].9),NEQ(Axis.Out[7],-1)XIO(Raw[0].9)]OTL(Axis.In[1].9);
NEQ(Model,0)XIO(Axis.Formats.1)COP(Raw[2],Axis.In[2],6);
NEQ(Model,0)XIC(Axis.Formats.1)CPT(Value,Raw[2+Low]*65536+(Raw[3-Low] AND 65535))DIV(Value,1000,Axis.In[2])MOD(Value,1000,Axis.In[3]);
NEQ(Model,0)XIC(Axis.Formats.1)CPT(Value,Raw[4+Low]*65536+(Raw[5-Low] AND 65535))DIV(Value,1000,Axis.In[4])MOD(Value,1000,Axis.In[5]);
NEQ(Model,0)XIC(Axis.Formats.1)CPT(Value,Raw[6+Low]*65536+(Raw[7-Low] AND 65535))DIV(Value,1000,Axis.In[6])MOD(Value,1000,Axis.In[7]);
// Configuration mode mirrors all of word 0. An ANF2 leaves configuration mode once it has accepted the words
NEQ(Model,0)[XIC(Raw[0].15),EQU(Model,2)XIC(Axis.Out[0].15)]FLL(0,Axis.In[1],7)MOV(-16384,Axis.In[0]);
// A stall, a fault of the driver, or a driver that is not enabled in a motion
EQU(Model,1)XIO(Raw[0].15)[XIC(Raw[1].7),XIC(Raw[1].14),XIO(Raw[1].15)[LEQ(Axis.RunKind,4),EQU(Axis.RunKind,12),EQU(Axis.RunKind,13)]]OTE(Axis.Faults.11);""",
    ),
    # an input error that persists: only with a 3601 does the next move clear it
    (
        "Amci3601",
        "// request sets Taken: a request during steps 1 to 5 waits",
        """// request sets Taken: a request during steps 1 to 5 waits. In a drive, only Reset Errors clears INPUT_ERROR
NEQ(Model,0)EQU(Axis.Step,0)NEQ(Axis.Ticket,Axis.Taken)NEQ(Axis.Ticket,Axis.Cleared)XIO(Axis.ErrorStop)XIC(Axis.In[0].11)XIC(Axis.In[0].14)XIO(Axis.In[0].13)XIO(Axis.In[0].15)[LEQ(Axis.Kind,4)[NEQ(Axis.Kind,1),XIO(Axis.In[0].10)],EQU(Axis.Kind,12),EQU(Axis.Kind,13)]MOV(Axis.Ticket,Axis.Cleared)MOV(2048,Axis.Out[0])MOV(5,Axis.Step);""",
    ),
    # the words of a 3601 in the drive's format
    (
        "Amci3601",
        "CPS(Axis.Out[0],Outputs,8);",
        """EQU(Model,0)CPS(Axis.Out[0],Outputs,8);
NEQ(Model,0)FLL(0,Raw[0],10)CLR(Parts)XIC(Axis.Out[1].10)CPT(Axis.Minimum,Axis.Out[2]*1000+Axis.Out[3]);
NEQ(Model,0)[XIC(Axis.Out[0].7),XIC(Axis.Out[0].8)][NEQ(Axis.Out[2],0),NEQ(Axis.Out[3],0)]OTE(Registers);
// Commands; bit 11 resets errors, bits 12 and 13 run a blend
NEQ(Model,0)AND(Axis.Out[0],1023,Raw[0])COP(Axis.Out[6],Raw[6],2);
EQU(Model,2)XIC(Axis.Out[0].11)OTL(Raw[0].11);
EQU(Model,1)[OTL(Raw[1].15),XIC(Axis.Out[0].11)OTL(Raw[0].10),XIC(Axis.Out[0].12)OTL(Raw[0].13),XIC(Axis.Out[0].13)OTL(Raw[0].13)OTL(Raw[1].4),XIC(Axis.Out[1].12)OTL(Raw[1].11),XIC(Axis.Out[1].8)OTL(Raw[0].11),XIC(Axis.Out[1].8)XIC(Axis.Out[1].9)NEQ(Axis.Out[7],-1)OTL(Raw[0].12),XIC(Registers)OTL(Raw[1].7)];
// Numbers in thousands or in 32 bits
NEQ(Model,0)XIO(Axis.Formats.0)COP(Axis.Out[2],Raw[2],4)XIC(Registers)DIV(Axis.Minimum,1000,Raw[8])MOD(Axis.Minimum,1000,Raw[9]);
NEQ(Model,0)XIC(Axis.Formats.0)CPT(Value,Axis.Out[2]*1000+Axis.Out[3])BTD(Value,16,Raw[2+Low],0,16)BTD(Value,0,Raw[3-Low],0,16)CPT(Value,Axis.Out[4]*1000+Axis.Out[5])BTD(Value,16,Raw[4+Low],0,16)BTD(Value,0,Raw[5-Low],0,16);
XIC(Registers)XIC(Axis.Formats.0)BTD(Axis.Minimum,16,Raw[8+Low],0,16)BTD(Axis.Minimum,0,Raw[9-Low],0,16);
// An S-curve is a jerk: a rate reaches its peak in 100/jerk s. Both ramps have the jerk of the gentler ramp
CPT(Value,Axis.Out[4]*1000+Axis.Out[5]-Axis.StartSpeed);
EQU(Model,1)XIO(Registers)GRT(Value,0)XIC(Axis.Out[1].0)MOV(100000,Parts)XIC(Axis.Out[1].1)MOV(300000,Parts);
NEQ(Parts,0)[LEQ(Axis.Out[6],Axis.Out[7])MUL(Parts,Axis.Out[6],Parts),GRT(Axis.Out[6],Axis.Out[7])MUL(Parts,Axis.Out[7],Parts)];
EQU(Model,1)XIO(Registers)GRT(Value,0)XIC(Axis.Out[1].0)DIV(Parts,Value,Parts)[LES(Parts,1)MOV(1,Parts),GRT(Parts,5000)MOV(5000,Parts)];
NEQ(Parts,0)MOV(Parts,Raw[9]);
// Configuration mode
NEQ(Model,0)XIC(Axis.Out[0].15)COP(Axis.Setup[0],Raw[0],10);
NEQ(Model,0)CPS(Raw[0],Outputs,10);""",
    ),
    # limits of the drive's model
    *(
        (block, "LIM(1000001,Velocity,0)", "LEQ(Velocity,0),GRT(Velocity,Axis.TopSpeed)")
        for block in ("MC_MoveAbsolute", "MC_MoveRelative", "MC_Home")
    ),
    *(
        (block, "LIM(1000001,Velocity,-1000001)", "CMP(ABS(Velocity)>Axis.TopSpeed)")
        for block in ("MC_MoveVelocity", "MoveRegistration3601")
    ),
    # functions that a drive lacks: refused with 4096, unless refused for another reason
    *(
        (
            block,
            "Request3601(Request,",
            f"OTU(Refused.12)EQU(Refused,0){lacks}OTE(Refused.12);\nRequest3601(Request,",
        )
        for block, lacks in (
            ("MC_MoveAbsolute", "EQU(Axis.Model,2)NEQ(Shape,0)"),
            ("MC_MoveRelative", "EQU(Axis.Model,2)NEQ(Shape,0)"),
            ("MC_MoveVelocity", "EQU(Axis.Model,2)NEQ(Shape,0)"),
            ("MC_GearIn", "NEQ(Axis.Model,0)"),
            ("MoveRegistration3601", "[EQU(Axis.Model,2),EQU(Axis.Model,1)NEQ(Shape,0)]"),
            ("StoreMinimum3601", "EQU(Axis.Model,2)"),
            ("RunBlend3601", "EQU(Axis.Model,2)"),
            (
                "ProgramBlend3601",
                "SUB(Segments,1,Latest)SUB(Segments,2,Prior)"
                "[EQU(Axis.Model,2),EQU(Axis.Model,1)[NEQ(FinalShape,0),NEQ(EarlyShapes,0),NEQ(LateShapes,0),"
                "LES(Velocities[Latest],Velocities[Prior])NEQ(Rates[Latest],FinalDeceleration)]]",
            ),
        )
    ),
    # the ten words of a configuration
    (
        "Configure3601",
        "XIC(Request.Start)COP(Configuration,Axis.Words[0],8);",
        """XIC(Request.Start)EQU(Axis.Model,0)COP(Configuration,Axis.Words[0],8);
XIC(Request.Start)NEQ(Axis.Model,0)COP(Configuration,Axis.Setup[0],10)MOV(Axis.Setup[0],Axis.Words[0])MOV(4,Axis.Words[1]);""",
    ),
    # a segment of a drive has a deceleration, in word 7; -1 marks the first block
    ("ProgramBlend3601", "LOCAL Index : DINT", "LOCAL Index : DINT\nLOCAL Latest : DINT\nLOCAL Prior : DINT"),
    ("ProgramBlend3601", "14,2)CLR(Index);", "14,2)CLR(Index)NEQ(Axis.Model,0)MOV(-1,Axis.Words[7]);"),
    (
        "ProgramBlend3601",
        "ADD(Index,1,Index)OTU(Next);",
        "ADD(Index,1,Index)OTU(Next)NEQ(Axis.Model,0)MOV(Axis.Out[6],Axis.Out[7])"
        "EQU(Index,Segments)MOV(FinalDeceleration,Axis.Out[7]);",
    ),
)


def for_drives(text: str) -> str:
    """Return the library's text after applying the rows."""
    head, *sections = text.split("\nINSTRUCTION ")
    text_of = {"": head, **{section.split(maxsplit=1)[0]: section for section in sections}}
    for block, line, replacement in ROWS:
        assert line in text_of[block], (block, line)
        text_of[block] = text_of[block].replace(line, replacement, 1)
    return "\nINSTRUCTION ".join(text_of.values())
