"""A discrete card in a rack: wired, addressed, recorded, told, queried, compared, driven, on the bench.

The operator panel: start (normally open) on input 0, stop (normally closed) on input 1, a lamp on output 0.
Start is pressed from 10 to 30 ms, stop from 60 to 80 ms; the lamp is on from the one to the other.
"""

from __future__ import annotations

import io
import json
import shlex
from pathlib import Path
from typing import Any

import pytest
from scanrack import open_bench
from scanrack.commands import build
from scanrack.commands.wire.drive import respond_to_lines
from scanrack.io_images.image import Image
from scanrack.jobs.drive.targets import BENCHES
from scanrack.runtime import RackFileError, parse_rack_file
from scanrack.runtime.modules.cards.card_options import CardOptions
from scanrack.runtime.modules.cards.module import GenericCard
from scanrack.traces import open_trace
from typer.testing import CliRunner

MS = 1_000_000
OPTIONS = """
inputs = { start = 0, stop = 1 }
outputs = { lamp = 0 }
normally_closed = ["stop"]
timeline = [
    { at_ms = 10, input = "start", for_ms = 20 },
    { at_ms = 60, input = "stop", for_ms = 20 },
]
"""
RACK = f"""
program = "panel.py"
scan_ms = 2
run_for_s = 0.1

[[slot]]
number = 1
module = "amci3601"

[[slot]]
number = 2
module = "discrete16"
[slot.options]
{OPTIONS}
"""
PROGRAM = """
def logic(scan):
    panel = scan.slot[2]
    start, stop = panel.inputs.bit(0, 0), panel.inputs.bit(0, 1)
    panel.outputs.set_bit(0, 0, stop and (start or panel.outputs.bit(0, 0)))
"""
RUNGS = """PROGRAM panel
ROUTINE Main
[XIC(Local:2:I.Data.0),XIC(O:2.0/0)]XIC(I:2.0/1)OTE(Local:2:O.Data.0);
END
"""


@pytest.fixture(params=["panel.py", "panel.rung"])
def rack(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """The rack with its program in Python, and as a rung with the card's addresses."""
    (tmp_path / "panel.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "panel.rung").write_text(RUNGS, encoding="utf-8")
    path = tmp_path / "panel.toml"
    path.write_text(RACK.replace("panel.py", request.param), encoding="utf-8")
    return path


@pytest.fixture
def trace(rack: Path) -> Path:
    """A recording of the rack's run."""
    target = rack.with_suffix(".mcap")
    assert scanrack("run", rack, "--record", target, "--quiet") == ""
    return target


def scanrack(*words: object, status: int = 0) -> str:
    """Return what a command prints."""
    result = CliRunner().invoke(build(), [str(word) for word in words])
    assert result.exit_code == status, result.output
    return result.stdout


def test_the_lamp_is_on_from_start_to_stop(trace: Path) -> None:
    """Inputs act in the scan of their instant: 10 ms is scan 5, 60 ms scan 30."""
    printed = scanrack("query", trace, "slot2.out.lamp")
    assert printed.split() == ["scan", "to", "scan", "time", "s", "lasted", "5", "29", "0.010", "50", "ms"]


def test_the_trace_has_the_names_of_words_and_bits(trace: Path) -> None:
    with open_trace(trace) as recorded:
        panel = recorded.head.slots[1]
        assert (panel.module, panel.firmware, panel.words.message, panel.words.inputs[:2]) == (
            "discrete16",
            "",
            "Discrete",
            ("data", "word1"),
        )
        assert panel.words.groups == {
            "input": {"start": ("I", 0, 0), "stop": ("I", 0, 1)},
            "output": {"lamp": ("O", 0, 0)},
        }
        assert "slot.1.names" not in recorded.head.metadata


def test_show_tells_by_name(trace: Path) -> None:
    lines = scanrack("show", trace)
    for text in (
        "The start input is energized.",
        "The stop input is de-energized.",
        "+lamp",
        "-lamp",
        "+start",
    ):
        assert text in lines


def test_rerun_and_compare_find_it_the_same(trace: Path) -> None:
    assert "identical byte for byte" in scanrack("replay", "--into", "session", trace, "--trust")


def test_a_difference_is_told_by_name(rack: Path, trace: Path) -> None:
    other = rack.with_name("other.mcap")
    rack.write_text(rack.read_text(encoding="utf-8").replace("at_ms = 60", "at_ms = 50"), encoding="utf-8")
    scanrack("run", rack, "--record", other, "--quiet")
    assert "slot2.in.stop" in scanrack("compare", trace, other, status=1)


def test_forces_have_its_addresses(rack: Path) -> None:
    text = rack.read_text(encoding="utf-8")
    for address in ("Local:2:I.Data.0", "I:2.0/0", "slot2.input.start", "Local:2:I.Data[0].0"):
        spec = parse_rack_file(f'{text}\n[[force]]\naddress = "{address}"\nvalue = 1\n', rack).spec
        assert spec.force[0].address == address
    with pytest.raises(RackFileError, match="did you mean start"):
        parse_rack_file(f'{text}\n[[force]]\naddress = "slot2.input.strat"\nvalue = 1\n', rack)
    with pytest.raises(RackFileError, match="did you mean Data0"):  # a 3601 has eight words
        parse_rack_file(f'{text}\n[[force]]\naddress = "Local:1:I.Data"\nvalue = 1\n', rack)


def test_a_test_presses_its_buttons(rack: Path) -> None:
    rack.write_text(rack.read_text(encoding="utf-8").replace("at_ms = 10,", "at_ms = 99,"), encoding="utf-8")
    with open_bench(rack) as bench:
        bench.scan(2)
        assert (bench.slot[2].status["start"], bench.slot[2].status["stop"]) == (False, True)
        bench.slot[2].press("start", "10 ms")
        bench.scan(2)
        assert bench.slot[2].outputs.bit(0, 0)
        assert str(bench.slot[2]) == "slot 2: stop; outputs [1, 0, 0, 0, 0, 0, 0, 0]"
        with pytest.raises(ValueError, match="no input 'home': inputs are start, stop"):
            bench.slot[2].set_input("home", True)


def drive(*requests: object) -> list[dict[str, object]]:
    """Return the replies of a session."""
    out = io.StringIO()
    respond_to_lines(BENCHES["discrete16"](), [json.dumps(each) for each in requests], out)
    return [json.loads(line) for line in out.getvalue().splitlines()]


def test_it_can_be_driven() -> None:
    new = {"options": {"inputs": {"start": 0, "far": 15}, "outputs": {"lamp": 3}}}
    replies = drive(
        {"new": new},
        {"inputs": {"start": 1, "far": 1}, "out": [8], "for_ms": 4},
        {"inputs": {"home": 1}},
    )
    nothing = [0] * 8
    assert replies[0] == {"t_ms": 0, "scan": 0, "in": nothing, "bits": [], "outputs": [], "events": []}
    assert replies[1] == {
        "t_ms": 4,
        "scan": 2,
        "in": [1 - 0x8000, *nothing[1:]],
        "bits": ["start", "far"],
        "outputs": ["lamp"],
        "events": [],
    }
    assert replies[2]["error"] == "inputs.home: unknown key; choose from start, far"


def test_seconds_are_milliseconds_by_the_thousand() -> None:
    row: Any = {"at_s": 0.0005, "input": "start", "for_s": 0.00125}
    (press,) = CardOptions.of({"inputs": {"start": 4}, "timeline": [row]}).timeline
    assert (press.begin_ns, press.end_ns) == (500_000, 1_750_000)


def test_outputs_are_off_in_program_mode() -> None:
    card = GenericCard()
    card.update(MS, Image([0xFFFF]))
    assert card.lit == 0xFFFF
    card.plc_run(False)
    card.update(2 * MS, Image([0xFFFF]))
    assert card.lit == 0


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"inputs": {"start": 16}}, "a discrete16 has no terminal 16: 0 to 15"),
        ({"inputs": {"Start": 1}}, "'Start' is not a name: use small letters"),
        ({"inputs": {"data": 1}}, "'data' is the name of a word"),
        ({"inputs": {"a": 1, "b": 1}}, "terminal 1 of 'a' is used twice"),
        ({"inputs": {"a": 1}, "normally_closed": ["b"]}, "no input 'b': inputs are a"),
        ({"timeline": [{"at_ms": 1, "input": "a"}]}, "no input 'a': inputs are none"),
        ({"timeline": [{"input": "a"}]}, r"timeline\.0: one of at_ms and at_s is needed"),
        ({"timeline": [{"at_ms": 1, "at_s": 1, "input": "a"}]}, "one of at_ms and at_s is needed"),
        ({"timeline": [{"at_s": 1, "input": "a", "for_s": 1, "for_ms": 1}]}, "use for_ms or for_s, not both"),
        ({"timeline": [{"at_s": 1, "input": "a", "for_m": 1}]}, r"timeline\.0\.for_m: "),
        ({"lamps": {}}, "the card has no such option"),
    ],
)
def test_wiring_that_cannot_be_is_refused(options: dict[str, object], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        GenericCard(CardOptions.of(options))  # type: ignore[arg-type]


def test_it_has_no_machine(rack: Path) -> None:
    machine = "\n[slot.machine]\njams = [{ at = 5, direction = 1 }]\n"
    with pytest.raises(RackFileError, match="has no machine"):
        parse_rack_file(rack.read_text(encoding="utf-8") + machine, rack)


PAGE = Path(__file__).parents[3] / "docs" / "cards.md"


def block(kind: str) -> str:
    """Return the first block of a kind of the page."""
    return PAGE.read_text(encoding="utf-8").partition(f"```{kind}\n")[2].partition("```")[0]


def test_the_page_prints_what_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("panel.toml").write_text(block("toml"), encoding="utf-8")
    Path("panel.rung").write_text(block("text"), encoding="utf-8")
    run, query, *printed = block("console").splitlines()
    for command in (run, query):
        shown = scanrack(*shlex.split(command.removeprefix("$ scanrack ")))
    assert shown.splitlines() == printed
    replies = drive(*(json.loads(line) for line in block("json").splitlines()))
    last = {key: replies[1][key] for key in ("in", "bits", "outputs")}
    assert last == {"in": [1, *[0] * 7], "bits": ["start"], "outputs": ["lamp"]}
