"""Hypothesis strategies for structured text: every statement and operator, over the tags of rungs."""

from hypothesis import strategies as st
from ladder_programs import BITS, INTEGERS, READ_BITS, REALS, TAGS
from ladder_programs import expressions as expressions_of_rungs

DATA_FILES = {"O:1.5": "Local:1:O.Data[5]", "I:1.0/7": "Local:1:I.Data[0].7"}
"""Addresses of data files, which structured text does not have, and what they mean."""


def _in_structured_text(text):
    for file, image in DATA_FILES.items():
        text = text.replace(file, image)
    return text


expressions = expressions_of_rungs.map(_in_structured_text)
EXTREMES = ("Timed.PRE", "Timers[0].PRE", "Counted.ACC", "Counted.PRE")
PARAMETERS = (
    "Timed.TimerEnable",
    "Timed.Reset",
    "Timers[1].TimerEnable",
    "Timers[Index].TimerEnable",
    "Counted.CUEnable",
    "Counted.CDEnable",
    "Counted.Reset",
    "Shot.InputBit",
)
bits = st.sampled_from((*BITS, *PARAMETERS))
read_bits = st.sampled_from(READ_BITS).map(_in_structured_text)
strings = st.sampled_from(("Name", "Text", "Names[1]", "Names[Index]"))
string_values = st.one_of(strings, st.sampled_from(("'abc'", "''", "'a$'b$$$0D'")))
relations = st.tuples(expressions, st.sampled_from(("=", "<>", "<", "<=", ">", ">=")), expressions).map(
    lambda found: f"({found[0]}) {found[1]} ({found[2]})"
)
equalities = st.tuples(string_values, st.sampled_from(("=", "<>", "<")), string_values).map(" ".join)


def _joined(inner):
    return st.one_of(
        st.tuples(inner, st.sampled_from(("AND", "&", "or", "XOR", "=", "<>", "<")), inner).map(
            lambda found: f"({found[0]}) {found[1]} ({found[2]})"
        ),
        inner.map(lambda found: f"NOT ({found})"),
        inner.map(lambda found: f"({found}) = 0"),
    )


conditions = st.recursive(st.one_of(read_bits, relations, equalities), _joined, max_leaves=4)

_ASSIGN = st.sampled_from((":=", "[:=]"))
assignments = st.one_of(
    st.tuples(bits, _ASSIGN, conditions),
    st.tuples(bits, _ASSIGN, st.sampled_from("01")),
    st.tuples(st.sampled_from((*INTEGERS, *REALS)).map(_in_structured_text), _ASSIGN, expressions),
    st.tuples(st.sampled_from(("Index", "Wide")), _ASSIGN, st.sampled_from(("0", "1", "2"))),
    st.tuples(strings, _ASSIGN, string_values),
    st.tuples(st.sampled_from(EXTREMES), st.just(":="), st.sampled_from(("2147483647", "-2147483648", "20"))),
).map(lambda found: f"{' '.join(found)};")
calls = st.sampled_from(
    (
        "COP(Block,Grid,3);",
        "CPS(Name,Names[Index],1);",
        "RES(Delay);",
        "SWPB(Wide,WORD,Other);",
        "JSR(Sub,1,Wide,Other);",
        "TONR(Timed);",
        "TOFR(Timed);",
        "RTOR(Timers[1]);",
        "TONR(Timers[Index]);",
        "CTUD(Counted);",
        "OSRI(Shot);",
        "OSFI(Shot);",
        "TND();",
        "RETURN;",
        ";",
        "// a comment",
    )
)
labels = st.tuples(
    st.sampled_from(("0", "1", "-2", "3..7", "16#FF", "-10..-3", "2.5")),
    st.sampled_from(("", ", 9", ", 100..200")),
).map("".join)


_KINDS = ("assign", "assign", "call", "blend", "if", "case", "for", "while", "repeat", "region")

_LIMIT = "T := T+1; IF T > 40 THEN EXIT; END_IF;"
"""First in every loop: one that counts far takes as long in the interpreter as a hundred others."""


@st.composite
def blocks(draw, depth=2, *, loop=False):
    """Statements, `depth` deep in one another."""
    found = []
    for _ in range(draw(st.integers(1, 4))):
        kind = draw(st.sampled_from(_KINDS))
        if kind == "assign" or (not depth and kind not in ("call", "blend")):
            found.append(draw(assignments))
        elif kind == "blend":
            found.append(draw(blends))
        elif kind == "call":
            found.append("EXIT;" if loop and draw(st.booleans()) else draw(calls))
        else:
            found.append(draw(_COMPOUND[kind](depth - 1, loop)))
    return "\n".join(found)


@st.composite
def _ifs(draw, depth, loop):
    text = f"IF {draw(conditions)} THEN\n{draw(blocks(depth, loop=loop))}\n"
    for _ in range(draw(st.integers(0, 2))):
        text += f"ELSIF {draw(conditions)} THEN\n{draw(blocks(depth, loop=loop))}\n"
    if draw(st.booleans()):
        text += f"ELSE\n{draw(blocks(depth, loop=loop))}\n"
    return text + "END_IF;"


@st.composite
def _cases(draw, depth, loop):
    text = f"CASE {draw(expressions)} OF\n"
    for _ in range(draw(st.integers(0, 3))):
        text += f"{draw(labels)}:\n{draw(blocks(depth, loop=loop))}\n"
    if draw(st.booleans()):
        text += f"ELSE\n{draw(blocks(depth, loop=loop))}\n"
    return text + "END_CASE;"


@st.composite
def _fors(draw, depth, _loop):
    count = draw(st.sampled_from(("I", "J", "Index", "Small", "Block[2]", "Block[Index]")))
    first, last = (
        draw(st.sampled_from(("0", "2", "Index", "10"))),
        draw(st.sampled_from(("3", "0", "Index+2", "Wide"))),
    )
    by = draw(st.sampled_from(("", " BY 2", " BY -1", " BY Index", " BY 1.5")))
    body = draw(blocks(depth, loop=True))
    return f"FOR {count} := {first} TO {last}{by} DO\n{_LIMIT}\n{body}\nEND_FOR;"


@st.composite
def _whiles(draw, depth, _loop):
    body = draw(blocks(depth, loop=True))
    return f"WHILE {draw(conditions)} DO\n{_LIMIT}\n{body}\nEND_WHILE;"


@st.composite
def _repeats(draw, depth, _loop):
    body = draw(blocks(depth, loop=True))
    return f"REPEAT\n{_LIMIT}\n{body}\nUNTIL {draw(conditions)} END_REPEAT;"


@st.composite
def _regions(draw, depth, loop):
    return f"#region some name\n{draw(blocks(depth, loop=loop))}\n#endregion"


_COMPOUND = {
    "if": _ifs,
    "case": _cases,
    "for": _fors,
    "while": _whiles,
    "repeat": _repeats,
    "region": _regions,
}

LOGIC = (
    "IF On THEN Sum := Amount + Kept; ELSIF Edge THEN Sum := Kept; END_IF;",
    "Time.TimerEnable := On XOR Edge; TONR(Time); Late := Time.DN;",
    "Shot.InputBit := On; OSRI(Shot); IF Shot.OutputBit THEN Kept := Kept + 1; END_IF;",
    "FOR Kept := 0 TO 2 DO Table[Kept] := Shared + Kept; IF Table[Kept] > 50 THEN EXIT; END_IF; END_FOR;",
    "Shared := Shared + Amount;",
    "CASE Kept OF 0: Label := 'zero'; 1..3: Label := 'some'; ELSE Label := ''; END_CASE;",
    "IF Label = 'some' THEN Edge := NOT Edge; END_IF;",
    "WHILE Kept < 3 DO Kept := Kept + 1; END_WHILE; IF On THEN RETURN; END_IF;",
    "Table[Kept] [:=] Table[0] MOD 7; EnableOut := Late;",
    "COP(Table[0],Table[1],2); List[Kept] := List[0] + 1;",
    "Kept := Amount; Rate := Rate * 1.5 + Kept;",
    "Edge := Shared.3 OR List[1] > Table[1];",
)
"""Statements that an add-on instruction may consist of."""


@st.composite
def add_ons(draw):
    """Text of an add-on instruction in structured text."""

    def routine(name):
        lines = draw(st.lists(st.sampled_from(LOGIC), min_size=1, max_size=4))
        return [f"ROUTINE {name} ST", *lines, "END"]

    return [
        "INSTRUCTION Blend",
        "INPUT On : BOOL REQUIRED",
        "INPUT Amount : DINT REQUIRED",
        "INPUT Rate : REAL REQUIRED",
        "OUTPUT Sum : DINT REQUIRED",
        "OUTPUT Late : BOOL",
        "INOUT Shared : DINT",
        "INOUT List : DINT[3]",
        "LOCAL Kept : DINT",
        "LOCAL Edge : BOOL",
        "LOCAL Label : STRING",
        "LOCAL Time : FBD_TIMER",
        "LOCAL Shot : FBD_ONESHOT",
        "LOCAL Table : DINT[3]",
        *routine("Logic"),
        *(routine("Prescan") if draw(st.booleans()) else ()),
        "END INSTRUCTION",
        "TAG F0 : Blend",
        "TAG Fs : Blend[2]",
        "TAG Shares : DINT[3]",
    ]


blends = st.tuples(
    st.sampled_from(("F0", "F0", "Fs[1]", "Fs[Index]")),
    st.one_of(st.sampled_from(("A", "1", "Wide.3")), st.deferred(lambda: conditions)),
    expressions,
    expressions,
    st.sampled_from(("Other", "Word", "Ratio", "Block[Index]")),
    st.sampled_from(("Wide", "Grid[1,1]", "Shares[0]")),
    st.just("Shares"),
).map(lambda found: f"Blend({','.join(found)});")

MORE_TAGS = """TAG I : DINT
TAG J : INT
TAG T : DINT
TAG Names : STRING[3]
TAG Timed : FBD_TIMER := {"PRE": 15}
TAG Timers : FBD_TIMER[2] := [{"PRE": 0}, {"PRE": 30}]
TAG Counted : FBD_COUNTER := {"PRE": 2, "ACC": 1}
TAG Shot : FBD_ONESHOT
"""


@st.composite
def structured(draw):
    """Text of a program whose routines are structured text."""
    flags = draw(st.sampled_from(("", "C := S:V AND S:Z;\n")))
    return "\n".join(
        [
            TAGS + MORE_TAGS,
            *draw(add_ons()),
            "ROUTINE Main ST",
            "T := 0;",
            flags + draw(blocks(3)),
            "END",
            "ROUTINE Sub ST",
            "SBR(J);",
            draw(blocks(1)).replace("JSR(Sub,1,Wide,Other);", "Other := J*3;").replace("RETURN;", "RET(J);"),
            "RET(Long);",
            "END",
            "",
        ]
    )
