"""Modules of one's own: a file that `[modules]` names, or the entry point of an installed package."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from importlib import metadata
from importlib.metadata import EntryPoint
from pathlib import Path
from shutil import copytree

import pytest
from scanrack import open_bench, open_trace
from scanrack.commands import build
from scanrack.runtime import RackFileError, load_rack_file
from scanrack.runtime.config.rack_schema import rack_schema
from scanrack.runtime.modules import registry
from scanrack.runtime.modules.registry import MODULES
from scanrack.watch.monitors.hello import slots_of
from typer.testing import CliRunner

EXAMPLE = Path(__file__).parents[3] / "examples" / "own_module"
RAISES = 'raise RuntimeError("executed")\n'


@pytest.fixture
def rack(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the example's rack file, in the current folder."""
    monkeypatch.chdir(copytree(EXAMPLE, tmp_path / "own"))
    return Path("line.toml")


def scanrack(*words: object) -> tuple[int, str]:
    done = CliRunner().invoke(build(), list(map(str, words)))
    return done.exit_code, done.output


def edited(rack: Path, old: str, new: str) -> None:
    text = rack.read_text(encoding="utf-8")
    assert old in text
    rack.write_text(text.replace(old, new), encoding="utf-8")


def flashes(trace: Path) -> list[int]:
    """Return the scans in which the lamp came on."""
    with open_trace(trace) as opened:
        lit = [bool(scan.inputs(1)[0] & 1) for scan in opened.scans()]
    return [number for number in range(1, len(lit)) if lit[number] and not lit[number - 1]]


def test_it_runs_is_recorded_by_name_and_runs_again(rack: Path) -> None:
    """50 ms on, 50 ms off, 2 ms a scan; ON reaches the module with scan 1, and the fifth flash ends it."""
    assert scanrack("run", rack, "--record", "a.mcap", "-q")[0] == 0
    assert flashes(Path("a.mcap")) == [1, 50, 100, 150, 200]
    assert "+LIT, flashes 1 -> 2" in scanrack("show", "a.mcap")[1]
    assert scanrack("query", "a.mcap", "slot1.in.flashes == 3")[1].splitlines()[1].split()[:2] == [
        "100",
        "149",
    ]
    told = scanrack("replay", "--into", "session", "a.mcap")[1]
    assert told.endswith("identical byte for byte\n")  # the file is that of this folder


def test_a_copy_of_its_code_in_a_trace_is_run_when_it_is_trusted_only(
    rack: Path, tmp_path, monkeypatch
) -> None:
    assert scanrack("run", rack, "--record", tmp_path / "a.mcap", "-q")[0] == 0
    monkeypatch.chdir(tmp_path)
    status, said = scanrack("replay", "--into", "session", "a.mcap")
    assert status == 2
    assert "blinker.py" in said
    assert "add --trust" in said
    assert scanrack("replay", "--into", "session", "a.mcap", "--trust")[1].endswith(
        "identical byte for byte\n"
    )


def test_nothing_is_executed_that_only_reads_the_rack_or_its_trace(rack: Path) -> None:
    edited(rack, "half_ms = 50 }", 'half_ms = 50 }\n\n[[force]]\naddress = "slot1.command.ON"\nvalue = 1')
    assert scanrack("run", rack, "--record", "a.mcap", "-q")[0] == 0
    Path("blinker.py").write_text(RAISES, encoding="utf-8")
    assert load_rack_file(rack).spec.slot[0].module == "blinker"
    assert scanrack("show", "a.mcap")[0] == 0
    assert scanrack("query", "a.mcap", "slot1.in.LIT")[0] == 0
    assert "executed" in scanrack("run", rack, "--no-record")[1]


def test_a_bit_of_it_is_forced_by_name(rack: Path) -> None:
    edited(rack, "half_ms = 50 }", 'half_ms = 50 }\n\n[[force]]\naddress = "slot1.command.ON"\nvalue = 0')
    assert scanrack("check", rack)[0] == 0
    assert scanrack("run", rack, "--record", "a.mcap", "-q")[0] == 0
    assert flashes(Path("a.mcap")) == []
    assert scanrack("replay", "--into", "session", "a.mcap")[0] == 0
    edited(rack, "slot1.command.ON", "slot1.command.OFF")
    status, said = scanrack("run", rack, "--no-record")
    assert status == 2
    assert "OFF" in said


def test_the_bench_and_the_page_know_its_names(rack: Path) -> None:
    with open_bench(rack) as bench:
        bench.run_until("Count.DN", within="1 s")
        assert bench.now_s == pytest.approx(0.4)  # the fifth flash begins after 8 halves of 50 ms
        assert (bench.slot[1].status.LIT, bench.slot[1].status.flashes) == (True, 5)
        assert bench["slot1.status.LIT"]
        with pytest.raises(
            AttributeError, match="the module's inputs have no 'FLASHES'; choose from LIT, state, flashes"
        ):
            _ = bench.slot[1].status.FLASHES
        shown, stepper = slots_of(bench.spec)
    assert [(each["name"], each["section"]) for each in shown["bits"]] == [("ON", ""), ("LIT", "")]
    assert {each["section"] for each in stepper["bits"]} > {""} or all(
        each["section"] for each in stepper["bits"]
    )


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "half_ms = 50",
            "half_ms = 0",
            "line.toml:15: slot.options.half_ms = 0: option half_ms: 0 is out of range",
        ),
        ("half_ms = 50", "half_s = 1", "the blinker has no such option; did you mean half_ms?"),
        ('module = "blinker"', 'module = "blinkr"', "did you mean blinker?"),
        ('blinker = "blinker.py"', 'blinker = "nosuch.py"', "nosuch.py"),
        ('blinker = "blinker.py"', 'blinker = "blinker.py:WORDS"', "no ModuleRecord named WORDS"),
        ('blinker = "blinker.py"', "blinker = 3", "line.toml:10: modules.blinker = 3"),
        (
            'blinker = "blinker.py"',
            'blinker = "blinker.py"\namci3601 = "blinker.py"',
            "another module has this name",
        ),
    ],
)
def test_a_mistake_is_told_with_its_place(rack: Path, old: str, new: str, said: str) -> None:
    edited(rack, old, new)
    status, output = scanrack("run", rack, "--no-record")
    assert status == 2
    assert said in output


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        (
            '"LIT": BitPlace("I", 0, 0)',
            '"LIT": BitPlace("I", 0, 3), "DARK": BitPlace("I", 0, 3), "HOT": BitPlace("I", 0, 15)',
            "status: LIT and DARK are both bit 3 of input word 0; free bits: 0 to 2, 4 to 14 of word 0",
        ),
        (
            '"ON": BitPlace("O", 0, 0)',
            '"ON": BitPlace("O", 0, 0), "OFF": BitPlace("O", 0, 0)',
            "Blinker: command: ON and OFF are both bit 0 of output word 0; free bits: 1 to 15 of word 0",
        ),
        (
            'BitPlace("I", 0, 0)',
            'BitPlace("I", 0, 16)',
            "Blinker: status.LIT: .*bit=16.*: must be of image I or O",
        ),
        (
            'BitPlace("I", 0, 0)',
            'BitPlace("Q", 0, 0)',
            "Blinker: status.LIT: .*'Q'.*: must be of image I or O",
        ),
        (
            'BitPlace("O", 0, 0)',
            'BitPlace("O", 8, 0)',
            "Blinker: command.ON: .*word=8.*word 0 to 7, bit 0 to 15",
        ),
    ],
)
def test_names_of_bits_are_refused_when_the_file_is_loaded(
    rack: Path, right: str, wrong: str, said: str
) -> None:
    file = Path("blinker.py")
    source = file.read_text(encoding="utf-8")
    assert right in source
    file.write_text(source.replace(right, wrong), encoding="utf-8")
    for command in ("run", "check"):
        status, output = scanrack(command, rack)
        assert status == 2
        assert re.search(said, " ".join(output.split()))


def test_a_module_that_is_not_executed_refuses_no_key_of_its_slot(rack: Path) -> None:
    edited(rack, 'module = "blinker"', 'module = "blinker"\nfirmware = "7"\nport = "COM3"\naddress = 300')
    card = '[[slot]]\nnumber = 5\nmodule = "discrete16"\n[slot.options]\ninputs = { at = 0 }\n'
    cam = 'cam = [{ input = "at", slot = 6, first = 0 }]\n'
    with rack.open("a", encoding="utf-8") as file:
        file.write(f'\n{card}{cam}\n[[slot]]\nnumber = 6\nmodule = "blinker"\n')
    assert [each.number for each in load_rack_file(rack).spec.slot][-2:] == [5, 6]


def test_the_schema_lets_a_rack_name_its_own_modules() -> None:
    schema = rack_schema()
    assert schema["if"] == {"not": {"required": ["modules"]}}
    assert "amci3601" in json.dumps(schema["then"])


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """A package with the module, one whose entry point leads nowhere, one that would shadow the 3601."""
    (tmp_path / "scanrack_blinker.py").write_text(
        (EXAMPLE / "blinker.py").read_text(encoding="utf-8"), "utf-8"
    )
    monkeypatch.syspath_prepend(tmp_path)
    points = [
        EntryPoint("blinker", "scanrack_blinker:RECORD", registry.GROUP),
        EntryPoint("lost", "scanrack_lost:RECORD", registry.GROUP),
        EntryPoint("amci3601", "scanrack_blinker:RECORD", registry.GROUP),
    ]
    monkeypatch.setattr(metadata, "entry_points", lambda group: points)
    registry._installed.cache_clear()
    yield
    registry._installed.cache_clear()
    registry._record_of.cache_clear()


def test_an_installed_package_has_modules(rack: Path, installed: None) -> None:
    edited(rack, '[modules]\nblinker = "blinker.py"\n', "")
    assert scanrack("run", rack, "--record", "a.mcap", "-q")[0] == 0
    assert flashes(Path("a.mcap")) == [1, 50, 100, 150, 200]
    assert MODULES["amci3601"].name == "amci3601"  # a package shadows nothing
    edited(rack, '"blinker"', '"lost"')
    with pytest.raises(RackFileError, match="scanrack_lost:RECORD can't be imported"):
        load_rack_file(rack)


def test_the_page_shows_the_files_of_the_example() -> None:
    page = (EXAMPLE.parents[1] / "docs" / "own-module.md").read_text(encoding="utf-8")
    assert f"```python\n{(EXAMPLE / 'blinker.py').read_text(encoding='utf-8')}```\n" in page
    test = (EXAMPLE / "test_blinker.py").read_text(encoding="utf-8").partition("\n\n")[2]
    assert f"```python\n{test}```\n" in page
