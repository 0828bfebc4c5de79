"""Forces in an export: listed, and held when a run is told to [1756-RM084, forced tag data]."""

from contextlib import ExitStack
from typing import Any

import pytest
from l5x_files import data_type, document, ladder, member, module, program, tag
from scanrack.commands import build
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.jobs.load.loading import forces_to_hold
from typer.testing import CliRunner

WORDS = data_type("Words", member("A", "INT"), member("B", "INT"))
PACKED = data_type(
    "Packed",
    member("Host", "SINT", hidden=True),
    member("On", "BIT", target="Host", bit=0),
    member("Off", "BIT", target="Host", bit=3),
    member("Level", "REAL", 2),
)


def forced(made, data, how=""):
    """A tag with force data."""
    return made.replace("</Tag>", f"<ForceData{how}>{data}</ForceData></Tag>")


def shown(made, value):
    """A tag with decorated data."""
    return made.replace("</Tag>", f'<Data Format="Decorated">{value}</Data></Tag>')


def image(*parts):
    """Bytes as hex, each part of one repeated byte: `(12, 0)`."""
    return " ".join(f"{value:02X}" for count, value in parts for _ in range(count))


@pytest.mark.parametrize(
    ("made", "forces"),
    [
        # the manual's: bit 0 of the first word on, the second word is 16#22B8
        (forced(tag("T", "Words"), "00 00 00 00 01 00 FF FF 01 00 B8 22"), {"T.A.0": True, "T.B": 8888}),
        (forced(tag("T", "INT"), "<![CDATA[[0,0,1,0,3,0]]]>", ' Format="L5K"'), {"T.0": True}),
        (forced(tag("T", "INT"), "00 00 00 00 03 00"), {}),  # no bit of the mask
        (forced(tag("T", "DINT"), f"{image((4, 0), (4, 255))} FE FF FF FF"), {"T": -2}),
        (
            forced(tag("T", "Packed"), f"{image((12, 0), (1, 9), (7, 0), (4, 255), (1, 8), (9, 0))} C0 3F"),
            {"T.On": False, "T.Off": True, "T.Level[1]": 1.5},
        ),
        (
            forced(tag("T", "DINT", "2,3"), image((24, 0), (20, 0), (4, 255), (20, 0), (1, 7), (3, 0))),
            {"T[1,2]": 7},
        ),
        (
            forced(tag("T", "BOOL", "32"), image((4, 0), (1, 0x81), (3, 0), (1, 0x80), (3, 0))),
            {"T[0]": False, "T[7]": True},
        ),
        (
            shown(
                tag("T", "DINT"),
                '<DataValue DataType="DINT" Value="0" '
                'ForceValue="2#...._...._..0._...._...._...._...._...1"/>',
            ),
            {"T.0": True, "T.21": False},
        ),
        (
            shown(
                tag("T", "Words"),
                '<Structure DataType="Words"><DataValueMember Name="A" DataType="INT" Value="0" '
                'ForceValue="2#1111_1111_1111_1110"/></Structure>',
            ),
            {"T.A": -2},
        ),
    ],
)
def test_forces_are_listed_by_their_addresses(imported, made, forces):
    text = document(types=[WORDS, PACKED], tags=[made], programs=[program("Main", ladder("Main", "NOP();"))])
    report = imported(text).report
    assert report.forces == forces
    assert [str(each) for each in report.notes] == []
    assert report.as_json()["forces"] == forces


def test_forces_of_eight_bytes_are_read_whatever_the_revision(imported):
    made = forced(tag("T", "LINT"), image((8, 0), (8, 255), (1, 7), (7, 0)))
    text = document(tags=[made], programs=[program("Main", ladder("Main", "NOP();"))], revision="20.01")
    assert imported(text).report.forces == {"T": 7}


@pytest.mark.parametrize(
    ("data", "says"),
    [
        ("01 02", "its force data have 2 bytes, which are not three times its memory"),
        ("nothing", "its force data 'nothing' are not bytes"),
    ],
)
def test_force_data_that_cannot_be_read_are_a_note(imported, data, says):
    text = document(
        tags=[forced(tag("T", "DINT"), data)], programs=[program("Main", ladder("Main", "NOP();"))]
    )
    (note,) = imported(text).report.notes
    assert note.text == f"its forces are not read: {says}"


FEED = """\
<InputTag><Data Format="Decorated"><Structure DataType="Feed:I:0">
<DataValueMember Name="Fault" DataType="DINT" Value="0"/>
<ArrayMember Name="Data" DataType="INT" Dimensions="8"><Element Index="[0]" Value="0" \
ForceValue="2#...._...._...._..1."/></ArrayMember></Structure></Data></InputTag>"""
PANEL = """\
<InputTag><ForceData>00 00 00 00 01 00 00 00 01 00 00 00</ForceData><Data Format="Decorated">\
<Structure DataType="Panel:I:0"><DataValueMember Name="Data" DataType="INT" Value="0"/></Structure></Data>\
</InputTag>"""


@pytest.fixture
def job(tmp_path):
    """A rack with a 3601 in slot 1; the export forces tags, a bit of its image and one of another module."""
    rungs = ("ADD(Count,1,Count);", "XIC(Local:1:I.Data[0].1)OTE(Own);", "XIC(Local:5:I.Data.0)OTE(Seen);")
    text = document(
        tags=[
            forced(tag("Count", "DINT"), image((4, 0), (4, 255), (1, 42), (3, 0))),
            *(tag(name, "BOOL") for name in ("Own", "Seen")),
            forced(tag("Level", "REAL"), image((4, 0), (1, 1), (3, 0), (1, 1), (3, 0))),
        ],
        modules=[module("Feed", 1, FEED, catalog="1769-MODULE"), module("Panel", 5, PANEL)],
        programs=[program("Main", ladder("Main", *rungs))],
    )
    (tmp_path / "machine.L5X").write_text(text, encoding="utf-8")
    rack = tmp_path / "rack.toml"
    rack.write_text(
        'program = "machine.L5X"\ncontroller = "compactlogix"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n',
        encoding="utf-8",
    )
    return load_job(str(rack))


def test_a_run_holds_them_if_it_is_told_to(job):
    """Tags through the debugger, images as the rack's forces; a bit of a REAL can't be forced."""
    said: list[str] = []
    held = RunOptions(forces=forces_to_hold(job, True), warn=said.append)
    for options, values in ((held, (42, True, True)), (RunOptions(), (3, False, False))):
        with ExitStack() as ports:
            run = JobRun(job, ports, options)
            run.run(3)
            logic: Any = run.program.logic
            tags = logic.tags
            assert (tags.Count, tags.Own, tags.Seen) == values
    assert said[:1] == ["a force is not applied: Level is REAL and has no bits"]
    assert job.notices[-1].endswith("machine.L5X: the export has 4 forces; --forces holds them")


def test_an_export_without_forces_has_none_to_hold(job, tmp_path):
    (tmp_path / "machine.L5X").write_text(
        document(programs=[program("Main", ladder("Main", "NOP();"))]), encoding="utf-8"
    )
    with pytest.raises(ValueError, match=r"machine\.L5X has no forces"):
        forces_to_hold(load_job(str(tmp_path / "rack.toml")), True)


@pytest.mark.slow
def test_the_commands_hold_them_and_a_rerun_repeats_them(job, tmp_path):
    trace = str(tmp_path / "held.mcap")
    line = ["run", str(tmp_path / "rack.toml"), "--forces", "--scans", "3", "--record", trace, "-q"]
    assert CliRunner().invoke(build(), line).exit_code == 0
    assert CliRunner().invoke(build(), ["replay", "--into", "session", trace]).exit_code == 0
    (tmp_path / "machine.L5X").write_text(
        document(programs=[program("Main", ladder("Main", "NOP();"))]), encoding="utf-8"
    )
    for command in ("run", "watch"):
        done = CliRunner().invoke(build(), [command, str(tmp_path / "rack.toml"), "--forces"])
        assert (done.exit_code, "has no forces" in done.output) == (2, True)
