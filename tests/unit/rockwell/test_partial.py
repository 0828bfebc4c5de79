"""Partial exports: what their context leaves out is declared from its use."""

from types import SimpleNamespace
from typing import Any

import pytest
from l5x_files import add_on, after, document, ladder, parameter, program, structured, tag
from scanrack.rockwell.l5x.routines import instruction_names


def test_a_controller_that_is_context_is_a_partial_export(imported):
    text = document(programs=[program("Main", ladder("Main", "XIC(Missing)OTE(Too);"))])
    found = imported(text.replace('<Controller Use="Target"', '<Controller Use="Context"'))
    assert (found.report.refused, found.report.ran) == ([], 1)
    assert found.report.declared == {"Missing": "BOOL", "Too": "BOOL"}


def test_structured_text_without_lines(imported):
    text = document(
        target="Routine", programs=[program("Main", structured("Main", "Missing := 3;\nToo := 4;"), main="")]
    )
    start, end = text.index("<Line"), text.rindex("</Line>") + len("</Line>")
    found = imported(text[:start] + "<![CDATA[\nMissing := 3;\nToo := 4;]]>" + text[end:])
    assert found.report.objects == []
    said = after(found)
    assert (said.Missing, said.Too) == (3, 4)


def test_a_later_use_says_what_an_earlier_one_is(imported):
    rungs = "EQU(Unit.Name,Unit.Other)OTE(Same);", "COP(Unit.Name,Spare,1);", "CONCAT(Unit.Name,'a',Spare);"
    found = imported(document(target="Routine", programs=[program("Main", ladder("Main", *rungs), main="")]))
    assert ([str(each) for each in found.report.refused], found.report.ran) == ([], 3)
    assert (found.report.declared["Spare"], found.report.declared["Same"]) == ("STRING", "BOOL")


def test_four_characters_are_a_text_unless_another_use_says_number(imported):
    """`MOV('A',Code)` moves 65 into a DINT; five characters have no number."""
    rungs = "MOV('A',Code)MOV(Code,Next);", "ADD(Code,1,Code);", "MOV('ON',State)EQU(State,Old)OTE(Same);"
    more = "MOV('START',Order)EQU(Order,Last)OTE(Equal);"
    routine = ladder("Main", *rungs, more)
    found = imported(document(target="Routine", programs=[program("Main", routine, main="")]))
    assert ([str(each) for each in found.report.refused], found.report.ran) == ([], 4)
    assert found.report.declared == {
        **dict.fromkeys(("Code", "Next"), "DINT"),
        **dict.fromkeys(("State", "Old", "Order", "Last"), "STRING"),
        **dict.fromkeys(("Same", "Equal"), "BOOL"),
    }


def test_what_is_handed_over_is_what_the_inout_is(imported):
    """Types of modules are not in the file; an add-on's parameters name them."""
    parameters = (
        parameter("Module", "AB:Guard:I:0", "InOut"),
        parameter("Channel", "CHANNEL:I:0", "InOut"),
        parameter("Count", "DINT", "Input"),
        parameter("Good", "BOOL", "Output", required=False),
    )
    logic = ladder("Logic", "XIC(Module.RunMode)EQU(Channel.Devices,Count)XIC(Channel.Status)OTE(Good);")
    rungs = (
        "Guard(Guarding,Door:I,Door:I.Ch[1],3);",
        "XIC(Guarding.Good)XIC(Door:I.Ch[0].Status)XIO(Door:I.Faulted)OTE(Lamp);",
    )
    text = document(
        target="Routine",
        add_ons=[add_on("Guard", parameters, [], logic)],
        tags=[tag("Guarding", "Guard")],
        programs=[program("Main", ladder("Main", *rungs), main="")],
    )
    found = imported(text)
    assert ([str(each) for each in found.report.refused], found.report.ran) == ([], 3)
    assert found.report.declared == {
        "type AB:Guard:I:0": "Ch, Faulted, RunMode",
        "type CHANNEL:I:0": "Devices, Status",
        "Door:I": "AB:Guard:I:0",
        "Lamp": "BOOL",
    }


def test_what_is_only_referred_to_is_declared_from_its_use(imported):
    rungs = (
        "EVENT(Fast);",
        r"XIC(\Station.Inputs.Clear)OTE(Shared.Done);",
        "XIC(Part.Good)MOV(2,Part.Counts[3]);",
        "Mixer(Mix,Total,1)XIC(Mix.Full)OTE(Over);",
        "JSR(Elsewhere,0);",
    )
    other = (
        '<Program Use="Context" Name="Station"><Tags Use="Context">'
        '<Tag Use="Reference" Name="Inputs"></Tag></Tags></Program>'
    )
    elsewhere = '<Routine Use="Reference" Name="Elsewhere"></Routine>'
    text = document(
        target="Program",
        types=['<DataType Use="Reference" Name="Piece"></DataType>'],
        add_ons=['<AddOnInstructionDefinition Use="Reference" Name="Mixer"></AddOnInstructionDefinition>'],
        tags=['<Tag Use="Reference" Name="Shared"></Tag>', tag("Part", "Piece"), tag("Mix", "Mixer")],
        programs=[program("Main", ladder("Main", *rungs), elsewhere), other],
        tasks=['<Task Use="Reference" Name="Fast"></Task>'],
    )
    found = imported(text)
    assert ([(each.rung, each.column) for each in found.report.refused], found.report.ran) == ([(3, 1)], 4)
    assert found.report.declared == {
        "add-on Mixer": "instruction that does nothing",
        "type Piece": "Good, Counts",
        "type Mixer": "Full",
        r"\Station.Inputs": "Inputs_type",
        "Shared": "Shared_type",
        "Total": "DINT",
        "Over": "BOOL",
        r"\Main.Elsewhere": "routine that does nothing",
        "task Fast": "event task that runs nothing",
    }


def test_a_program_in_context_calls_an_add_on_in_context_by_either_name_and_all_rungs_count(imported):
    """Two rungs of the add-on and one of the program; `AddOnInstruction` was read past in silence."""
    mixer = add_on(
        "Mixer",
        [
            parameter("Go", "BOOL", "Input", required=True),
            parameter("Lamp", "BOOL", "Output", required=False),
        ],
        [],
        ladder("Logic", "XIC(Go)OTE(Lamp);", "XIC(Go)OTE(EnableOut);"),
    )
    for name in ("AddOnInstructionDefinition", "AddOnInstruction"):
        text = document(
            target="Routine",
            tags=[tag("Start", "BOOL"), tag("Mix", "Mixer")],
            add_ons=[
                mixer.replace("AddOnInstructionDefinition", name).replace(name, f'{name} Use="Context"', 1)
            ],
            programs=[
                program("Main", ladder("Main", "Mixer(Mix,Start);"), main="").replace(
                    "<Program ", '<Program Use="Context" '
                )
            ],
        )
        found = imported(text)
        assert (found.report.imported, found.report.ran, found.report.refused) == (3, 3, [])
        assert found.report.declared == {}


def test_structured_text_calls_add_ons_that_were_not_exported(imported):
    text = """// Comment(Not, A, Call);
    Mixer(Mix, Total, 1); (* Nor(This); *)
    #region Nor(this)
    IF (Total > 3) THEN Blender (Blend, 'Text(In, Quotes)'); END_IF;
    CASE Total OF 1: Feeder(Feed); ELSE Over := ABS(Total); END_CASE;
    #endregion
    Done := Mix.Full;
    """
    found = imported(
        document(target="Routine", programs=[program("Main", structured("Main", text), main="")])
    )
    assert [each.reason.partition(":")[0] for each in found.report.objects] == ["line 2", "line 4", "line 5"]
    assert found.report.structured()["statements"] == {"total": 7, "imported": 4, "refused": 3, "ran": 4}
    assert [each for each in found.report.declared if each.startswith("add-on")] == [
        "add-on Mixer",
        "add-on Blender",
        "add-on Feeder",
    ]


def test_words_of_statements_are_no_instructions(imported):
    text = "IF (A) THEN\n    B := 1;\nELSIF (C) THEN\n    B := 2;\nEND_IF;"
    found = imported(
        document(target="Routine", programs=[program("Main", structured("Main", text), main="")])
    )
    assert (found.report.declared, found.report.objects) == ({"A": "BOOL", "C": "BOOL", "B": "DINT"}, [])


@pytest.mark.parametrize("text", ["'$", "(*", "aa", "''"])
def test_names_of_calls_are_found_in_few_steps(text):
    text *= 2_000  # of a quadratic search a second
    routine: Any = SimpleNamespace(rungs=[SimpleNamespace(text=text)], lines=[(text, 1)])
    assert instruction_names([routine]) == []  # quadratic, it takes hours


def test_a_routine_that_takes_structures_is_called_with_its_own(imported):
    """What its SBR takes is not in the export; one that is not first is refused, and no other rung is."""
    rungs = "SBR(Hart,Channels[0],Local:3:I);", "XIC(Hart.Ok)XIC(Local:3:I.Ch0Fault)OTE(L);", "SBR(Late);"
    found = imported(document(target="Routine", programs=[program("Main", ladder("Take", *rungs), main="")]))
    assert [each.reason for each in found.report.refused] == ["SBR is not first"]
    assert found.report.ran == 2
    assert found.report.declared["Hart"] == "Hart_type"


@pytest.mark.parametrize("kind", ["RLL", "ST", "FBD", "SFC"])
def test_a_routine_in_context_without_its_content_is_only_named(imported, kind):
    """A diagram counted as refused, and an empty routine said nothing."""
    main = ladder("Main", "JSR(Sub,0);", "XIC(Missing)OTE(Too);")
    named = f'<Routine Use="Context" Name="Sub" Type="{kind}"><Description>It mixes.</Description></Routine>'
    context = program("Station", main, named, main="").replace("<Program ", '<Program Use="Context" ')
    found = imported(document(target="Routine", programs=[context]))
    assert (found.report.objects, found.report.refused, found.report.ran) == ([], [], 2)
    assert found.report.declared[r"\Station.Sub"] == "routine that does nothing"
