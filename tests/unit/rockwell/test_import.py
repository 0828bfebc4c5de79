"""What is in a document is in the controller."""

import pytest
from l5x_files import (
    add_on,
    after,
    alias,
    data_type,
    diagram,
    document,
    ladder,
    machine,
    member,
    module,
    parameter,
    program,
    rung,
    structured,
    tag,
    task,
    value,
)
from scanrack.ladder.model.stubs import Stubs
from scanrack.rockwell.l5x import import_l5x


def test_rung_tag_and_comment(imported):
    text = machine(
        rung("XIC(Go)OTE(Run);", comment="Starts it."), tags=[tag("Go", "BOOL", data=value("BOOL", 1))]
    )
    found = imported(text.replace("<Tags>\n", f"<Tags>\n{tag('Run', 'BOOL')}", 1))
    assert after(found).Run is True
    (routine,) = found.controller.programs[0].routines
    assert (str(routine.rungs[0]), routine.rungs[0].comment) == ("XIC(Go)OTE(Run);", "Starts it.")
    assert (found.report.rungs, found.report.imported, found.report.ran) == (1, 1, 1)
    assert found.report.complete


def test_origin_is_the_line_of_the_text(imported):
    text = machine("NOP();", "OTE(Lamp);", tags=[tag("Lamp", "BOOL")])
    found = imported(text)
    line = 1 + text[: text.index("OTE(Lamp)")].count("\n")
    assert found.controller.programs[0].routines[0].rungs[1].origin.line == line


RECIPE = data_type(
    "Recipe",
    member("ZZ0", "SINT", hidden=True),
    member("On", "BIT", target="ZZ0", bit=0),
    member("Off", "BIT", target="ZZ0", bit=7),
    member("Speed", "REAL"),
    member("Steps", "DINT", 3),
    member("Wait", "TIMER"),
)
SECOND = """<Array DataType="Recipe" Dimensions="2"><Element Index="[1]"><Structure DataType="Recipe">
<DataValueMember Name="Off" DataType="BOOL" Value="1"/>
<DataValueMember Name="Speed" DataType="REAL" Radix="Float" Value="1.5e+001"/>
<ArrayMember Name="Steps" DataType="DINT" Dimensions="3">
<Element Index="[2]" Value="16#ffff_ffff"/></ArrayMember>
<StructureMember Name="Wait" DataType="TIMER">
<DataValueMember Name="PRE" DataType="DINT" Value="250"/></StructureMember>
</Structure></Element></Array>"""


def test_structures_with_packed_bits_and_decorated_values(imported):
    found = imported(machine("NOP();", types=[RECIPE], tags=[tag("R", "Recipe", "2", SECOND)]))
    tags = after(found)
    assert tags["R[0].Speed"] == 0
    assert (tags["R[1].Off"], tags["R[1].On"], tags["R[1].ZZ0"]) == (True, False, -128)  # bit 7 of a SINT
    assert (tags["R[1].Speed"], tags["R[1].Steps"], tags["R[1].Wait.PRE"]) == (15.0, [0, 0, -1], 250)


def test_strings(imported):
    family = data_type("STR_10", member("LEN", "DINT"), member("DATA", "SINT", 10), family="StringFamily")
    decorated = """<Structure DataType="STR_10"><DataValueMember Name="LEN" DataType="DINT" Value="3"/>
<DataValueMember Name="DATA" DataType="STR_10" Radix="ASCII">
<![CDATA['a$'b']]>
</DataValueMember></Structure>"""
    characters = """<Data Format="String" Length="2"><![CDATA['hi']]></Data>"""
    plain = f'<Tag Name="P" TagType="Base" DataType="STRING">{characters}</Tag>'
    found = imported(machine("NOP();", types=[family], tags=[tag("S", "STR_10", data=decorated), plain]))
    assert (found.controller.tags.S, found.controller.tags.P) == ("a'b", "hi")


def test_l5k_text_where_nothing_is_decorated(imported):
    data = f'<Data Format="L5K"><![CDATA[[1,[3,0,7],[{1 << 29},5000,20]]]]></Data>'  # bit 29 is DN
    kind = data_type("U", member("A", "INT"), member("B", "DINT", 3), member("T", "TIMER"))
    text = f'<Tag Name="X" TagType="Base" DataType="U">{data}</Tag>'
    tags = imported(machine("NOP();", types=[kind], tags=[text])).controller.tags
    assert (tags["X.A"], tags["X.B"], tags["X.T.PRE"], tags["X.T.ACC"]) == (1, [3, 0, 7], 5000, 20)
    assert [tags[f"X.T.{each}"] for each in ("EN", "TT", "DN")] == [False, False, True]


def test_aliases_of_aliases_onto_a_bit_of_a_module(imported):
    shown = """<InputTag><Data Format="Decorated"><Structure DataType="AB:1769_DI16:I:0">
<DataValueMember Name="Fault" DataType="DINT" Value="2#0"/>
<DataValueMember Name="Data" DataType="INT" Value="0"/>
</Structure></Data></InputTag>"""
    tags = [alias("Start", "Inputs.3"), alias("Inputs", "Local:2:I.Data"), tag("Run", "BOOL")]
    found = imported(machine("XIC(Start)OTE(Run);", tags=tags, modules=[module("DI", 2, shown)]))
    found.controller.tags["Local:2:I.Data"] = 8
    assert after(found).Run is True


def test_program_tags_hide_those_of_the_controller(imported):
    programs = [
        program("A", ladder("Main", "MOV(1,X);"), tags=[tag("X", "DINT")]),
        program("B", ladder("Main", "MOV(2,X);")),
    ]
    found = imported(document(tags=[tag("X", "DINT")], programs=programs, tasks=[task("T", "A", "B")]))
    tags = after(found)
    assert (tags[r"\A.X"], tags.X) == (1, 2)


def test_periodic_task(imported):
    programs = [program("Fast", ladder("Main", "ADD(X,1,X);"), tags=[tag("X", "DINT")])]
    text = document(programs=programs, tasks=[task("F", "Fast", kind="PERIODIC", rate=20, priority=3)])
    assert after(imported(text), 5)[r"\Fast.X"] == 3  # at 0, 20 and 40 ms


def test_add_on_with_default_and_local(imported):
    local = (
        '<LocalTag Name="k" DataType="DINT"><DefaultData Format="L5K"><![CDATA[3]]></DefaultData></LocalTag>'
    )
    twice = add_on(
        "Times",
        [parameter("X", "DINT", "Input"), parameter("Y", "DINT", "Output")],
        [local],
        ladder("Logic", "MUL(X,k,Y);"),
    )
    tags = [tag("t", "Times"), tag("a", "DINT", data=value("DINT", 5)), tag("b", "DINT")]
    found = imported(machine("Times(t,a,b);", tags=tags, add_ons=[twice]))
    assert after(found).b == 15
    assert (found.report.rungs, found.report.ran) == (2, 2)


def test_structured_text_has_lines_of_the_file(imported):
    routine = structured("Sub", "n := n + 1;\n// said\nm := n * 2;")
    text = document(
        tags=[tag("n", "DINT"), tag("m", "DINT")],
        programs=[program("Main", ladder("Main", "JSR(Sub,0);"), routine)],
        tasks=[task("T", "Main")],
    )
    found = imported(text)
    assert after(found).m == 2
    (_, sub) = found.controller.programs[0].routines
    assert sub.statements[1].origin.line == 1 + text[: text.index("m := n")].count("\n")


def test_function_blocks_are_refused_by_name(imported):
    text = document(programs=[program("P", ladder("Main", "JSR(Blocks,0);"), diagram("Blocks", "FBD"))])
    report = imported(text).report
    (refused,) = report.objects
    assert (refused.program, refused.routine) == ("P", "Blocks")
    assert "function block diagram" in refused.reason
    assert not report.complete


def test_each_refused_rung_says_where_and_why(imported):
    text = machine("XIC(Here)  FOO(Here);", "XIC(Gone)OTE(Here);", "OTE(Here);", tags=[tag("Here", "BOOL")])
    report = imported(text).report
    assert (report.rungs, report.imported, len(report.refused)) == (3, 1, 2)
    first, second = report.refused
    assert (first.program, first.routine, first.rung, first.column) == ("Main", "Main", 0, 12)
    assert "FOO is unknown" in first.reason
    assert second.line == 1 + text[: text.index("XIC(Gone)")].count("\n")
    assert "no tag Gone" in second.reason


EDITS = ("N", "I", "D", "R", "IR", "rN", "rI", "rR", "e", "er", "i", "r", "d")


@pytest.mark.parametrize(
    ("tested", "runs"),
    [
        ("false", ["N", "D", "R", "rN", "rR", "r", "d"]),  # the original
        ("true", ["N", "I", "IR", "rN", "rI", "r", "d"]),  # accepted edits; pending ones never run
    ],
)
def test_of_online_edits_those_run_that_the_controller_executes(imported, tested, runs):
    rungs = (rung(f"OTE(Ran[{at}]);", number=at, kind=kind) for at, kind in enumerate(EDITS))
    text = machine(*rungs, tags=[tag("Ran", "BOOL", "32")])
    found = imported(text.replace("<Program Name", f'<Program TestEdits="{tested}" Name', 1))
    tags = after(found)
    assert [kind for at, kind in enumerate(EDITS) if tags[f"Ran[{at}]"]] == runs
    assert found.report.refused == []
    assert [(each.type, each.runs) for each in found.report.edits] == [
        (kind, kind in runs) for kind in EDITS[1:]
    ]
    said = "\n".join([*found.report.lines(), *found.report.warnings])
    assert f"online edits, {len(runs) - 1} run and {13 - len(runs)} do not" in said
    assert "Main.Main rung 1 (line" in said
    assert f"I, accepted, to be inserted; it {'runs' if tested == 'true' else 'does not run'}" in said


def test_a_rung_of_an_unknown_type_is_refused_with_its_letter(imported):
    report = imported(machine(rung("NOP();", kind="Q"), rung("NOP();", number=1))).report
    (refused,) = report.refused
    assert refused.reason.startswith("it is of type Q; types of rungs are N, I, D, R, IR,")


@pytest.mark.parametrize(("tested", "value"), [("false", 1), ("true", 2)])
def test_of_edited_structured_text_that_runs_which_the_controller_executes(imported, tested, value):
    whole = structured("Main", "Level := 0;")
    start, end = whole.index("<STContent>"), whole.index("</Routine>")
    kinds = {"PendingEdits": 3, "Original": 1, "TestEdits": 2}
    texts = "".join(
        whole[start:end]
        .replace("0;", f"{number};")
        .replace("<STContent>", f'<STContent OnlineEditType="{kind}">')
        for kind, number in kinds.items()
    )
    text = document(
        tags=[tag("Level", "DINT")], programs=[program("Main", whole[:start] + texts + whole[end:])]
    )
    found = imported(text.replace("<Program Name", f'<Program TestEdits="{tested}" Name', 1))
    assert after(found).Level == value
    ran = {"Original": tested == "false", "TestEdits": tested == "true", "PendingEdits": False}
    assert {each.type: each.runs for each in found.report.edits} == ran


def test_an_encoded_add_on_is_refused_and_calls_pass_its_parameters(imported):
    parts = parameter("X", "DINT", "Input")
    encoded = (
        '<EncodedData EncodedType="AddOnInstructionDefinition" Name="Secret" Revision="1.0">'
        f"<Parameters>{parts}</Parameters>c2VjcmV0</EncodedData>"
    )
    found = imported(machine("Secret(s,7);", "NOP();", tags=[tag("s", "Secret")], add_ons=[encoded]))
    assert (found.report.refused, found.report.ran) == ([], 2)
    assert [each.program for each in found.report.objects] == ["Secret"]
    assert "encoded" in found.report.objects[0].reason
    assert after(found)["s.X"] == 7


def test_an_encoded_add_on_without_parameters_refuses_the_rungs_that_call_it(imported):
    encoded = '<EncodedData EncodedType="AddOnInstructionDefinition" Name="Secret">c2VjcmV0</EncodedData>'
    report = imported(machine("Secret(s,1);", "NOP();", tags=[tag("s", "DINT")], add_ons=[encoded])).report
    assert [each.rung for each in report.refused] == [0]
    assert [each.program for each in report.objects] == ["Secret"]


def test_partial_export_declares_what_it_leaves_out(imported):
    routine = ladder(
        "Sub",
        "XIC(M.Ready)TON(Delay,?,?)MOV(M.Count[3],Total)Mixer(Mix,Total)JSR(Other,0);",
        "EQU(Speed,1.5)OTE(Bits.7);",
    )
    text = document(target="Routine", programs=[program("P", routine, main="")])
    report = imported(text).report
    assert ([each.rung for each in report.refused], report.ran) == ([0], 1)  # Mixer does nothing
    assert report.declared == {
        "add-on Mixer": "instruction that does nothing",
        r"\P.Other": "routine that does nothing",
        "M": "M_type",
        "Delay": "TIMER",
        "Total": "DINT",
        "Mix": "DINT",
        "Speed": "REAL",
        "Bits": "DINT",
    }


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le"])
def test_encodings(imported, encoding):
    text = machine("NOP();", tags=[tag("T", "DINT", comment="Größe")])
    found = imported(text, encoding=encoding)
    assert found.controller.declarations[0].comment == "Größe"


def test_a_call_with_operands_of_a_routine_that_is_refused_is_imported(imported):
    calls = ladder("Main", "JSR(Blocks,1,In,Out)OTE(Called);")
    tags = [tag("In", "DINT"), tag("Out", "DINT"), tag("Called", "BOOL")]
    found = imported(document(tags=tags, programs=[program("P", calls, diagram("Blocks", "FBD"))]))
    assert (found.report.refused, found.report.ran, len(found.report.objects)) == ([], 1, 1)
    assert after(found).Called is True


def test_an_instruction_of_logix_that_is_not_here_is_no_add_on(imported):
    text = document(target="Routine", programs=[program("P", ladder("Sub", "DCM(a,b);"), main="")])
    (refused,) = imported(text).report.refused
    assert "DCM is unknown" in refused.reason


def test_a_rack_runs_a_partial_export_if_it_says_so(tmp_path):
    path = tmp_path / "sub.L5X"
    path.write_text(
        document(target="Program", programs=[program("P", ladder("Main", "XIC(a)OTE(b);"))]), encoding="utf-8"
    )
    assert "no tag a" in import_l5x(path).report.refused[0].reason
    declared = import_l5x(path, Stubs(missing_tags=True)).report
    assert (declared.refused, declared.declared) == ([], {"a": "BOOL", "b": "BOOL"})


def test_an_add_on_refuses_the_rungs_that_name_others_tags(imported):
    logic = ladder("Logic", "ADD(X,1,Y);", "NOP()MOV(Elsewhere,Y);", "JSR(Other,0);")
    parts = [parameter("X", "DINT", "Input"), parameter("Y", "DINT", "Output")]
    text = document(target="AddOnInstructionDefinition", add_ons=[add_on("Next", parts, [], logic)])
    report = imported(text).report
    assert [(each.program, each.rung, each.column) for each in report.refused] == [
        ("Next", 1, 6),
        ("Next", 2, 1),
    ]
    assert "no parameter or local tag Elsewhere" in report.refused[0].reason
    assert report.ran == 1


DRIVE = '<Parameter Name="Drive" TagType="Base" DataType="AB:Drive:I:0" Usage="InOut" Required="true"/>'


def test_an_add_on_whose_parameter_is_of_a_type_that_the_file_leaves_out(imported):
    logic = ladder(
        "Logic", "XIC(Drive.Active)MOV(Drive.Speed[2],Y);", "GRT(Drive.Amps,1.5)OTE(Drive.Word.3);"
    )
    unit = add_on("Unit", [DRIVE, parameter("Y", "DINT", "Output")], [], logic)
    report = imported(document(target="AddOnInstructionDefinition", add_ons=[unit])).report
    assert (report.refused, report.objects, report.ran) == ([], [], 2)
    assert report.declared == {"type AB:Drive:I:0": "Active, Speed, Amps, Word"}


def test_an_add_on_whose_inout_is_a_long_array(imported):
    logic = ladder("Logic", "COP(Text[484],Word,1);", "MOV(Grid[7,40],Word);")
    given = parameter("Text", "SINT", "InOut"), parameter("Grid", "DINT", "InOut")
    text, grid = (
        each.replace("DataType", f'Dimensions="{dims}" DataType')
        for each, dims in zip(given, ("500", "8 300"), strict=True)
    )
    unit = add_on("Unit", [text, grid, parameter("Word", "DINT", "Output", required=False)], [], logic)
    report = imported(document(target="AddOnInstructionDefinition", add_ons=[unit])).report
    assert (report.refused, report.notes, report.ran) == ([], [], 2)


def test_add_ons_whose_inouts_are_too_large_to_be_made_are_not_tried(imported):
    huge = parameter("Bits", "DINT", "InOut").replace("DataType", 'Dimensions="2000000" DataType')
    units = (
        add_on("Large", [huge], [], ladder("Logic", "CLR(Bits[9]);")),
        add_on("Small", [parameter("Word", "DINT", "Output")], [], ladder("Logic", "CLR(Word);")),
    )
    report = imported(document(target="AddOnInstructionDefinition", add_ons=units)).report
    assert (report.refused, report.imported, report.ran) == ([], 2, 1)


def test_a_type_with_a_member_of_a_type_that_the_file_leaves_out(imported):
    types = [data_type("Outer", member("Part", "Inner", 2), member("Own", "DINT"))]
    found = imported(
        machine(
            "XIC(O.Part[1].On)OTE(O.Own.4);",
            "ADD(L[1].Count,1,L[1].Count);",
            types=types,
            tags=[tag("O", "Outer"), tag("L", "Inner", "3")],
        )
    )
    assert found.report.ran == 2
    assert found.report.declared == {"type Inner": "On, Count"}
    assert after(found)["L[1].Count"] == 1


def test_rungs_that_jump_to_a_label_that_was_not_exported(imported):
    text = document(
        target="Rung", programs=[program("P", ladder("R", "XIC(a)JMP(Out);", "OTE(b);"), main="")]
    )
    report = imported(text).report
    assert (report.refused, report.ran) == ([], 2)
    assert report.declared[r"\P.R, label Out"] == "after the last rung"


@pytest.mark.slow
def test_faults_of_one_program_do_not_keep_the_others_from_running(imported):
    routines = ladder("Main", "MOV(5,i)JSR(Sub,0);"), ladder("Sub", "MOV(a[i],i);")
    wrong = program("Wrong", *routines, tags=[tag("a", "DINT", "2"), tag("i", "DINT")])
    right = program("Right", ladder("Main", "ADD(n,1,n);"), tags=[tag("n", "DINT")])
    endless = program("Endless", ladder("Main", "LBL(a)JMP(a);"))
    report = imported(document(programs=[wrong, right], tasks=[task("T", "Wrong", "Right")])).report
    assert (report.rungs, report.ran, list(report.faults)) == (3, 3, ["Wrong"])
    text = document(programs=[wrong, right, endless], tasks=[task("T", "Wrong", "Right", "Endless")])
    report = imported(text).report
    assert (report.rungs, report.ran, list(report.faults)) == (4, 3, ["Wrong", "Endless"])
    assert "watchdog" in report.faults["Endless"]


def test_program_without_readable_routines_keeps_its_main_routine(imported):
    hidden = '<EncodedData EncodedType="Routine" Name="Hidden" EncryptionConfig="7">QUJD</EncodedData>'
    text = document(
        programs=[program("Secret", hidden), program("Right", ladder("Main", "NOP();"))],
        tasks=[task("T", "Secret", "Right")],
    )
    found = imported(text)
    controller = found.parts.with_fault_routines().assemble(found.report)
    assert [(each.name, each.first, each.fault) for each in controller.programs] == [
        ("Secret", "Hidden", None),
        ("Right", "Main", "scanrack_clears"),
    ]


def test_characters_one_by_one_dates_and_bytes(imported):
    characters = """<Structure DataType="STRING"><DataValueMember Name="LEN" DataType="DINT" Value="2"/>
<ArrayMember Name="DATA" DataType="SINT" Dimensions="82" Radix="ASCII"><Element Index="[0]" Value="'a'"/>
<Element Index="[1]" Value="98"/></ArrayMember></Structure>"""
    bytes_only = '<Tag Name="B" TagType="Base" DataType="DINT"><Data>05 00 00 00</Data></Tag>'
    day = value("LINT", "DT#1970-01-02-00:00:00.000_001Z")
    found = imported(
        machine("NOP();", tags=[tag("S", "STRING", data=characters), tag("D", "LINT", data=day), bytes_only])
    )
    assert (found.controller.tags.S, found.controller.tags.D) == ("ab", 86_400_000_001)  # us since 1970
    assert (found.controller.tags.B, found.report.notes) == (5, [])


def test_a_module_is_passed_by_its_name(imported):
    asks = "GSV(Module,Unit,EntryStatus,State)AND(State,16#F000,State);"
    parts = [parameter("Unit", "MODULE", "InOut"), parameter("State", "INT", "Output")]
    drive = module("Drive1", 3)
    found = imported(
        machine(
            "Ask(a,Drive1,x);",
            tags=[tag("a", "Ask"), tag("x", "INT")],
            modules=[drive],
            add_ons=[add_on("Ask", parts, [], ladder("Logic", asks))],
        )
    )
    assert (found.report.refused, found.report.ran) == ([], 2)
    assert after(found).x == 0x4000  # the module runs


@pytest.mark.parametrize(
    ("asked", "size"),
    [
        ("Module,Drive1,Path", 64),
        ("TimeSynchronize,,ClockType", 2),
        ("TimeSynchronize,,GrandMasterClockInfo", 24),
        ("ControllerDevice,,DeviceName", 33),
        ("WallClockTime,,TimeZoneString", 84),
    ],
)
def test_attributes_that_are_memory(imported, asked, size):
    """GSV writes as many bytes as the attribute has, here zeros over ones."""
    fill = "FLL(1,Bytes[0],100)"
    found = imported(machine(f"{fill}GSV({asked},Bytes[0]);", tags=[tag("Bytes", "SINT", "100")]))
    assert (found.report.refused, found.report.ran) == ([], 1)
    tags = after(found)
    assert [tags[f"Bytes[{place}]"] for place in range(100)] == [0] * size + [1] * (100 - size)


def test_a_scan_mode_of_an_add_on_runs_unless_the_definition_switches_it_off(imported):
    """[1756-PM010 p. 53] `Then if it is defined and enabled`."""
    routines = [ladder(name, "NOP();") for name in ("Logic", "Prescan", "Postscan")]
    runs = 'ExecutePrescan="false" ExecutePostscan="true" ExecuteEnableInFalse="false"'
    read = imported(document(add_ons=[add_on("Block", [], [], *routines, runs=runs)]))
    definition = read.parts.add_ons["BLOCK"]
    assert [each.name for each in definition.routines] == ["Logic", "Postscan"]
    assert (read.report.rungs, read.report.refused) == (3, [])
    assert [each.text for each in read.report.notes] == [
        "its routine Prescan does not run: ExecutePrescan is false"
    ]


@pytest.mark.parametrize(("main", "count"), [('PreStateRoutineName="Prestate" ', 100), ("", 0)])
def test_an_equipment_phase_is_idle_and_runs_its_prestate_routine_alone(imported, main, count):
    routines = ladder("Running", "ADD(Ran,1,Ran);"), ladder("Prestate", "ADD(Before,1,Before);")
    phase = program("Fill", *routines, tags=[tag("Ran", "DINT"), tag("Before", "DINT")], main="")
    text = document(programs=[phase.replace("<Program ", f'<Program Type="EquipmentPhase" {main}', 1)])
    found = imported(text)
    engine = found.controller.compile()
    for _ in range(100):
        engine.step()
    assert (engine.tags[r"\Fill.Ran"], engine.tags[r"\Fill.Before"]) == (0, count)
    assert found.report.notes[0].text.startswith("it is an equipment phase, which stays idle")


def test_requests_of_a_phase_are_words_with_spaces(imported):
    found = imported(
        document(
            target="Routine",
            programs=[
                program("Main", ladder("Main", "PXRQ(Ask,Download Input Parameters,Values);"), main="")
            ],
        )
    )
    assert (found.report.refused, found.report.ran) == ([], 1)
