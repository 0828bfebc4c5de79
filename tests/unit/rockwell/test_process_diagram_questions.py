"""A diagram of process blocks that is explained, cross-referenced, checked and proved."""

import json

import pytest
from l5x_files import block, document, ladder, program, reference, sheets, tag, task, wire
from scanrack.commands import build
from scanrack.ladder.debug import Debugger
from scanrack.rockwell.l5x import import_l5x
from typer.testing import CliRunner

KINDS = {
    "REAL": "Raw",
    "BOOL": "High Ack Horn",
    "SCALE": "Scale",
    "ALARM": "Watch",
    "HL_LIMIT": "Bound",
    "DOMINANT_RESET": "Latch",
}
HORN = reference("ORef", 9, "Horn", x=400)
LEVEL = (
    reference("IRef", 0, "Raw")
    + reference("IRef", 1, "Ack")
    + reference("IRef", 2, "80")
    + block("SCL", 3, "Scale", x=100)
    + block("ALM", 4, "Watch", x=200)
    + block("RESD", 5, "Latch", x=300)
    + wire(0, "3.In")
    + wire("3.Out", "4.In")
    + wire(2, "4.HLimit")
    + wire("4.HAlarm", "5.Set")
    + wire(1, "5.Reset")
    + wire("5.Out", 9)
    + HORN
)


def machine(content="", *rungs):
    tags = [tag(name, kind) for kind, names in KINDS.items() for name in names.split()]
    routines = [ladder("Main", *rungs, *(["JSR(Blocks,0);"] if content else []))]
    routines += [sheets("Blocks", content)] if content else []
    return document(tags=tags, programs=[program("P", *routines)], tasks=[task("T", "P")])


@pytest.fixture
def written(tmp_path):
    """Writes documents as files."""

    def write(*texts):
        paths = [tmp_path / f"{number}.L5X" for number in range(len(texts))]
        for path, text in zip(paths, texts, strict=True):
            path.write_text(text, encoding="utf-8")
        return paths

    return write


def said(*words):
    answer = CliRunner().invoke(build(), [*map(str, words)])
    return answer.exit_code, answer.output


def rack_of(path):
    rack = path.with_suffix(".toml")
    rack.write_text(said("l5x", path, "--print-rack")[1], encoding="utf-8")
    return rack


def test_why_leads_through_the_blocks_to_the_reference(written):
    (path,) = written(machine(LEVEL))
    controller = import_l5x(path).controller
    assert controller is not None
    debugger = Debugger(controller)
    debugger.tags["Scale.InRawMax"] = debugger.tags["Scale.InEUMax"] = 100.0
    debugger.scan(2)
    debugger.tags["Raw"] = 90.0
    debugger.scan(1)
    chain = debugger.chain("Horn")
    assert chain is not None
    assert [each.name for each in chain.walk()] == [
        *("Horn", "Latch.Out", "Latch.Set", "Watch.HAlarm", "Watch.In", "Scale.Out", "Scale.In", "Raw"),
    ]
    assert "ALM(Watch)" in debugger.why("Watch.HAlarm")
    debugger.tags["Ack"] = True
    debugger.scan(1)
    chain = debugger.chain("Horn")
    assert chain is not None
    assert [each.name for each in chain.walk()][:3] == ["Horn", "Latch.Out", "Latch.Reset"]


def test_xref_lists_a_block_and_its_wires(written):
    (path,) = written(machine(LEVEL))
    mentions = json.loads(said("xref", rack_of(path), "Watch", "--json")[1])["mentions"]
    assert [each["text"] for each in mentions] == [
        *("Watch.In := Scale.Out;", "Watch.HLimit := 80;", "ALM(Watch)", "Latch.Set := Watch.HAlarm;"),
    ]


def test_check_finds_a_block_called_twice_and_a_reference_written_twice(written):
    twice = (
        LEVEL + block("ALM", 6, "Watch", x=500) + reference("ORef", 7, "Horn", x=600) + wire("6.LAlarm", 7)
    )
    (path,) = written(machine(twice))
    status, text = said("check", rack_of(path))
    assert (status, "block-twice: Watch" in text, "repeated-coil: Horn" in text) == (1, True, True)
    (path,) = written(machine(LEVEL, "XIC(High)OTE(Ack);", "XIC(Bound.HighAlarm)OTE(High);"))
    assert "block-twice" not in said("check", rack_of(path))[1]


def bounded(limit):
    """The horn is latched at a limit of Raw."""
    return (
        reference("IRef", 0, "Raw")
        + reference("IRef", 1, "Ack")
        + reference("IRef", 2, limit)
        + block("HLL", 3, "Bound", x=100)
        + block("RESD", 5, "Latch", x=300)
        + wire(0, "3.In")
        + wire(2, "3.HighLimit")
        + wire("3.HighAlarm", "5.Set")
        + wire(1, "5.Reset")
        + wire("5.Out", 9)
        + HORN
    )


SOURCE = ("XIC(High)MOV(80.5,Raw);", "XIO(High)CLR(Raw);")
RUNGS = (*SOURCE, "GEQ(Raw,80)OTL(Horn);", "XIC(Ack)OTU(Horn);")


@pytest.mark.parametrize(("limit", "status"), [("80", 0), ("81", 1)])
def test_a_limit_and_a_latch_are_proved_equal_to_rungs(written, tmp_path, limit, status):
    paths = written(machine(bounded(limit), *SOURCE), machine("", *RUNGS))
    found, text = said("prove", *paths, "-q", "--outputs", "Horn", "--out", tmp_path / "proofs")
    assert (found, "Horn" in text) == (status, bool(status))


@pytest.mark.parametrize(("limit", "status"), [("80", 0), ("81", 1)])
def test_a_block_that_proofs_leave_open_is_equal_only_with_equal_inputs(written, tmp_path, limit, status):
    """ALM keeps nothing of the limit that it was called with."""
    paths = written(machine(LEVEL, *SOURCE), machine(LEVEL.replace('"80"', f'"{limit}"'), *SOURCE))
    found, text = said("prove", *paths, "-q", "--out", tmp_path / "proofs")
    assert (found, "Horn" in text) == (status, bool(status))
