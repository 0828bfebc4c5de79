"""Features that need the place of a fault or refusal: they read it from fields, whatever the words are.

`tests/tools/reworded.py` runs these tests while every sentence has other words.
Broken on purpose: a rung, column, line or key read from a sentence; with other words a test turns red.
"""

from pathlib import Path

import pytest
from l5x_files import machine, tag
from scanrack import open_bench
from scanrack.io_images.amci3601 import RULES
from scanrack.jobs import load_job
from scanrack.jobs.check import check_rack
from scanrack.jobs.imports.l5x_rack import rack_of
from scanrack.rockwell.l5x.importer import Importer
from scanrack.rockwell.l5x.xml.document import parse_document
from scanrack.rockwell.slc import import_text
from scanrack.runtime import RackFileError, load_rack_file
from scanrack.runtime.loop.events import Event
from scanrack.runtime.loop.faults import CpuFault
from scanrack.runtime.modules.amci3601.latches import Latches
from scanrack.traces import open_trace
from scanrack.traces.repair import repair
from scanrack.watch.history.catalog import Catalog
from scanrack.watch.history.event_log import EventLog
from scanrack.watch.preview import mistake_of

RACK = """\
program = "{program}"
scan_ms = 2
[[slot]]
number = 1
module = "amci3601"
firmware = "4.1"
"""
RUNGS = """\
PROGRAM line
TAG Go : BOOL
TAG Index : DINT
TAG Table : DINT[3]
ROUTINE Main
XIC(Go)OTE(Local:1:O.Data[0].0);
XIC(Go)MOV(1,Table[Index]);
XIC(Go)OTE(Local:1:O.Data[0].0);
END
"""


@pytest.fixture
def rack(tmp_path):
    def write(text, name="line.rung", more=""):
        (tmp_path / name).write_text(text, encoding="utf-8")
        (tmp_path / "line.toml").write_text(RACK.format(program=name) + more, encoding="utf-8")
        return tmp_path / "line.toml"

    return write


def l5x(*rungs, **parts):
    return Importer(parse_document(machine(*rungs, **parts).encode(), "machine.L5X")).run(trial=True)


def test_page_finds_the_rung_of_a_fault(rack, tmp_path):
    bench = open_bench(rack(RUNGS), tmp_path / "t.mcap")
    bench.scan()
    bench["Index"], bench["Go"] = 7, True
    with pytest.raises(CpuFault):
        bench.scan()
    log = EventLog()
    with open_trace(tmp_path / "t.mcap") as trace:
        log.take_all(trace.events())
    (fault,) = log.faults_at(None)
    assert Catalog(bench.logic.program).place_of_fault(fault) == "Main.1"


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("line.rung", RUNGS.replace("MOV(1,", "MOV(Missing,"), 7),
        ("line.rung", RUNGS.replace("XIC(Go)MOV", "XIC(Go MOV"), 7),
        ("line.rung", RUNGS.replace("TAG Index : DINT", "TAG Index : DINT := 3.5"), None),
        ("line.rung", "PROGRAM line\nSTUB MSG : at once or never\nROUTINE Main\nNOP();\nEND\n", 2),
        ("line.steps", "HOLD_MOVE\nNONSENSE\n", 2),
        ("line.py", "def logic(scan):\n    pass\n\n1 / 0\n", 4),
        ("line.py", "def logic(scan):\n    pass pass\n", 2),
    ],
    ids=["operand", "rung", "initial", "stub", "steps", "raises", "syntax"],
)
def test_page_finds_the_line_of_a_mistake_in_an_edit(rack, tmp_path, name, text, line):
    with pytest.raises(ValueError) as refused:  # noqa: PT011 - the words are not the point
        load_job(str(rack(text, name)))
    mistake = mistake_of(refused.value, tmp_path / name)
    assert (mistake["file"], mistake["line"]) == (name, line)


def test_l5x_finds_rung_and_column():
    rungs = ["OTE(Lamp);", "XIC(Lamp)MOV(1,Missing);", "XIC(Lamp)FOO(Lamp);"]
    found = l5x(*rungs, tags=[tag("Lamp", "BOOL")])
    refused = sorted((each.rung, each.column) for each in found.report.refused)
    assert refused == [(1, 10), (2, 10)]
    assert found.report.imported == 1
    assert "missing_tags" in rack_of(found, Path("machine.L5X"))


def test_l5x_drops_the_initial_value_that_does_not_fit():
    from scanrack.ladder.model.tags import Tag
    from scanrack.ladder.model.types import INT

    importer = Importer(parse_document(machine("NOP();").encode(), "machine.L5X"))
    importer._parts.declarations.append(Tag("Speed", INT, (), 99_999))
    found = importer.run(trial=False)
    assert found.report.lost == ["Speed"]
    assert found.report.imported == 1


def test_slc_finds_the_rung():
    rungs = "\n".join(
        f"% Rung: {number} %\nSOR {each} EOR" for number, each in enumerate(["NOP", "JSR U:9", "NOP"])
    )
    report = import_text(f"LADDER 2\n{rungs}\n", "machine").report
    assert [each.rung for each in report.refused] == [1]
    assert report.imported == 2


@pytest.mark.parametrize(
    ("more", "key"),
    [
        ("options.input_scan_us = 49\n", "slot.options.input_scan_us = 49"),
        ("address = 3\n", "slot.address = 3"),
        ('[[incident]]\nat_ms = 1\nwhat = "torn-update"\nlate_words = [8]\n', "incident.late_words"),
        ('[[force]]\naddress = "O:1.9"\nvalue = 1\n', 'force.address = "O:1.9"'),
    ],
    ids=["option", "address", "incident", "force"],
)
def test_rack_file_finds_key_and_line(rack, tmp_path, more, key):
    path = rack(RUNGS, more=more)
    with pytest.raises(RackFileError) as refused:
        load_rack_file(path)
    number = next(
        n
        for n, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if key.split(".")[-1] in line
    )
    assert str(refused.value).startswith(f"{path}:{number}: {key}: ")


def test_check_finds_the_line_of_two_coils(rack):
    found = [
        each
        for each in check_rack(load_job(str(rack(RUNGS)))).findings
        if each.place.file.endswith("line.rung")
    ]
    assert 8 in [each.place.line for each in found]


def test_check_finds_the_line_of_a_declaration(rack):
    text = """\
from scanrack.ladder.python.sequences import Input, Logic

class Line(Logic):
    def every_scan(self):
        pass
    start = Input("Local:9:I.Data.0")

logic = Line()
"""
    found = [each.place for each in check_rack(load_job(str(rack(text, "line.py")))).findings]
    assert 6 in [each.line for each in found if each.file.endswith("line.py")]


def test_why_finds_the_rung_of_an_output(rack):
    bench = open_bench(rack(RUNGS))
    bench.scan()
    bench["Go"] = True
    bench.scan()
    assert "Main rung 0: XIC(Go)" in bench.why("O:1.0/0")


def test_repair_counts_the_damaged_chunks(rack, tmp_path):
    path = tmp_path / "t.mcap"
    with open_bench(rack(RUNGS), path) as bench:
        bench.scan(50)
    with open_trace(path) as trace:
        chunk = trace.sections[0].span
    data = bytearray(path.read_bytes())
    data[chunk.end - 5] ^= 0xFF
    path.write_bytes(data)
    assert repair(path).damaged == 1


def test_recordings_keep_the_words_of_a_rule():
    events: list[Event] = []
    Latches(events).fire(0, "CMD-03")
    assert {each.name: each.text for each in events}["CMD-03"] == RULES["CMD-03"].event
