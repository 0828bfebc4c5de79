"""Values are those of the file: an independent reader finds the same, in each form and for modules, too."""

import struct
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from l5x_files import add_on, data_type, document, ladder, machine, member, module, parameter, program, tag
from plain_l5x import Document
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.rockwell.l5x import import_l5x

TOP = Path(__file__).parents[3]
FILES = sorted(
    each for folder in ("examples", "benchmarks", "tests") for each in (TOP / folder).rglob("*.L5X")
)


def with_data(made, *forms):
    """A tag with data: bytes, L5K text, or decorated data."""
    return made.replace("</Tag>", f"{''.join(map(form, forms))}</Tag>")


def form(data):
    if isinstance(data, bytes):
        return f"<Data>{data.hex(' ').upper()}</Data>"
    if data.startswith("<"):
        return f'<Data Format="Decorated">{data}</Data>'
    return f'<Data Format="L5K"><![CDATA[{data}]]></Data>'


def local(name, kind, dims=""):
    return f'<LocalTag Name="{name}" DataType="{kind}"{dims and f" Dimensions={dims!r}"}/>'


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_values_of_a_file_are_those_of_an_independent_reader(path):
    controller: Any = import_l5x(path, trial=True).controller
    tags = controller.interpret().tags
    plain = Document(path)
    listed = [pair for name, each in plain.tags() for pair in plain.values(name, each)]
    assert listed
    assert [(name, tags[name]) for name, _ in listed] == listed


# --- add-ons


TALLY = add_on(
    "Tally",
    [
        *(parameter(f"P{number}", "BOOL", "Output", required=False) for number in range(31)),
        parameter("Out", "DINT", "Output", required=False),
        parameter("By", "DINT", "InOut"),
    ],
    [local("Kept", "DINT"), local("Busy", "BOOL"), local("Wait", "TIMER"), local("Small", "INT", "3")],
    ladder("Logic", "ADD(Kept,By,Kept)MOV(Kept,Out);"),
)
WORD = 1 | 1 << 31
"""EnableIn and P29; P30 and Busy are in the second word of BOOLs."""

L5K = f"[{WORD - (1 << 32)},2,500,501,[536870912,800,70],[7,-8,9]]"
BYTES = struct.pack("<5iIii3hxx", WORD - (1 << 32), 2, 500, 501, 0, 1 << 29, 800, 70, 7, -8, 9)
BYTES = BYTES[:16] + BYTES[20:]
SHOWN = (
    '<Structure DataType="Tally"><DataValueMember Name="EnableIn" DataType="BOOL" Value="1"/>'
    '<DataValueMember Name="P29" DataType="BOOL" Value="1"/>'
    '<DataValueMember Name="P30" DataType="BOOL" Value="0"/>'
    '<DataValueMember Name="Out" DataType="DINT" Value="500"/></Structure>'
)
HOLDER = data_type("Holder", member("Level", "DINT"), member("In", "Tally", 2))


@pytest.mark.parametrize("data", [(L5K, SHOWN), (BYTES, SHOWN), (L5K,), (BYTES,)])
def test_local_tags_of_an_add_on_begin_with_the_file(imported, data):
    tags = [with_data(tag("T", "Tally"), *data), tag("One", "DINT", data=_value(1))]
    found = imported(machine("Tally(T,One);", add_ons=[TALLY], tags=tags))
    assert (found.report.notes, found.report.refused, found.report.faults) == ([], [], {})
    for engine in (found.controller.compile(), found.controller.interpret()):
        first = engine.tags["T"]
        assert [first[name] for name in ("P29", "P30", "Busy", "Out", "Kept")] == [
            True,
            False,
            True,
            500,
            501,
        ]
        assert (first["Wait"]["DN"], first["Wait"]["ACC"], first["Small"]) == (True, 70, [7, -8, 9])
        engine.step()
        assert (engine.tags["T.Out"], engine.tags["T.Kept"]) == (502, 502)


def _value(number):
    return f'<DataValue DataType="DINT" Value="{number}"/>'


def test_add_ons_in_structures_and_arrays(imported):
    blank = L5K.replace("501", "0").replace("500", "0")
    both = f"[[3,[{L5K},{blank}]],[4,[{blank},{L5K}]]]"
    tags = [with_data(tag("H", "Holder", "2"), both), tag("One", "DINT")]
    found = imported(machine("Tally(H[0].In[0],One);", add_ons=[TALLY], types=[HOLDER], tags=tags))
    assert found.report.notes == []
    kept = [[found.controller.tags[f"H[{at}].In[{place}].Kept"] for place in (0, 1)] for at in (0, 1)]
    assert (kept, found.controller.tags["H[1].Level"]) == ([[501, 0], [0, 501]], 4)


def test_a_member_with_an_unknown_memory_has_its_decorated_data_and_a_note_in_local_tags(imported):
    outer = add_on(
        "Outer", [], [local("Loop", "PID_ENHANCED"), local("Kept", "DINT")], ladder("Logic", "NOP();")
    )
    plain = data_type("Plain", member("Level", "DINT"), member("Loop", "PID_ENHANCED"))
    loop = (
        '<Structure DataType="Plain"><DataValueMember Name="Level" DataType="DINT" Value="7"/>'
        '<StructureMember Name="Loop" DataType="PID_ENHANCED"><DataValueMember Name="PGain" DataType="REAL" '
        'Value="2.5"/></StructureMember></Structure>'
    )
    tags = [
        with_data(tag("O", "Outer"), "[1,[0,0,1.5],9]"),
        with_data(tag("P", "Plain"), "[7,[0,0,9]]", loop),
    ]
    found = imported(machine("Outer(O);", add_ons=[outer], types=[plain], tags=tags))
    tags = found.controller.tags
    assert (tags["O.Kept"], tags["P.Level"], tags["P.Loop.PGain"]) == (9, 7, 2.5)
    assert found.report.lost == ["O"]
    assert "PID_ENHANCED in local tags start with their defaults" in found.report.notes[0].text


def test_data_of_another_version_of_an_add_on_are_lost_and_said(imported):
    tags = [with_data(tag("T", "Tally"), "[3,1,2]", SHOWN), tag("One", "DINT")]
    found = imported(machine("Tally(T,One);", add_ons=[TALLY], tags=tags))
    assert found.controller.tags["T.Out"] == 500
    assert [each.text for each in found.report.notes] == ["its data are of another version of Tally"]


# --- forms that differ


@pytest.mark.parametrize(
    ("made", "forms", "value", "says"),
    [
        (
            tag("T", "DINT"),
            (struct.pack("<i", 7), "6", _value(5)),
            7,
            "its forms differ: bytes 7, L5K 6, Decorated 5; the bytes count",
        ),
        (tag("T", "DINT"), ("6", _value(0)), 6, "its forms differ: L5K 6, Decorated 0; the L5K count"),
        (tag("T", "DINT"), ("0", _value(5)), 0, "its forms differ: L5K 0, Decorated 5; the L5K count"),
        (
            tag("T", "Pair", "2"),
            (
                "[[1,1.5],[0,2.5]]",
                '<Array DataType="Pair" Dimensions="2"><Element Index="[1]"><Structure DataType="Pair">'
                '<DataValueMember Name="On" DataType="BOOL" Value="1"/>'
                '<DataValueMember Name="Speed" DataType="REAL" Value="2.5"/></Structure></Element></Array>',
            ),
            [{"On": True, "Speed": 1.5}, {"On": False, "Speed": 2.5}],
            "its forms differ at [1].On: L5K False, Decorated True; the L5K count",
        ),
    ],
)
def test_forms_that_differ_are_named_with_their_values(imported, made, forms, value, says):
    pair = data_type(
        "Pair", member("Z", "SINT", hidden=True), member("On", "BIT", target="Z"), member("Speed", "REAL")
    )
    found = imported(machine("NOP();", types=[pair], tags=[with_data(made, *forms)]))
    assert found.controller.tags["T"] == value
    assert [each.text for each in found.report.notes] == [says]
    assert found.report.lost == ["T"]


@pytest.mark.parametrize(
    ("kind", "forms"),
    [
        ("REAL", (struct.pack("<f", 0.1), "1.00000001e-001", '<DataValue DataType="REAL" Value="0.1"/>')),
        ("LREAL", ("1.23456789012346e+000", '<DataValue DataType="LREAL" Value="1.2345678901234567"/>')),
        (
            "STRING",
            (
                "[3,'it$'$00$00']",
                '<Structure DataType="STRING"><DataValueMember Name="LEN" '
                'DataType="DINT" Value="3"/><DataValueMember Name="DATA" DataType="STRING">'
                "<![CDATA['it$'']]></DataValueMember></Structure>",
            ),
        ),
        (
            "TIMER",
            (
                "[-536655872,100,7]",
                '<Structure DataType="TIMER"><DataValueMember Name="PRE" '
                'DataType="DINT" Value="100"/><DataValueMember Name="ACC" DataType="DINT" Value="7"/>'
                '<DataValueMember Name="EN" DataType="BOOL" Value="1"/></Structure>',
            ),
        ),
    ],
)
def test_forms_of_one_value_agree(imported, kind, forms):
    found = imported(machine("NOP();", tags=[with_data(tag("T", kind), *forms)]))
    assert (found.report.notes, found.report.lost) == ([], [])


# --- modules


def io(kind, type_, members, *forms):
    """A tag of a module: `InputTag`, the name of its type, decorated members, and other forms."""
    shown = f'<Structure DataType="{type_}">{members}</Structure>'
    return f"<{kind}>{''.join(forms)}{form(shown)}</{kind}>"


def one(name, kind, value):
    return f'<DataValueMember Name="{name}" DataType="{kind}" Value="{value}"/>'


def built(modules, *rungs, tags=()):
    main = ladder("Main", *(rungs or ("NOP();",)))
    return document(modules=modules, tags=tags, programs=[program("Main", main)])


STATE = 0b1010_0000_0000_0001 - (1 << 16)
BITS = "".join(one(f"Bit{place}", "BOOL", place in (0, 13, 15)) for place in range(16)).replace("True", "1")
BITS = BITS.replace("False", "0")


def test_a_word_and_its_bits_are_one_memory(imported):
    """As many BOOLs as the word before them has bits are its bits; `Data` says nothing else."""
    word = struct.pack("<hh", STATE, 60)
    drive = io(
        "OutputTag",
        "AB:Drive:O:0",
        one("Command", "INT", STATE) + BITS + one("Speed", "INT", 60),
        form(word),
        f"<ForceData>{word.hex(' ')} 00 20 FF FF 00 20 07 00</ForceData>",
    )
    rungs = ("OTE(Local:5:O.Bit1);", "MOV(Local:5:O.Command,Seen);", "MOV(Local:5:O.Speed,Hz);")
    found = imported(built([module("Drive", 5, drive)], *rungs, tags=[tag("Seen", "INT"), tag("Hz", "INT")]))
    report = found.report
    assert (report.notes, report.refused, report.lost) == ([], [], [])
    assert report.forces == {"Local:5:O.Command.13": True, "Local:5:O.Speed": 7}
    for engine in (found.controller.compile(), found.controller.interpret()):
        engine.step()
        assert (engine.tags["Seen"], engine.tags["Hz"]) == (STATE | 2, 60)
        engine.tags["Local:5:O.Command"] = 4
        assert [engine.tags[f"Local:5:O.Bit{place}"] for place in (0, 1, 2)] == [False, False, True]


@pytest.mark.parametrize(
    ("names", "word", "values", "places"),
    [
        (["Ch0Status", "Ch1Status", "Ch2Status"], 4, "001", [0, 1, 2]),
        (["Low_2", "High_9", "On"], 1 << 9, "010", [2, 9, None]),
        (["Ready", "Active"], 1, "10", [None, None]),
        (["Ch0Status", "Ch1Status"], 1, "01", [None, None]),  # the values are other ones
    ],
)
def test_bits_that_the_file_does_not_place_have_their_own_memory(imported, names, word, values, places):
    bits = "".join(one(name, "BOOL", value) for name, value in zip(names, values, strict=True))
    panel = io("InputTag", "X:Panel:I:0", one("Fault", "DINT", 0) + one("Status", "INT", word) + bits)
    report = imported(built([module("Panel", 5, panel)])).report
    noted = "BOOLs of its Status have their own memory" in "".join(each.text for each in report.notes)
    assert (noted, report.lost) == (None in places, [])
    tags = imported(built([module("Panel", 5, panel)])).controller.tags
    assert [tags[f"Local:5:I.{name}"] for name in names] == [value == "1" for value in values]
    tags["Local:5:I.Status"] = -1
    placed = [value == "1" if place is None else True for value, place in zip(values, places, strict=True)]
    assert [tags[f"Local:5:I.{name}"] for name in names] == placed


@pytest.mark.parametrize(
    ("kind", "inside", "size", "where", "value"),
    [
        ("InputTag", f"<ForceData>{'00 ' * 4}0B 00 16 00{' 00' * 16}</ForceData>", 4, "I.Data[1]", 22),
        ("OutputTag", form("[[33,44]]"), 4, "O.Data[1]", 44),
        ("OutputTag", form("[[1,2,3,-4]]"), 4, "O.Data[3]", -4),
        ("OutputTag", form(struct.pack("<hh", 33, 44)), 4, "O.Data[1]", 44),
    ],
)
def test_tags_without_decorated_data_have_the_size_of_their_connection(
    imported, kind, inside, size, where, value
):
    drive = module("Drive", 5, f"<{kind}>{inside}</{kind}>", catalog="ETHERNET-MODULE")
    drive = drive.replace('RPI="20000"', f'RPI="20000" InputSize="{size}" OutputSize="{size}"')
    found = imported(built([drive]))
    assert (found.controller.tags[f"Local:5:{where}"], found.report.lost) == (value, [])


def test_values_of_a_module_that_show_no_type_are_the_reason_of_its_rungs(imported):
    panel = module("Panel", 5).replace(
        "<Connections>", f"<ConfigTag>{form('[1,2,3]')}</ConfigTag><Connections>"
    )
    report = imported(built([panel])).report
    assert report.lost == ["Local:5:C"]


def test_outputs_of_a_simulated_module_begin_with_the_file(tmp_path):
    """What the program does not write keeps the value of the file; prescan clears the coil."""
    words = "".join(f'<Element Index="[{at}]" Value="{at + 10}"/>' for at in range(8))
    data = f'<ArrayMember Name="Data" DataType="INT" Dimensions="8">{words}</ArrayMember>'
    feed = module("Feed", 1, io("OutputTag", "AB:1769_MODULE:O:0", data), catalog="1769-MODULE")
    text = built(
        [feed],
        "MOV(3,Local:1:O.Data[2]);",
        "XIC(Never)OTE(Local:1:O.Data[1].1);",
        tags=[tag("Never", "BOOL")],
    )
    (tmp_path / "machine.L5X").write_text(text, encoding="utf-8")
    rack = tmp_path / "rack.toml"
    rack.write_text('program = "machine.L5X"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8")
    job = load_job(str(rack))
    with ExitStack() as ports:
        run = JobRun(job, ports, RunOptions())
        run.run(2)
        assert list(run.rack.slots[1].outputs) == [10, 11 & ~2, 3, 13, 14, 15, 16, 17]
