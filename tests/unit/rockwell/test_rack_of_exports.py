"""The rack file for an export: its tree wins, no slot is used twice, and what was decided is said."""

import tomllib
from typing import Any

import pytest
from l5x_files import add_on, diagram, document, ladder, module, program, tag, task
from scanrack.commands import build
from scanrack.jobs import load_job
from scanrack.jobs.imports.export_slots import ExportSlot, differences, slot_tables
from scanrack.ladder import Controller
from scanrack.rockwell.l5x import import_l5x
from slc_files import export, slot
from slc_files import ladder as slc_ladder
from typer.testing import CliRunner


def run(*arguments):
    answer = CliRunner().invoke(build(), list(map(str, arguments)))
    return answer.exit_code, answer.output


def data(kind, words):
    elements = "".join(f'<Element Index="[{at}]" Value="0"/>' for at in range(words))
    array = f'<ArrayMember Name="Data" DataType="INT" Dimensions="{words}">{elements}</ArrayMember>'
    fault = '<DataValueMember Name="Fault" DataType="DINT" Value="0"/>' if kind == "Input" else ""
    structure = f'<Structure DataType="AB:1769_MODULE_{kind}_{words}">{fault}{array}</Structure>'
    return f'<{kind}Tag><Data Format="Decorated">{structure}</Data></{kind}Tag>'


def generic(name, number, words_in, words_out):
    """A 1769-MODULE; the sizes of its connection count the Fault."""
    made = module(name, number, data("Input", words_in), data("Output", words_out), catalog="1769-MODULE")
    sizes = f'InputSize="{words_in * 2 + 4}" OutputSize="{words_out * 2}"'
    return made.replace("<Connection ", f"<Connection {sizes} ")


def machine(tmp_path, *modules, rungs=("NOP();",), tags=()):
    path = tmp_path / "machine.L5X"
    text = document(
        modules=modules,
        tags=tags,
        programs=[program("Main", ladder("Main", *rungs))],
        tasks=[task("T", "Main")],
    )
    path.write_text(text, encoding="utf-8")
    return path


def slots(path, *options):
    status, output = run("l5x", path, "--print-rack", *options)
    assert status == 0, output
    return {each["number"]: each["module"] for each in tomllib.loads(output)["slot"]}, output


def test_a_module_that_is_not_simulated_keeps_its_slot(tmp_path):
    """Word 12 of 31 is the module's; the 3601 of the rack does not answer in its place."""
    rungs = ("MOV(Local:1:I.Data[0],Seen);", "MOV(-7,Local:1:O.Data[12]);", "MOV(Local:1:O.Data[12],Back);")
    path = machine(
        tmp_path, generic("Valves", 1, 31, 31), rungs=rungs, tags=[tag("Seen", "INT"), tag("Back", "INT")]
    )
    found, output = slots(path)
    assert found == {2: "amci3601"}
    assert "# slot 1: 1769-MODULE Valves: not simulated, its tags are memory: " in output
    assert "Local:1:I of 66 bytes, Local:1:O of 62 bytes" in output
    assert "# No module of the export is simulated. A rack needs one: this one is in a free slot." in output
    rack = tmp_path / "machine.toml"
    rack.write_text(output, encoding="utf-8")
    status, shown = run("run", rack, "--scans", 5, "--no-record")
    assert status == 0, shown
    assert "warning" not in shown


def test_a_module_without_data_has_the_words_of_its_connection(tmp_path):
    """66 bytes in are 31 words and the Fault."""
    bare = generic("Valves", 1, 31, 31)
    for kind in ("Input", "Output"):
        start, end = bare.index(f"<{kind}Tag>"), bare.index(f"</{kind}Tag>")
        bare = bare[:start] + f"<{kind}Tag><Data>00 00</Data>" + bare[end:]
    imported: Any = import_l5x(
        machine(tmp_path, bare, rungs=("MOV(Local:1:I.Data[30],Local:1:O.Data[30]);",))
    )
    assert imported.report.refused == []
    assert len(imported.controller.tags["Local:1:I.Data"]) == 31
    assert imported.controller.tags["Local:1:I.Fault"] == 0


def test_cards_stay_where_they_are(tmp_path):
    found, _ = slots(
        machine(tmp_path, module("DI", 1), module("Odd", 2, catalog="1769-IF8"), module("DI2", 4))
    )
    assert found == {1: "1769-IQ16", 4: "1769-IQ16"}


def test_the_first_free_slot_is_one_of_no_module(tmp_path):
    odd = [module(f"Odd{number}", number, catalog="1769-IF8") for number in (1, 2, 4)]
    assert slots(machine(tmp_path, *odd))[0] == {3: "amci3601"}


def test_the_words_of_a_3601_are_one_and_the_file_says_so(tmp_path):
    found, output = slots(machine(tmp_path, generic("Feed", 2, 8, 8), module("DI", 1)))
    assert found == {1: "1769-IQ16", 2: "amci3601"}
    assert "# slot 2: 1769-MODULE Feed: treated as a 3601, since it has a 3601's sizes" in output


@pytest.mark.parametrize("name", ["Valves", "VALVES", "1"])
def test_the_user_names_a_3601(tmp_path, name):
    found, output = slots(machine(tmp_path, generic("Valves", 1, 31, 31)), "--stepper", name)
    assert found == {1: "amci3601"}
    assert f"# slot 1: 1769-MODULE Valves: treated as a 3601, since --stepper {name} names it" in output


def test_a_stepper_that_is_not_there_is_refused(tmp_path):
    status, output = run(
        "l5x", machine(tmp_path, generic("Valves", 1, 31, 31)), "--print-rack", "--stepper", "Feed"
    )
    assert status == 2
    assert "--stepper Feed: the export has no such module; it has Valves in slot 1" in output


def test_two_modules_in_a_slot_are_one(tmp_path):
    found, output = slots(machine(tmp_path, module("DI", 1), module("DO", 1, catalog="1769-OB16")))
    assert found == {1: "1769-IQ16"}
    assert "# slot 1: 1769-OB16 DO: left out, because the slot already has a module" in output


def micro(tmp_path, *slots_of_it):
    path = tmp_path / "line.SLC"
    path.write_text(export(slc_ladder(2, "XIC I:1/0 OTE O:3/0"), slots=slots_of_it), encoding="utf-8")
    return path


def test_an_slc_keeps_its_cards(tmp_path):
    path = micro(
        tmp_path,
        slot(1, "1762-IQ16", "16-Input", 1),
        slot(2, "1762-IT4", "thermocouples", 6),
        slot(3, "1762-OB16", "16-Output", 0, 1),
    )
    found, output = slots(path)
    assert found == {1: "1762-IQ16", 3: "1762-OB16"}
    assert "# slot 2: 1762-IT4 thermocouples: not simulated, its tags are memory: I:2 of 6 words" in output
    (tmp_path / "line.toml").write_text(output, encoding="utf-8")
    status, shown = run("run", tmp_path / "line.toml", "--scans", 5, "--no-record")
    assert (status, "in the rack" in shown) == (0, False), shown


def test_a_rack_with_another_module_than_the_export_says_so(tmp_path):
    path = micro(tmp_path, slot(1, "1762-IQ16", "16-Input", 1))
    rack = tmp_path / "line.toml"
    rack.write_text(f'program = "{path.name}"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8")
    status, shown = run("run", rack, "--scans", 5, "--no-record")
    said = "slot 1: 1762-IQ16 16-Input in the export, but amci3601 in the rack: the slot has the tags of"
    assert (status, said in shown.replace("\n", " ")) == (0, True), shown


def test_what_a_generic_profile_is_the_rack_says():
    there = [ExportSlot(1, "1769-MODULE", "Valves"), ExportSlot(2, "1769-IQ16")]
    assert list(differences(there, [(1, "amci3601"), (2, "1769-IQ16"), (3, "amci3601")])) == []


def test_a_rack_without_modules_has_a_3601():
    assert "\n".join(slot_tables([])).strip().startswith("# No module of the export is simulated")


@pytest.mark.parametrize(
    ("stubs", "status", "says"),
    [
        ("", 2, 'let it do nothing: Blocks = "false" below [stubs]'),
        ('[stubs]\nrefused = "empty"\n', 0, "refused = empty: Main.Blocks"),
        ('[stubs]\nBlocks = "false"\n', 0, "Blocks = the routine does nothing"),
    ],
)
def test_a_controller_with_a_block_diagram_runs_if_its_user_accepts_that_it_does_nothing(
    tmp_path, stubs, status, says
):
    """A JSR to it, with or without parameters, goes on behind it: N counts, Back stays."""
    rungs = ladder("Main", "ADD(N,1,N);", "JSR(Blocks,1,N,Back);", "JSR(Blocks);")
    tags = [tag("N", "DINT"), tag("Back", "DINT")]
    text = document(tags=tags, programs=[program("Main", rungs, diagram("Blocks", "FBD"))])
    (tmp_path / "machine.L5X").write_text(text, encoding="utf-8")
    rack = tmp_path / "rack.toml"
    rack.write_text(
        f'program = "machine.L5X"\n{stubs}[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8"
    )
    found, output = run("run", rack, "--scans", 3, "--no-record")
    assert (found, says in output) == (status, True), output
    if status == 0:
        logic = load_job(str(rack)).logic
        assert isinstance(logic, Controller)
        logic.step()
        logic.step()
        assert (logic.tags.N, logic.tags.Back) == (2, 0)


@pytest.mark.parametrize(
    ("stubs", "status", "says"),
    [
        ("", 2, 'let it do nothing: Blocks = "false" below [stubs]'),
        ('[stubs]\nBlocks = "true"\n', 0, "BLOCKS = true (once)"),
    ],
)
def test_an_add_on_of_blocks_is_stubbed_by_its_own_name(tmp_path, stubs, status, says):
    blocks = add_on("Blocks", [], [], diagram("Logic", "FBD"))
    main = ladder("Main", "Blocks(B)ADD(N,1,N);")
    text = document(
        add_ons=[blocks], tags=[tag("B", "Blocks"), tag("N", "DINT")], programs=[program("Main", main)]
    )
    (tmp_path / "machine.L5X").write_text(text, encoding="utf-8")
    rack = tmp_path / "rack.toml"
    rack.write_text(
        f'program = "machine.L5X"\n{stubs}[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8"
    )
    found, output = run("run", rack, "--scans", 3, "--no-record")
    assert (found, says in output) == (status, True), output
