"""Mutated exports: each is refused with the import's own error, or every rung is imported or refused."""

import json
import re
import tomllib
from pathlib import Path

import pytest
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st
from l5x_files import (
    add_on,
    alias,
    block,
    connector,
    data_type,
    document,
    ladder,
    member,
    module,
    parameter,
    program,
    reference,
    rung,
    sheets,
    structured,
    tag,
    task,
    value,
    wire,
)
from scanrack.jobs.imports.l5x_rack import rack_of
from scanrack.rockwell.l5x import L5xError
from scanrack.rockwell.l5x.importer import Importer
from scanrack.rockwell.l5x.trial import run_trial
from scanrack.rockwell.l5x.xml.document import parse_document

INPUTS = """<InputTag><Data Format="Decorated"><Structure DataType="AB:1769_DI16:I:0">
<DataValueMember Name="Fault" DataType="DINT" Value="2#0"/>
<DataValueMember Name="Data" DataType="INT" Value="0"/></Structure></Data></InputTag>"""
RECIPE = data_type(
    "Recipe",
    member("ZZ0", "SINT", hidden=True),
    member("On", "BIT", target="ZZ0", bit=3),
    member("Steps", "DINT", 3),
    member("Wait", "TIMER"),
)
RECIPES = """<Array DataType="Recipe" Dimensions="2"><Element Index="[1]"><Structure DataType="Recipe">
<DataValueMember Name="On" DataType="BOOL" Value="1"/>
<ArrayMember Name="Steps" DataType="DINT" Dimensions="3"><Element Index="[2]" Value="7"/></ArrayMember>
</Structure></Element></Array>"""
TWICE = add_on(
    "Twice",
    [parameter("X", "DINT", "Input", default="5"), parameter("Y", "DINT", "Output")],
    ['<LocalTag Name="K" DataType="DINT"><DefaultData Format="L5K">2</DefaultData></LocalTag>'],
    ladder("Logic", "MUL(X,K,Y);"),
    ladder("Postscan", "CLR(Y);"),
    runs='ExecutePrescan="false" ExecutePostscan="true"',
)
RUNGS = (
    rung("XIC(Start)[XIO(Stop) ,XIC(R[1].On) ]OTE(Run);", comment="Starts it."),
    "XIC(Run)TON(R[N].Wait,?,?)Twice(T,N,N);",
    "CPT(N,(N+1)*2)MOV('A',N)COP(R[0],R[1],1)JSR(Text,0);",
    "GSV(WallClockTime,,DateTime,Now[0])MSG(M)XIC(Run)JMP(Here);",
    "LBL(Here)NOP();",
)
MORE = (
    rung("JSR(Taking,1,R[0],R[1])FOR(Blocks,N,0,1);", kind="IR"),
    rung("NOP();", number=1, kind="er"),
    "FFL(R[0],Kept[0],Ctl,3,0)PXRQ(Ask,Download Input Parameters,N)SSV(DataLog,L,On,N);",
)
TAKING = "SBR(Old);", "XIC(&4DA5D0F8:I.Data.3)OTE(Run);", "RET(Old);"
TEXT = "IF N > 3 THEN\n    N := 0;  // again\nEND_IF;\nFOR N := 0 TO 2 DO R[0].Steps[N] := N; END_FOR;"


def bytes_of(text):
    return f"<Data>{text}</Data>"


def said(form, text):
    return f'<Data Format="{form}"><![CDATA[{text}]]></Data>'


def untyped(name, kind, dims, *data):
    length = f' Dimensions="{dims}"' if dims else ""
    return f'<Tag Name="{name}" TagType="Base" DataType="{kind}"{length}>{"".join(data)}</Tag>'


BLOCKS = (
    "".join(reference("IRef", key, each) for key, each in enumerate(("Stop", "5", "N")))
    + block("ADD__F", 3)
    + block("TONR", 4, "Delay", x=9)
    + '<JSR ID="5" X="1" Y="2" Routine="Text" In="N" Ret=""/>'
    + '<AddOnInstruction Name="Outer" ID="6" X="0" Y="0" Operand="Nested" VisiblePins="P"/>'
    + reference("ORef", 7, "N")
    + connector("OCon", 8, "On")
    + connector("ICon", 9, "On")
    + wire(0, "4.TimerEnable")
    + wire(1, "3.SourceA")
    + wire(2, "3.SourceB")
    + wire("3.Dest", "4.PRE", feedback=True)
    + wire("4.ACC", 7)
    + wire("3.Dest", 8)
    + wire(9, "6.P")
)
TAGS = (
    tag("Delay", "FBD_TIMER"),
    alias("Start", "Local:2:I.Data.3"),
    tag("Stop", "BOOL", data=value("BOOL", 0)),
    tag("Run", "BOOL"),
    tag("R", "Recipe", "2", RECIPES),
    tag("N", "DINT", data=value("DINT", "16#0000_0001")),
    tag("T", "Twice"),
    tag("Now", "DINT", "7"),
    tag("M", "MESSAGE"),
    untyped("Raw", "Recipe", "2", bytes_of("0A 00 00 00 " * 56)),
    untyped("Names", "STRING", "2", bytes_of("01 00 00 00 " * 44), said("String", "'a'")),
    untyped("Old", "Recipe", "", said("L5K", "[1,[1,2,3],[0,5,0]]")),
    tag("Nested", "Outer"),
    untyped("Kept", "Recipe", "3", "<ForceData>00 00 00 00 01 00 FF FF 01 00 B8 22</ForceData>"),
    untyped(
        "Held",
        "DINT",
        "",
        '<Data Format="Decorated"><DataValue DataType="DINT" Value="0" ForceValue="2#...._.0.1"/></Data>',
    ),
    *(tag("Ctl", "CONTROL"), tag("Ask", "DINT")),
)
OUTER = add_on(
    "Outer",
    ['<Parameter Name="P" TagType="Alias" DataType="DINT" Usage="Input" Required="false" AliasFor="In.Q"/>'],
    ['<LocalTag Name="In" DataType="Inner"/>'],
    ladder("Logic", "Inner(In);"),
)
INNER = add_on(
    "Inner",
    ['<Parameter Name="Q" TagType="Alias" DataType="DINT" Usage="Input" Required="false" AliasFor="W[1]"/>'],
    ['<LocalTag Name="W" DataType="DINT" Dimensions="3"/>'],
    ladder("Logic", "ADD(W[1],1,W[2]);"),
)
WHOLE = document(
    types=[RECIPE],
    modules=[module("DI", 2, INPUTS)],
    add_ons=[TWICE, OUTER, INNER],
    tags=TAGS,
    programs=[
        program(
            *("P", ladder("Main", *RUNGS), structured("Text", TEXT), sheets("Blocks", BLOCKS)),
            *(ladder("More", *MORE), ladder("Taking", *TAKING)),
        ).replace("<Program ", '<Program TestEdits="true" ')
    ],
    tasks=[task("Cycle", "P"), task("Fast", kind="PERIODIC", rate=20)],
)
PARTIAL = document(target="Routine", types=[RECIPE], programs=[program("P", ladder("Main", *RUNGS), main="")])

WORDS = sorted(set(re.findall(r"[A-Za-z_]\w*|\d+", WHOLE)))
ODD = (
    *(
        "",
        "0",
        "-1",
        "99999999999999999999",
        "1e400",
        "&lt;",
        "&#0;",
        "\x00",
        "[" * 40,
        "(" * 40,
        "]]>",
        "'",
        "$",
    ),
    *("16#", "T#", "1.#QNAN", "\\", "S:FS", "Local:9:I", "%", "?", "BIT", "LINT", "É", "<x>", "</Tag>", '"'),
)
PIECES = (r'"[^"]*"', r"[A-Za-z_]\w*", r"\d+", r"<[^>]*>", r"CDATA\[.*?\]\]>", r"[(),.;\[\]]")
"""What is replaced, as regular expressions."""


@st.composite
def mutated(draw):
    text = draw(st.sampled_from((WHOLE, PARTIAL)))
    for _ in range(draw(st.integers(1, 4))):
        pattern = draw(st.sampled_from(PIECES))
        found = list(re.finditer(pattern, text, re.DOTALL))
        if not found:
            continue
        piece = draw(st.sampled_from(found))
        other = draw(st.sampled_from(found)).group()
        new = draw(st.sampled_from((other, draw(st.sampled_from(WORDS)), draw(st.sampled_from(ODD)))))
        quoted = f'"{new}"' if pattern.startswith('"') and not new.startswith('"') else new
        text = text[: piece.start()] + quoted + text[piece.end() :]
    return text


@pytest.mark.slow
@settings(max_examples=amount(40))
@given(mutated())
def test_mutated_exports(text):
    try:
        imported = Importer(parse_document(text.encode(), "machine.L5X")).run(trial=True)
    except L5xError:
        return
    report = imported.report
    assert report.imported + len(report.refused) == report.rungs
    slots = [each["number"] for each in tomllib.loads(rack_of(imported, Path("machine.L5X")))["slot"]]
    assert len(set(slots)) == len(slots) > 0
    run_trial(imported, scans=2)
    assert 0 <= report.ran <= report.imported
    assert not [text for text in report.faults.values() if "compiled" in text]
    assert json.dumps(report.as_json())
    assert list(report.lines())


def test_what_is_mutated_is_imported():
    absent = "Twice: no instruction Twice, and no add-on in the export"
    for text, declared, refused in ((WHOLE, 1, []), (PARTIAL, 10, [absent])):
        imported = Importer(parse_document(text.encode(), "machine.L5X")).run(trial=True)
        run_trial(imported, scans=2)
        assert [each.reason for each in imported.report.refused] == refused
        assert imported.report.ran == imported.report.imported
        assert len(imported.report.declared) == declared
