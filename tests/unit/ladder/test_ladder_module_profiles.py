"""The tags of a 3601 under the names of both profiles [3601 manual, chapters 3 and 4; reading A-90]."""

import pytest
from ladder_bench import both, program_of
from scanrack.io_images.addresses import Address, parse_address
from scanrack.io_images.amci3601 import WORDS_3601
from scanrack.io_images.amci3601.bits import StatusMsw
from scanrack.ladder import BuildError
from scanrack.ladder.debug import Debugger
from scanrack.runtime import Amci3601, Card, Cpu, ModuleFault, Rack

MS = 1_000_000
TAGS = """TAG Ok : BOOL
TAG Bad : BOOL
TAG Mode : BOOL
TAG Word : INT
TAG Fault : DINT
TAG Whole : INT[10]
TAG Only : DINT
SLOT card : 1"""


def played(engine, scans, module=None):
    """Return the rack after some scans of 2 ms with an engine as logic."""
    rack = Rack([Card(1, module or Amci3601("4.1"), "amci3601", "4.1")])
    cpu = Cpu(rack, engine.engine, 2 * MS)
    cpu.run(scans)
    return rack, cpu


BITS = (
    "XIC(Local:1:I.ModuleOK)OTE(Ok);",
    "XIC(card.I.ConfigError)OTE(Bad);",
    "XIC(Local:1:I.ConfigMode)OTE(Mode);",
)


def test_the_bits_of_the_v20_profile_are_those_of_word_0():
    """An unconfigured module is well, in command mode, and has a configuration error [note 1, chapter 3]."""
    assert (StatusMsw.CONFIG_ERROR, StatusMsw.MODULE_OK) == (1 << 13, 1 << 14)
    for engine in both(TAGS, *BITS, "MOV(Local:1:I.Data0,Word);"):
        rack, _ = played(engine, 4)
        assert (engine.tags.Ok, engine.tags.Bad, engine.tags.Mode) == (True, True, False), engine
        assert engine.tags.Word == rack.slots[1].inputs[0]
        assert engine.tags["Local:1:I.ModuleOK"] is True


def test_words_by_number_are_written_and_read():
    for engine in both(TAGS, "MOV(5,Local:1:O.Data3)OTL(card.O.Data1.2)MOV(Local:1:I.Data7,Word);"):
        rack, _ = played(engine, 2)
        assert list(rack.slots[1].outputs) == [0, 4, 0, 5, 0, 0, 0, 0], engine


@pytest.mark.parametrize("output", ["Local:1:O", "card.O", "Local:1:O.Data[0]", "Local:1:O.Data0"])
def test_all_outputs_at_once(output):
    words = "TAG W : INT[8] := [0, 0, 3, 4, 5, 6, 7, 8]"
    length = 8 if "Data" in output else 1
    for engine in both(f"{TAGS}\n{words}", f"COP(W[0],{output},{length});"):
        rack, _ = played(engine, 1)
        assert list(rack.slots[1].outputs) == [0, 0, 3, 4, 5, 6, 7, 8], engine


def test_all_inputs_at_once_are_the_fault_and_eight_words():
    """20 bytes: a DINT, then eight INT; the length counts elements of the destination."""
    for engine in both(TAGS, "COP(Local:1:I,Whole,10)COP(Local:1:I,Only,1);"):
        rack, _ = played(engine, 4)
        assert engine.tags.Whole == [0, 0, *rack.slots[1].inputs], engine
        assert engine.tags.Only == 0
        assert engine.tags["Local:1:I"] == {"Fault": 0, "Data": list(rack.slots[1].inputs)}


@pytest.mark.parametrize(
    ("trouble", "fault"),
    [
        (ModuleFault.LINK_LOST, -1),
        (ModuleFault.REMOVED, -1),
        (ModuleFault.ASIC_LOST, -1),
        (ModuleFault.FATAL_ERROR, 0),  # it answers, and MODULE_OK is off
    ],
)
def test_the_fault_of_the_connection(trouble, fault):
    rungs = ("MOV(Local:1:I.Fault,Fault);", "COP(Local:1:I,Only,1);")
    for engine in both(TAGS, *rungs):
        module = Amci3601("4.1")
        _, cpu = played(engine, 2, module)
        assert engine.tags.Fault == 0
        module.inject(trouble)
        cpu.run(1)
        assert (engine.tags.Fault, engine.tags.Only) == (fault, fault), engine
        if trouble is not ModuleFault.FATAL_ERROR:
            module.inject(None)
            cpu.run(1)
            assert engine.tags.Fault == 0


def test_the_debugger_runs_a_scan_with_its_fault_again():
    debugger = Debugger(program_of(TAGS, "MOV(Local:1:I.Fault,Fault);", "NEQ(Local:1:I.Fault,0)OTE(Bad);"))
    module = Amci3601("4.1")
    rack = Rack([Card(1, module, "amci3601", "4.1")])
    cpu = Cpu(rack, debugger, 2 * MS)
    cpu.run(3)
    module.inject(ModuleFault.LINK_LOST)
    cpu.run(5)
    change = debugger.last_change("Bad")
    assert change is not None
    assert change.scan == 3
    assert debugger.truth("Main")[1] == (True, True)
    assert debugger.why("Local:1:I.Fault") == (
        "Local:1:I.Fault is -1 because the module reports it: it is an input image."
    )


@pytest.mark.parametrize(
    ("rung", "message"),
    [
        ("MOV(Local:1:I.Data8,Word);", "Data0 to Data7, ModuleOK, ConfigError, ConfigMode and Fault"),
        ("XIC(Local:1:O.ModuleOK)OTE(Ok);", "its parts are Data[0] to Data[7], Data0 to Data7, and bits"),
        ("XIC(Local:1:I.ModuleOK.1)OTE(Ok);", "is not part of a module"),
        ("XIC(Local:1:I)OTE(Ok);", "a bit is needed"),
    ],
)
def test_what_a_module_does_not_have(rung, message):
    with pytest.raises(BuildError) as refused:
        program_of(TAGS, rung).build()
    assert message in str(refused.value)


def test_an_image_that_the_program_does_not_use_is_refused_every_time():
    (engine, _) = both(TAGS, "NOP();")
    for tag in ("Local:2:I.Data[0]", "Local:2:I.Fault", "Local:1:I"):
        for _ in range(2):
            with pytest.raises(ValueError, match="the program does not use this image"):
                engine.tags[tag]


SLOTS = {1: WORDS_3601}


def test_forces_take_the_names_of_the_profile():
    assert parse_address("Local:1:I.ModuleOK", SLOTS) == Address(1, "I", 0, 14)
    assert parse_address("local:1:i.configmode", SLOTS) == Address(1, "I", 0, 15)
    assert parse_address("Local:1:I.Data3.2", SLOTS) == Address(1, "I", 3, 2)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Local:1:I.Fault", "is not a word of an image"),
        ("Local:1:I.ModulOK", "did you mean ModuleOK"),
        ("Local:2:I.ModuleOK", "slot 2 is empty"),
    ],
)
def test_forces_that_are_refused(text, message):
    with pytest.raises(ValueError, match=message):
        parse_address(text, SLOTS)
