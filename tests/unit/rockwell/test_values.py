"""Values of an export: bytes, texts, and what does not fit; a problem is that of one tag, with its line."""

import struct

import pytest
from l5x_files import (
    add_on,
    data_type,
    document,
    ladder,
    machine,
    member,
    module,
    parameter,
    program,
    structured,
    tag,
    task,
    value,
)
from scanrack.commands import build
from typer.testing import CliRunner


def raw(name, kind, data, dims="", more=""):
    """A tag with its memory as bytes, as exports of revision 17 and later begin each."""
    length = f' Dimensions="{dims}"' if dims else ""
    shown = data.hex(" ").upper()
    return (
        f'<Tag Name="{name}" TagType="Base" DataType="{kind}"{length}>\n<Data>{shown}</Data>\n{more}</Tag>\n'
    )


def string(text, room=82):
    data = text.encode("latin-1")
    size = -(-(4 + room) // 4) * 4
    return (struct.pack("<i", len(data)) + data).ljust(size, b"\0")


def first_of(text):
    return f'<Data Format="String" Length="{len(text)}">\n<![CDATA[\'{text}\']]>\n</Data>'


RECIPE = data_type(
    "Recipe",
    member("ZZ0", "SINT", hidden=True),
    member("On", "BIT", target="ZZ0", bit=0),
    member("Hot", "BIT", target="ZZ0", bit=3),
    member("Small", "INT"),
    member("Speed", "REAL"),
    member("Steps", "DINT", 3),
    member("Wait", "TIMER"),
    member("Name", "STRING"),
    member("Flags", "BOOL", 32),
)
RECIPE_BYTES = (
    struct.pack("<bxhf3i", 0b1001, -3, 1.5, 1, 2, -3)
    + struct.pack("<Iii", 1 << 29 | 1 << 31, 5000, 70)
    + string("pie")
    + struct.pack("<I", 1 << 31 | 1 << 2)
)


@pytest.mark.parametrize(
    ("kind", "dims", "data", "expected"),
    [
        ("DINT", "", struct.pack("<i", -60), -60),
        ("BOOL", "", b"\1", True),
        ("SINT", "", b"\xff", -1),
        ("INT", "3", struct.pack("<3h", 7, -8, 9) + b"\0\0", [7, -8, 9]),
        ("REAL", "2", struct.pack("<2f", 0.5, -2), [0.5, -2.0]),
        ("LINT", "", struct.pack("<q", 1 << 40), 1 << 40),
        ("BOOL", "64", struct.pack("<2I", 1 << 5, 1 << 31), [place in (5, 63) for place in range(64)]),
        ("DINT", "2 3", struct.pack("<6i", *range(6)), [[0, 1, 2], [3, 4, 5]]),
        ("STRING", "", string("hello"), "hello"),
    ],
)
def test_bytes_are_the_memory_of_a_tag(imported, kind, dims, data, expected):
    found = imported(machine("NOP();", tags=[raw("T", kind, data, dims)]))
    assert found.controller.tags["T"] == expected
    assert (found.report.notes, found.report.lost) == ([], [])


def test_bytes_of_a_structure(imported):
    found = imported(machine("NOP();", types=[RECIPE], tags=[raw("R", "Recipe", RECIPE_BYTES * 2, "2")]))
    recipe = found.controller.tags["R[1]"]
    assert (recipe["On"], recipe["Hot"], recipe["Small"], recipe["Speed"]) == (True, True, -3, 1.5)
    assert (recipe["Steps"], recipe["Name"]) == ([1, 2, -3], "pie")
    assert recipe["Wait"] == {"EN": True, "TT": False, "DN": True, "PRE": 5000, "ACC": 70}
    assert [place for place, on in enumerate(recipe["Flags"]) if on] == [2, 31]


def test_bytes_are_the_truth_where_both_forms_stand(imported):
    """An array of strings has all texts as bytes, and the first one as a text."""
    months = "January", "February", "March"
    both = raw("M", "STRING", b"".join(map(string, months)), "3", first_of("January"))
    count = raw("N", "DINT", struct.pack("<i", 7), "", f'<Data Format="Decorated">{value("DINT", 6)}</Data>')
    found = imported(machine("NOP();", tags=[both, count]))
    assert found.controller.tags["M"] == list(months)
    assert found.controller.tags["N"] == 7


def test_a_length_beyond_its_string_means_all_of_it(imported):
    data = struct.pack("<I", 0x80000453) + b"A" * 84 + string("next")
    found = imported(machine("NOP();", tags=[raw("S", "STRING", data, "2")]))
    assert found.controller.tags["S"] == ["A" * 82, "next"]


def test_an_array_of_strings_with_the_first_text_only(imported):
    months = f'<Tag Name="M" TagType="Base" DataType="STRING" Dimensions="12">{first_of("January")}</Tag>'
    found = imported(machine("NOP();", tags=[months]))
    assert found.controller.tags["M"] == ["January", *[""] * 11]
    assert found.report.lost == ["M"]


def test_values_of_eight_bytes_lie_as_the_revision_has_them(imported):
    """From revision 27 on they lie at multiples of 8; before, the decorated data are read [1756-RM100F]."""
    kind = data_type("Long", member("Small", "DINT"), member("Big", "LINT"))
    shown = (
        '<Data Format="Decorated"><Structure DataType="Long">'
        '<DataValueMember Name="Big" DataType="LINT" Value="9"/></Structure></Data>'
    )
    new = raw("L", "Long", struct.pack("<i4xq", 4, 5), "", shown)
    old = raw("L", "Long", struct.pack("<iq", 4, 9), "", shown)
    assert imported(machine("NOP();", types=[kind], tags=[new])).controller.tags["L.Big"] == 5
    before = machine("NOP();", types=[kind], tags=[old], revision="20.01")
    assert imported(before).controller.tags["L.Big"] == 9


@pytest.mark.parametrize(
    ("tags", "name", "says"),
    [
        (raw("A", "DINT", bytes([1] * 7)), "A", "it has 7 bytes; its type has another size"),
        (raw("A", "MESSAGE", bytes([1] * 7)), "A", "the order of the bytes of a MESSAGE is not known"),
        ('<Tag Name="A" DataType="DINT"><Data>zz</Data></Tag>', "A", "'zz' is not a list of bytes"),
        (tag("A", "DINT", data=value("DINT", 99999999999)), "A", "99999999999 does not fit DINT"),
        (tag("A", "SINT", data=value("SINT", 300)), "A", "300 does not fit SINT: it starts with 44"),
        (tag("A", "INT", data=value("INT", "16#1_0000")), "A", "16#1_0000 does not fit INT"),
        (tag("A", "REAL", data=value("REAL", "1e40")), "A", "1e40 does not fit REAL"),
        (tag("A", "BOOL", data=value("BOOL", 2)), "A", "2 is not a BOOL"),
        (tag("A", "DINT", "-5"), "A", "it is not declared: its dimensions '-5' are not numbers"),
        (
            tag("A", "DINT", "99999999999"),
            "A",
            "it is not declared: its dimensions '99999999999' are not numbers",
        ),
        (tag("A", "DINT", "4", value("DINT", 1)), "A", "its data are of the form DataValue, not Array"),
        (tag("A", "DINT", "2", '<Array><Element Index="[5]" Value="1"/></Array>'), "A", "no element [5]"),
    ],
)
def test_what_does_not_fit_is_one_note_with_its_line(imported, tags, name, says):
    found = imported(machine("OTE(B);", tags=[tag("B", "BOOL"), tags]))
    (note,) = found.report.notes
    assert says in note.text
    assert (note.name, note.line) == (name, 13)
    assert (found.report.lost, found.report.refused, found.report.ran) == ([name], [], 1)


def test_bits_in_another_radix_fit(imported):
    found = imported(machine("NOP();", tags=[tag("A", "INT", data=value("INT", "16#FFFE"))]))
    assert (found.controller.tags["A"], found.report.notes) == (-2, [])


# --- aliases of parts of nested instances


def named(name, kind, target):
    return (
        f'<Parameter Name="{name}" TagType="Alias" DataType="{kind}" Usage="Input" Required="false" '
        f'AliasFor="{target}"/>'
    )


def local(name, kind, dims=""):
    return f'<LocalTag Name="{name}" DataType="{kind}"{dims and f" Dimensions={dims!r}"}/>'


CON = named("CON", "BOOL", "MOD.CON")
LEAF = add_on("Leaf", [parameter("CON", "BOOL", "Input", required=False)], [], ladder("Logic", "NOP();"))
LIMB = add_on("Limb", [CON], [local("MOD", "Leaf")], ladder("Logic", "Leaf(MOD);"))
STEM = add_on("Stem", [named("P", "BOOL", "I.CON")], [local("I", "Limb")], ladder("Logic", "Limb(I);"))


def starts(kind, **values):
    """Decorated data that name members."""
    listed = "".join(
        f'<DataValueMember Name="{name}" DataType="BOOL" Value="{each}"/>' for name, each in values.items()
    )
    return f'<Structure DataType="{kind}">{listed}</Structure>'


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0)])
def test_an_alias_of_an_alias_of_a_nested_instance(imported, order):
    found = imported(
        machine(
            "XIC(S.P)OTE(B);",
            tags=[tag("S", "Stem", data=starts("Stem", P=1)), tag("B", "BOOL")],
            add_ons=[(LEAF, LIMB, STEM)[at] for at in order],
        )
    )
    assert (found.report.notes, found.report.refused) == ([], [])
    assert found.controller.tags["S.I.MOD.CON"] is True
    found.controller.step()
    assert found.controller.tags["B"] is True


@pytest.mark.parametrize(
    ("target", "says"),
    [
        ("W[2]", "P of Odd is a BOOL, and at W[2], a DINT"),
        ("W[9]", "no element 9; must be below 5"),
        ("W[0].40", "no bit 40"),
        ("W[1,1]", "2 subscripts for 1 dimensions"),
        ("W.X", "no X"),
    ],
)
def test_an_alias_of_what_is_not_there_loses_its_value_only(imported, target, says):
    odd = add_on("Odd", [named("P", "BOOL", target)], [local("W", "DINT", "5")], ladder("Logic", "NOP();"))
    tags = [tag("O", "Odd", data=starts("Odd", P=1)), tag("B", "BOOL")]
    found = imported(machine("OTE(B);", tags=tags, add_ons=[odd]))
    assert says in found.report.notes[0].text
    assert (found.report.lost, found.report.refused) == (["O"], [])
    found.controller.step()
    assert found.controller.tags["B"] is True


# --- twice, and in the wrong place


def test_a_second_add_on_of_a_name_is_refused(imported):
    other = add_on("Leaf", [parameter("X", "DINT", "Input")], [], ladder("Logic", "NOP();", "NOP();"))
    found = imported(machine("Leaf(L);", tags=[tag("L", "Leaf")], add_ons=[LEAF, other]))
    report = found.report
    assert (report.rungs, report.imported, len(report.refused), report.ran) == (4, 2, 2, 2)
    assert [each.reason for each in report.objects] == [
        "the file has two add-ons Leaf; the first one is used"
    ]


def test_a_second_type_of_a_name_is_noted(imported):
    types = [data_type("A", member("X", "DINT")), data_type("A", member("Y", "DINT"))]
    found = imported(machine("MOV(1,T.X);", types=types, tags=[tag("T", "A")]))
    assert [(each.name, each.line) for each in found.report.notes] == [("data type A", 10)]
    assert found.report.refused == []


def test_a_second_text_of_a_rung_is_noted(imported):
    texts = "<Text><![CDATA[OTE(A);]]></Text><Text><![CDATA[OTE(B);]]></Text>"
    rung = f'<Rung Number="4" Type="N">{texts}</Rung>'
    found = imported(machine(rung, tags=[tag("A", "BOOL"), tag("B", "BOOL")]))
    assert [(each.name, each.text) for each in found.report.notes] == [
        ("Main.Main rung 4", "it has 2 texts; the first one is read")
    ]
    found.controller.step()
    assert (found.controller.tags["A"], found.controller.tags["B"]) == (True, False)


@pytest.mark.parametrize("scope", ["controller", "program"])
def test_a_module_with_the_name_of_its_instance(imported, scope):
    """Studio looks for a MODULE among the modules."""
    drive = add_on(
        "PF525",
        [parameter("Ref", "MODULE", "InOut"), parameter("State", "INT", "Output")],
        [],
        ladder("Logic", "GSV(Module,Ref,EntryStatus,State)AND(State,16#F000,State);"),
    )
    instance = [tag("VFD", "PF525")]
    routine = ladder("Main", "PF525(VFD,VFD,X);")
    found = imported(
        document(
            modules=[module("VFD", 3)],
            add_ons=[drive],
            tags=[tag("X", "INT"), *(instance if scope == "controller" else [])],
            programs=[program("P", routine, tags=instance * (scope == "program"))],
            tasks=[task("T", "P")],
        )
    )
    assert ([str(each) for each in found.report.refused], found.report.ran) == ([], 2)
    found.controller.step()
    assert found.controller.tags["X"] == 0x4000


def test_an_event_in_an_add_on_and_in_a_program_without_a_task(imported):
    fires = add_on("Fires", [parameter("X", "DINT", "Input")], [], ladder("Logic", "EVENT(Fast);"))
    programs = [program("P", ladder("Main", "Fires(F,1);")), program("Q", ladder("Main", "EVENT(Fast);"))]
    tasks = [task("T", "P"), task("Fast", kind="EVENT")]
    found = imported(document(add_ons=[fires], tags=[tag("F", "Fires")], programs=programs, tasks=tasks))
    assert (found.report.refused, found.report.ran) == ([], 3)
    without = imported(
        document(add_ons=[fires], tags=[tag("F", "Fires")], programs=programs, tasks=tasks[:1])
    )
    assert [each.reason for each in without.report.refused] == ["no event task FAST"] * 2


# --- what a run says


def test_a_run_says_in_one_line_which_tags_lost_a_value(tmp_path):
    tags = [tag("Small", "SINT", data=value("SINT", 300)), tag("Odd", "DINT", "-5"), tag("Lamp", "BOOL")]
    (tmp_path / "machine.L5X").write_text(machine("OTE(Lamp);", tags=tags), encoding="utf-8")
    rack = tmp_path / "machine.toml"
    rack.write_text('program = "machine.L5X"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8")
    answer = CliRunner().invoke(build(), ["run", str(rack), "--scans", "3", "--no-record"])
    assert answer.exit_code == 0
    said = " ".join(answer.output.split())
    assert "values of the export are lost: Small, Odd; scanrack l5x" in said


def test_structured_text_is_counted(imported):
    good = structured("Main", "A := 1;\nIF A > 0 THEN\n    B := 2;\nEND_IF;\nJSR(Other);")
    bad = structured("Other", "A := ;\nB := 1;")
    tags = [tag("A", "DINT"), tag("B", "DINT")]
    found = imported(document(tags=tags, programs=[program("P", good, bad)], tasks=[task("T", "P")]))
    report = found.report.as_json()
    assert report["structured_text"] == {
        "routines": {"total": 2, "imported": 1, "refused": 1, "ran": 1},
        "lines": {"total": 7, "imported": 5, "refused": 2, "ran": 5},
        "statements": {"total": 6, "imported": 4, "refused": 2, "ran": 4},
    }
    assert list(found.report.lines())[1] == (
        "structured text, 2 routines of 7 lines: 6 statements, 4 imported, 2 refused, 4 ran"
    )


def test_a_refused_instruction_has_the_column_of_its_own_and_not_of_its_name(imported):
    report = imported(
        machine("OTE(Lamp)OTE(Count);", tags=[tag("Lamp", "BOOL"), tag("Count", "DINT")])
    ).report
    assert [each.column for each in report.refused] == [10]


def test_only_a_parameter_by_reference_has_a_note(imported):
    tags = [tag("Own", "DINT"), tag("Given", "DINT").replace("<Tag ", '<Tag Usage="InOut" ')]
    text = document(
        programs=[program("Main", ladder("Main", "NOP();"), tags=tags)], tasks=[task("T", "Main")]
    )
    notes = [each for each in imported(text).report.notes if "by reference" in each.text]
    assert [each.name for each in notes] == ["\\Main.Given"]
