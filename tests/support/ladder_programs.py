"""Hypothesis strategies for ladder programs: every instruction, every type, over one fixed set of tags."""

from hypothesis import strategies as st
from scanrack.ladder.instructions import SPECS
from scanrack.ladder.model.spec import InstructionKind, Use

TAGS = """PROGRAM generated
ALLOW repeated coils
ALLOW repeated timers
TYPE Part (Size : INT, Good : BOOL, Bad : BOOL, Weight : REAL, Marks : SINT[3])
TAG A : BOOL
TAG B : BOOL
TAG C : BOOL
TAG S0 : BOOL
TAG S1 : BOOL
TAG Bits : BOOL[4]
TAG Small : SINT
TAG Word : INT
TAG Wide : DINT
TAG Other : DINT
TAG Long : LINT
TAG Byte : USINT
TAG Port : UINT
TAG Sum32 : UDINT
TAG Sum64 : ULINT
TAG Ratio : REAL
TAG Share : REAL
TAG Fine : LREAL
TAG Fines : LREAL[4]
TAG Index : DINT
TAG Block : INT[8]
TAG Grid : DINT[2,3]
TAG Parts : Part[3]
TAG Delay : TIMER := {"PRE": 25}
TAG Hold : TIMER := {"PRE": 40}
TAG Delays : TIMER[2] := [{"PRE": 15}, {"PRE": 0}]
TAG Count : COUNTER := {"PRE": 3}
TAG Edge : COUNTER := {"PRE": -2147483647, "ACC": 2147483646}
TAG Name : STRING := "abc"
TAG Text : STRING := "abd"
TAG Table : DINT[6] := [3, -1, 2, 70000, 5]
TAG Ctl : CONTROL := {"LEN": 3}
TAG Ctls : CONTROL[2] := [{"LEN": 2}, {"LEN": 4, "POS": 1}]
TAG Turn : DINT
TAG Order : MESSAGE
TAG Loop : PID := {"UPD": 0.5, "MAXS": 50.0, "KP": 1.5, "KI": 0.25, "KD": 0.1}
TAG Alarm : ALARM_DIGITAL := {"MinDurationPRE": 10}
TAG Level : ALARM_ANALOG := {"HLimit": 5.0, "HHLimit": 9.0, "Deadband": 1.0, "ROCPeriod": 0.02}
STUB MSG : error 16#00CB after 15 ms
TAG Words : STRING[2] := ["x12", "-3.5"]
TAG Taken : Part
TAG Label : STRING
TAG Row : INT[8]
SLOT axis : 1
"""

BITS = (
    "A",
    "B",
    "C",
    "Bits[1]",
    "Bits[Index]",
    "Word.3",
    "Word.15",
    "Wide.31",
    "Small.7",
    "Sum32.31",
    "Byte.[Index]",
    "Wide.[Index]",
    "Block[Index].2",
    "Parts[1].Good",
    "Parts[Index].Bad",
    "Delay.DN",
    "Count.DN",
    "axis.command.RESET_ERRORS",
    "Local:1:O.Data[0].15",
    "Grid[1,Index].0",
)
READ_BITS = (*BITS, "I:1.0/7", "axis.status.MODE_CONFIG", "S:Z", "S:V", "S:N", "S:C", "S:FS")
STORAGE = ("S0", "S1", "Block[7].0")
INTEGERS = (
    "Small",
    "Word",
    "Wide",
    "Other",
    "Long",
    "Byte",
    "Port",
    "Sum32",
    "Sum64",
    "Index",
    "Block[2]",
    "Block[Index]",
    "Grid[1,2]",
    "Grid[Index,Index+1]",
    "Parts[2].Size",
    "Parts[Index].Marks[1]",
    "Delay.ACC",
    "Count.ACC",
    "Local:1:O.Data[3]",
    "O:1.5",
)
REALS = ("Ratio", "Share", "Parts[0].Weight", "Parts[Index].Weight", "Fine", "Fines[1]", "Fines[Index]")
CONSTANTS = (
    "0",
    "1",
    "-1",
    "2",
    "7",
    "100",
    "-32768",
    "65665",
    "2147483647",
    "-2147483648",
    "16#FF00",
    "4294967296",
)
REAL_CONSTANTS = ("0.5", "-2.5", "1.5", "1.0e30", "1.0e300", "0.0", "0.1")
FUNCTIONS = ("SIN", "COS", "TAN", "ASN", "ACS", "ATN", "LN", "LOG", "DEG", "RAD")
TIMERS = ("Delay", "Hold", "Delays[1]", "Delays[Index]")
COUNTERS = ("Count", "Edge")
REGIONS = (
    "Block",
    "Block[5]",
    "Block[Index]",
    "Local:1:O.Data",
    "Local:1:O.Data[2]",
    "Grid",
    "Parts",
    "Parts[1]",
    "Delay",
    "Count",
    "Name",
    "Wide",
    "Sum64",
    "Ratio",
    "Fines",
    "Parts[Index].Marks",
)

bits = st.sampled_from(BITS)
read_bits = st.sampled_from(READ_BITS)
integers = st.sampled_from(INTEGERS)
targets = st.sampled_from((*INTEGERS, *REALS))
integer_values = st.sampled_from((*INTEGERS, *CONSTANTS, "Local:1:I.Data[2]"))
values = st.sampled_from((*INTEGERS, *REALS, *CONSTANTS, *REAL_CONSTANTS))


WRITTEN = {"AFI", "NOP", "MSG", "JSR", "SBR", "RET", "FOR", "BRK", "JMP", "LBL", "TND", "MCR"}
"""Instructions of the strategies below."""


def _joined(name, *operands):
    WRITTEN.add(name)
    return st.tuples(*operands).map(lambda found: f"{name}({','.join(found)})")


def _any_of(names, *operands):
    WRITTEN.update(names)
    return st.sampled_from(names).flatmap(lambda name: _joined(name, *operands))


integer_expressions = st.recursive(
    integer_values,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(("+", "-", "*", "/", " MOD ", " AND ", " OR ", " XOR ")), inner).map(
            lambda found: f"({found[0]}){found[1]}({found[2]})"
        ),
        st.tuples(st.sampled_from(("ABS", "SQR", "TRN", "NOT ", "-")), inner).map(
            lambda found: f"{found[0]}({found[1]})"
        ),
    ),
    max_leaves=4,
)
expressions = st.one_of(
    integer_expressions,
    st.recursive(
        values,
        lambda inner: st.one_of(
            st.tuples(inner, st.sampled_from(("+", "-", "*", "/", " MOD ", "**")), inner).map(
                lambda found: f"({found[0]}){found[1]}({found[2]})"
            ),
            st.tuples(st.sampled_from(("ABS", "SQR", "TRN", "-", *FUNCTIONS)), inner).map(
                lambda found: f"{found[0]}({found[1]})"
            ),
        ),
        max_leaves=4,
    ),
)
relations = st.tuples(expressions, st.sampled_from(("=", "<>", "<", "<=", ">", ">=")), expressions).map(
    lambda found: f"({found[0]}){found[1]}({found[2]})"
)
conditions = st.one_of(
    relations,
    st.tuples(relations, st.sampled_from(("AND", "OR", "XOR")), relations).map(" ".join),
    relations.map(lambda relation: f"NOT ({relation})"),
)

controls = st.sampled_from(("Ctl", "Ctls[1]", "Ctls[Index]"))
tables = st.sampled_from(("Table", "Table[1]", "Table[Index]"))
modes = st.sampled_from(("ALL", "INC", "2"))
unset = st.just("?")

_INPUTS = (
    _any_of(("XIC", "XIO"), read_bits),
    _any_of(("XIC", "XIO"), st.sampled_from("ABC")),
    _joined("ONS", st.sampled_from(STORAGE)),
    _any_of(("EQU", "NEQ", "GRT", "GEQ", "LES", "LEQ"), values, values),
    _any_of(("EQU", "LES", "GEQ"), st.sampled_from(("Name", "Text")), st.sampled_from(("Name", "'abc'"))),
    _joined("LIM", values, values, values),
    _joined("MEQ", integer_values, integer_values, integer_values),
    _joined("CMP", conditions),
    st.sampled_from(("AFI()", "NOP()")),
    _joined("SQI", tables, integer_values, integer_values, controls, unset, unset),
)
small = st.integers(0, 7).map(str)
queues = st.sampled_from(("Table", "Block[2]", "Block[Index]", "Parts[Index].Marks"))
_FILE_OUTPUTS = (
    _joined(
        "FAL",
        st.just("Ctl"),
        unset,
        unset,
        modes,
        st.sampled_from(("Table[Ctl.POS]", "Block[Ctl.POS]", "Grid[1,Ctl.POS]", "Ratio")),
        st.one_of(expressions, st.sampled_from(("Block[Ctl.POS]*9", "Table[Ctl.POS]+Share"))),
    ),
    _joined("FSC", st.just("Ctl"), unset, unset, modes, st.one_of(conditions, st.just("Table[Ctl.POS]>2"))),
    _any_of(("BSL", "BSR"), tables, controls, read_bits, unset),
    _any_of(("FFL", "LFL"), values, queues, controls, unset, unset),
    _any_of(("FFU", "LFU"), queues, targets, controls, unset, unset),
    _any_of(("FFL", "LFL"), st.just("Parts[0]"), st.just("Parts[1]"), controls, unset, unset),
    _any_of(("FFU", "LFU"), st.just("Parts[1]"), st.just("Parts[Index]"), controls, unset, unset),
    _joined("SQO", tables, integer_values, integers, controls, unset, unset),
    _joined("SQL", tables, integer_values, controls, unset, unset),
    _any_of(("AVE", "STD"), queues, st.just("0"), targets, controls, unset, unset),
    _any_of(("AVE", "STD"), st.just("Grid[0,Index]"), small, targets, controls, unset, unset).filter(
        lambda text: text.split(",")[2] in "01"
    ),
    _joined("SRT", queues, st.just("0"), controls, unset, unset),
    _joined("SIZE", st.just("Grid[1,1]"), st.sampled_from("01"), integers),
    _joined(
        "MOV", st.sampled_from(("2", "4", "Index")), st.sampled_from(("Ctl.LEN", "Ctl.POS", "Ctls[1].LEN"))
    ),
    _joined("RES", controls),
    _joined(
        "PID", st.just("Loop"), values, values, targets, st.just("0"), st.sampled_from(("A", "0")), values
    ),
    _joined("ALMD", st.just("Alarm"), *[st.sampled_from(("A", "B", "C", "0", "1"))] * 4, unset, unset),
    _joined("ALMA", st.just("Level"), values, *[st.sampled_from(("A", "B", "0"))] * 3, *[unset] * 4),
    _any_of(
        ("OTL", "OTU"),
        st.sampled_from(
            (
                *("Loop.MO", "Loop.SWM", "Loop.PE", "Loop.DOE", "Loop.CA", "Loop.PVT", "Loop.NOZC"),
                *(
                    "Alarm.Latched",
                    "Alarm.AckRequired",
                    "Alarm.Condition",
                    "Alarm.OperReset",
                    "Alarm.OperAck",
                ),
                *("Alarm.OperDisable", "Alarm.ProgEnable", "Alarm.OperSuppress", "Alarm.AlarmCountReset"),
                *("Level.LEnabled", "Level.AckRequired", "Level.OperAckAll", "Level.OperDisable"),
            )
        ),
    ),
    _joined(
        "MOV",
        values,
        st.sampled_from(
            (
                *("Loop.SP", "Loop.KI", "Loop.MAXO", "Loop.DB", "Loop.UPD", "Loop.PVH", "Loop.DVDB"),
                *("Alarm.MinDurationPRE", "Level.MinDurationPRE", "Level.ROCPeriod", "Level.ROCNegLimit"),
                *("Level.HLimit", "Level.LLimit", "Level.Deadband", "Level.ROCPosLimit"),
            )
        ),
    ),
    st.sampled_from(("MSG(Order)", "OTL(Order.TO)", "OTU(Order.EN)", "OTE(Order.DN)")),
    _any_of(("OTE", "OTU"), st.sampled_from(("Ctl.IN", "Ctl.ER", "Ctl.EN", "Ctl.EU"))),
)
STRINGS = ("Name", "Text", "Words[1]", "Words[Index]")
strings = st.sampled_from(STRINGS)
texts = st.sampled_from((*STRINGS, "'a-7.5e1'", "''"))
places = st.sampled_from(("0", "1", "2", "Index", "Small"))
_STRING_OUTPUTS = (
    _joined("CONCAT", texts, texts, strings),
    _any_of(("MID", "DELETE"), texts, places, places, strings),
    _joined("INSERT", texts, texts, places, strings),
    _joined("FIND", texts, texts, places, integers),
    _any_of(("STOD", "STOR"), texts, targets),
    _any_of(("DTOS", "RTOS"), values, strings),
    _any_of(("UPPER", "LOWER"), texts, strings),
    st.sampled_from(("MOV(85,Name.LEN)", "MOV(Index,Text.LEN)")),
)
BY_USE = {
    Use.BIT: read_bits,
    Use.COIL: bits,
    Use.LATCH: bits,
    Use.STORAGE: st.sampled_from(STORAGE),
    Use.NUMBER: values,
    Use.INTEGER: integer_values,
    Use.TARGET: targets,
    Use.INTEGER_TARGET: integers,
    Use.TEXT: texts,
    Use.TEXT_TARGET: strings,
    Use.TEXT_OR_NUMBER: values,
    Use.TEXT_OR_NUMBER_TARGET: targets,
    Use.EXPRESSION: expressions,
    Use.CONDITION: conditions,
    Use.TIMER: st.sampled_from(TIMERS),
    Use.COUNTER: st.sampled_from(COUNTERS),
    Use.CONTROL: controls,
    Use.PRESET: unset,
    Use.PASSES: modes,
    Use.RESETTABLE: st.sampled_from((*TIMERS, *COUNTERS)),
    Use.SOURCE: st.sampled_from(REGIONS),
    Use.DESTINATION: st.sampled_from(REGIONS),
    Use.SWITCH: st.sampled_from(("A", "B", "0", "1")),
}
"""Operands of an instruction that has no strategy of its own, by their use."""

OUT = {
    **dict.fromkeys((Use.AXIS, Use.MOTION, Use.MOTION_GROUP, Use.COORDINATE_SYSTEM), "test_motion_*.py"),
    **dict.fromkeys((Use.BLOCK, Use.KEYWORD), "test_ladder_semantics_safety.py"),
    **dict.fromkeys((Use.LABEL, Use.ROUTINE, Use.PARAMETERS), "names of the program, see `jumping_routines`"),
    **dict.fromkeys((Use.SERIAL, Use.IGNORED, Use.HMI_BUTTON), "no effect"),
    Use.TRUTH: "test_sfc_charts.py, test_ladder_semantics_assertion.py",
    **dict.fromkeys((Use.TABLE, Use.ARRAY), "the arrays must fit each other"),
}
"""Uses of operands that instructions without a strategy of their own do not get at random, and why."""


def _by_uses(*kinds):
    specs = [
        spec
        for spec in SPECS
        if spec.kind in kinds
        and spec.in_rungs
        and spec.name not in WRITTEN
        and BY_USE.keys() >= set(spec.operands)
    ]
    return [_joined(spec.name, *(BY_USE[use] for use in spec.operands)) for spec in specs]


def without_strategy() -> set[str]:
    """Return the instructions that random rungs can't have, with the uses without operands."""
    return {
        f"{spec.name}: {use.name}"
        for spec in SPECS
        if spec.in_rungs and spec.name not in WRITTEN and not OUT.keys() & set(spec.operands)
        for use in set(spec.operands) - BY_USE.keys()
    }


_CONDITIONS = (*_INPUTS, *_by_uses(InstructionKind.INPUT))
_OUTPUTS = (
    _any_of(("OTE", "OTL", "OTU"), bits),
    _any_of(("OSR", "OSF"), st.sampled_from(STORAGE), bits),
    _any_of(("TON", "TOF", "RTO"), st.sampled_from(TIMERS)),
    _any_of(("CTU", "CTD"), st.sampled_from(COUNTERS)),
    _joined("RES", st.sampled_from((*TIMERS, *COUNTERS))),
    _joined("CPT", targets, expressions),
    _any_of(("ADD", "SUB", "MUL", "DIV", "MOD"), values, values, targets),
    _any_of(("SQR", "NEG", "ABS", "MOV", "TRN"), values, targets),
    _any_of(FUNCTIONS, values, targets),
    _joined("XPY", values, values, targets),
    *_STRING_OUTPUTS,
    *_FILE_OUTPUTS,
    _joined("MVM", integer_values, integer_values, integers),
    _joined("BTD", integer_values, small, integers, small, small.map(lambda text: str(int(text) + 1))),
    _joined("CLR", targets),
    _joined("SWPB", st.just("Wide"), st.sampled_from(("REVERSE", "WORD", "HIGH/LOW")), st.just("Other")),
    _any_of(("AND", "OR", "XOR"), integer_values, integer_values, integers),
    _joined("NOT", integer_values, integers),
    _any_of(
        ("COP", "CPS"),
        st.sampled_from(REGIONS),
        st.sampled_from(REGIONS),
        st.sampled_from(("1", "3", "9", "Index")),
    ).filter(lambda text: "Marks,Local" not in text),  # refused: half a word of an output
    _joined(
        "FLL",
        values,
        st.sampled_from(("Block", "Grid[0,1]", "Block[Index]", "Local:1:O.Data")),
        st.sampled_from(("2", "9", "Index")),
    ),
    *_by_uses(InstructionKind.OUTPUT, InstructionKind.BOTH),
    st.just("MOV(2,Index)"),
    st.just("MOV(0,Index)"),
    st.sampled_from(
        (
            *("JSR(Sub,1,Wide,Other)", "JSR(Sub,1,Ratio,Word)"),
            *("FOR(Pass,Turn,0,3,1)", "FOR(Pass,Turn,3,-1,-2)"),
            "JSR(Whole,3,Parts[Index],Name,Block,Parts[1],Text,Block)",
        )
    ),
    st.just("MCR()"),
)


@st.composite
def series(draw, depth=2):
    """A series with branches in branches, `depth` deep; MCR stands last in a rung only."""
    text = ""
    for _ in range(draw(st.integers(0, 4))):
        kind = draw(st.sampled_from(("input", "input", "output", "branch") if depth else ("input", "output")))
        if kind == "branch":
            legs = [draw(series(depth - 1)) for _ in range(draw(st.integers(1, 3)))]
            text += f"[{','.join(legs)}]"
        else:
            choices = _CONDITIONS if kind == "input" else _OUTPUTS[:-1]
            text += draw(choices[draw(st.integers(0, len(choices) - 1))])
    return text


@st.composite
def rungs(draw, *, subroutine=False):
    """A rung that ends with an output."""
    choices = _OUTPUTS[:-2] if subroutine else _OUTPUTS
    end = draw(choices[draw(st.integers(0, len(choices) - 1))])
    text = f"{draw(series())}{end};"
    if not subroutine:
        return text
    return (
        text.replace("JSR(Sub,1,", "ADD(1,")
        .replace("FOR(Pass,Turn,0,3,1)", "NOP()")
        .replace("FOR(Pass,Turn,3,-1,-2)", "NOP()")
    )


@st.composite
def jumping_routines(draw):
    """A routine, perhaps with a label and a forward jump to it."""
    lines = draw(st.lists(rungs(), min_size=1, max_size=6))
    if draw(st.booleans()):
        at = draw(st.integers(0, len(lines) - 1))
        lines.insert(at, "XIC(A)JMP(Skip);")
        lines.append("LBL(Skip)XIC(B)OTE(C);")
    if draw(st.booleans()):
        lines.insert(draw(st.integers(0, len(lines))), "XIC(C)XIO(A)TND();")
    return lines


LOGIC = (
    "XIC(On)ADD(Amount,Kept,Sum);",
    "XIO(On)MOV(Kept,Sum);",
    "TON(Time,20,0)XIC(Time.DN)OTE(Late);",
    "XIC(On)ONS(Edge)CTU(Times,3,0);",
    "XIC(EnableIn)CPT(Shared,Shared+Amount);",
    "XIC(Late)OTE(EnableOut);",
    "GRT(Sum,100)OTL(Late);",
    "MUL(Amount,3,Kept);",
    "XIC(On)MOV(Times.ACC,Table[Kept]);",
    "COP(Table[0],Table[1],2);",
    "XIC(On)FSC(Look,?,?,ALL,Table[Look.POS]=Amount)XIC(Look.FD)ADD(Kept,1,Kept);",
    "XIC(On)OTU(Look.IN);",
    "XIC(On)FAL(Fill,?,?,INC,Table[Fill.POS],Shared+Fill.POS);",
    "XIC(On)FFL(Amount,Table,Queue,?,?);",
    "XIO(On)FFU(Table,Kept,Queue,?,?);",
)
"""Rungs that an add-on instruction may consist of."""

SHARED = ("Wide", "Other", "Index", "Grid[1,1]")
"""Tags that are handed over by reference."""

INSTANCES = ("M0", "M1", "Many[1]", "Many[Index]", "Houses[1].Guest", "Houses[Index].Guest")
"""Instances of the first add-on instruction, which may be called any number of times."""

_INSTANCE_TAGS = [
    "TYPE House (Number : INT, Guest : Mixer)",
    "TAG M0 : Mixer",
    "TAG M1 : Mixer",
    "TAG Many : Mixer[3]",
    "TAG Houses : House[2]",
    "TAG D0 : Deep",
    "TAG Ds : Deep[2]",
]

DEEP_LOGIC = (
    "Mixer(Inner,On,Kept,Kept,Total);",
    "XIC(On)Mixer(More[Kept],Flag,5,Kept,Kept);",
    "Mixer(More[1],0,Row[Kept],Row[1],Own.Both[1]);",
    "Mixer(Inner,1,Total,Inner.Sum,More[Kept].Sum);",
    "XIC(Flag)OTU(Flag);",
    "XIO(Flag)ONS(Flag)ADD(Total,1,Kept);",
    "XIC(On)OTE(Flag);",
    "COP(First,Own.Words[1],3);",
    "COP(Row[1],First,2);",
    "COP(Own,Other,1);",
    "FLL(Kept,First,3);",
    "CPT(Row[Kept],Row[0]+Own.Words[Kept]);",
    "TON(Time,?,?)XIC(Time.DN)MOV(1,Kept);",
    "XIC(On)MOV(0,Kept);",
    "EQU(Label,'abc')MOV(2,Label.LEN);",
    "XIC(Flag)FFL(Kept,Row,Queue,?,?)XIC(Queue.DN)OTU(Queue.EN);",
    "XIO(Flag)LFU(Row,Total,Queue,?,?);",
    "XIC(On)BSL(Own.Both,Shift,Flag,?);",
    "SIZE(Row,0,Kept);",
    "FSC(Shift,?,?,2,Own.Words[Shift.POS]>Kept);",
    "ALMA(Level,Kept,Flag,0,0,?,?,?,?)XIC(Level.HInAlarm)OTE(Flag);",
)
"""Rungs of an add-on instruction that calls another one."""

DEEP_HEAD = """\
TYPE Packet (Words : INT[4], Both : DINT[2])
INSTRUCTION Deep
INPUT On : BOOL REQUIRED
INOUT Flag : BOOL
INOUT Total : DINT
INOUT Row : INT[3]
INOUT First : INT
INOUT Time : TIMER
INOUT Label : STRING
LOCAL Inner : Mixer
LOCAL More : Mixer[2] := [{"Kept": 2}]
LOCAL Kept : DINT := 1
LOCAL Own : Packet
LOCAL Other : Packet
LOCAL Queue : CONTROL := {"LEN": 3}
LOCAL Shift : CONTROL := {"LEN": 4}
LOCAL Level : ALARM_ANALOG := {"HLimit": 2.0, "HEnabled": true}"""


@st.composite
def add_ons(draw):
    """Text of an add-on instruction, and calls of some of its instances."""

    def routine(name):
        lines = draw(st.lists(st.sampled_from(LOGIC), min_size=1, max_size=4))
        return [f"ROUTINE {name}", *lines, "END"]

    text = [
        "INSTRUCTION Mixer",
        "INPUT On : BOOL REQUIRED",
        "INPUT Amount : DINT REQUIRED",
        "OUTPUT Sum : DINT REQUIRED",
        "OUTPUT Late : BOOL",
        "INOUT Shared : DINT",
        "LOCAL Kept : DINT",
        "LOCAL Edge : BOOL",
        "LOCAL Time : TIMER",
        "LOCAL Times : COUNTER",
        "LOCAL Table : DINT[3]",
        *(f'LOCAL {name} : CONTROL := {{"LEN": 3}}' for name in ("Look", "Fill", "Queue")),
        *routine("Logic"),
        *(routine("EnableInFalse") if draw(st.booleans()) else ()),
        *(routine("Prescan") if draw(st.booleans()) else ()),
        "END INSTRUCTION",
    ]
    deep = draw(st.lists(st.sampled_from(DEEP_LOGIC), min_size=1, max_size=6))
    text += [*DEEP_HEAD.splitlines(), "ROUTINE Logic", *deep, "END", "END INSTRUCTION"]
    calls = []
    for _ in range(draw(st.integers(0, 4))):
        condition = draw(st.sampled_from(("", "XIC(A)", "XIO(B)")))
        name = draw(st.sampled_from(INSTANCES))
        operands = (draw(read_bits), draw(integer_values), draw(targets), draw(st.sampled_from(SHARED)))
        calls.append(f"{condition}Mixer({name},{','.join(operands)})GRT({name}.Sum,50)OTE(C);")
    for _ in range(draw(st.integers(0, 2))):
        name = draw(st.sampled_from(("D0", "Ds[1]", "Ds[Index]")))
        flag, total = draw(bits), draw(st.sampled_from(SHARED))
        first = draw(
            st.sampled_from(("Word", "Block[5]", "Block[Index]", "Local:1:O.Data[2]", "Parts[1].Size"))
        )
        time, label = draw(st.sampled_from(TIMERS)), draw(st.sampled_from(("Name", "Text")))
        calls.append(f"Deep({name},{draw(read_bits)},{flag},{total},Block,{first},{time},{label})OTE(C);")
    return text, calls


@st.composite
def programs(draw):
    """Text of a program with a main routine, a subroutine and an add-on instruction."""
    main = draw(jumping_routines())
    sub = draw(st.lists(rungs(subroutine=True), max_size=3))
    again = draw(st.lists(rungs(subroutine=True), max_size=2))
    definition, calls = draw(add_ons())
    for call in calls:
        main.insert(draw(st.integers(0, len(main) - 1)), call)
    text = [
        TAGS.replace("SLOT axis", "\n".join([*definition, *_INSTANCE_TAGS, "SLOT axis"])),
        "ROUTINE Main",
        *main,
        "END",
        "ROUTINE Sub",
        "SBR(Index);",
        *sub,
        "XIC(A)RET(Word);",
        "RET(Long);",
        "END",
        "ROUTINE Whole",
        "SBR(Taken,Label,Row);",
        "ADD(Taken.Size,1,Taken.Size)CONCAT(Label,'z',Label)MOV(Row[1],Row[0]);",
        "RET(Taken,Label,Row);",
        "END",
        "ROUTINE Pass",
        *again,
        "XIC(A)XIO(B)BRK();",
        "ADD(Wide,Turn,Wide);",
        "END",
    ]
    return "\n".join(text) + "\n"


@st.composite
def stimuli(draw):
    """What is set before each scan, and how long after the one before it runs."""
    return draw(
        st.lists(
            st.tuples(
                st.sampled_from((0.7, 1.0, 10.0, 33.3)),
                st.dictionaries(st.sampled_from(("A", "B", "C")), st.booleans(), max_size=3),
                st.dictionaries(
                    st.sampled_from(("Index", "Wide", "Small", "Word", "Long")),
                    st.integers(-2, 9),
                    max_size=2,
                ),
                st.dictionaries(
                    st.sampled_from(("Ratio", "Share")), st.sampled_from((2.5, -0.5, 1e38, 0.1)), max_size=1
                ),
            ),
            min_size=1,
            max_size=6,
        )
    )
