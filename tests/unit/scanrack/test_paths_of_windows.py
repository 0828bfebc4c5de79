"""Paths with drives, backslashes and names that Windows reserves, wherever scanrack reads or makes one."""

from __future__ import annotations

import ntpath
import re
from pathlib import Path, PureWindowsPath
from types import SimpleNamespace

import pytest
from house import ROOMS
from scanrack.commands import build
from scanrack.jobs import State
from scanrack.jobs.fuzz import Counterexample, Scenario
from scanrack.jobs.fuzz.run import BrokenInvariant
from scanrack.jobs.trust import attachments
from scanrack.jobs.trust.extracting import checked_name
from scanrack.testing.folder import file_name
from scanrack.traces.files import portable
from scanrack.traces.files.portable import no_device, relative
from typer.testing import CliRunner

ROOT = Path(__file__).parents[3]
SMALL = "PROGRAM small\nTAG A : BOOL\nTAG B : BOOL\nROUTINE Main\n{}(A)OTE(B);\nEND\n"


@pytest.fixture
def on_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let relative paths be those of Windows."""
    monkeypatch.setattr(portable, "relpath", ntpath.relpath)
    monkeypatch.setattr(portable, "Path", PureWindowsPath)


@pytest.mark.usefixtures("on_windows")
def test_a_relative_path_has_slashes_and_to_another_drive_there_is_none() -> None:
    assert relative(r"C:\line\programs\a.rung", r"C:\line") == "programs/a.rung"
    assert relative(r"C:\line\a.rung", r"C:\line\found\no_crash") == "../../a.rung"
    assert relative(r"D:\other\a.rung", r"C:\line") == "D:/other/a.rung"


@pytest.mark.usefixtures("on_windows")
def test_only_what_is_in_the_folder_of_a_rack_travels_with_a_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    for each in ("_imported", "_stub_functions", "_unit_programs"):
        monkeypatch.setattr(attachments, each, lambda _job: {})

    def other(folder: str, program: str) -> SimpleNamespace:
        paths = {"rack_file": PureWindowsPath(folder, "rack.toml"), "program": PureWindowsPath(program)}
        return SimpleNamespace(job=SimpleNamespace(folder=PureWindowsPath(folder), **paths))

    others = [
        other(r"C:\line\oven", r"C:\line\oven\heat.rung"),
        other(r"C:\line\belt", r"D:\shared\belt.rung"),
        other(r"C:\line\saw", r"C:\line\cut.rung"),
        other(r"C:\press", r"C:\press\press.rung"),
        other(r"D:\paint", r"D:\paint\paint.rung"),
    ]
    job = SimpleNamespace(folder=PureWindowsPath(r"C:\line"), world=SimpleNamespace(others=others))
    found = {name: str(path) for name, path in attachments._racks_beside(job).items()}  # type: ignore[arg-type]
    assert found == {
        "oven/rack.toml": r"C:\line\oven\rack.toml",
        "oven/heat.rung": r"C:\line\oven\heat.rung",
        "belt/rack.toml": r"C:\line\belt\rack.toml",
        "saw/rack.toml": r"C:\line\saw\rack.toml",
    }
    assert [checked_name(name) for name in found] == [*found]


def test_prove_takes_a_program_by_its_drive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    old, new = Path(r"C:\old.rung"), Path(r"C:\new.rung")
    old.write_text(SMALL.format("XIC"), encoding="utf-8")
    new.write_text(SMALL.format("XIO"), encoding="utf-8")
    assert CliRunner().invoke(build(), ["prove", str(old), str(new)]).exit_code == 1
    assert Path(r"C:\new-prove").is_dir()
    refused = CliRunner().invoke(build(), ["prove", str(old), str(new), "--html", str(new)])
    assert refused.exit_code == 2
    assert "is one of the programs: choose another file" in refused.stderr
    bad = Path(r"C:\bad.rung")
    bad.write_text(SMALL.format("XIC").replace("XIC(A)", "// prove: never B\n"), encoding="utf-8")
    assert CliRunner().invoke(build(), ["prove", str(bad)]).exit_code == 1
    assert Path(r"C:\bad-prove").is_dir()
    made = [str(old), str(new), str(bad), r"C:\new-prove", r"C:\bad-prove"]
    assert sorted(each.name for each in tmp_path.iterdir()) == sorted(made)


@pytest.mark.parametrize("name", ["con", "PRN", "Aux", "nul", "com1", "LPT9", "com¹"])
def test_a_name_that_windows_reserves_gets_a_line(name: str) -> None:
    for each in (name, f"{name}.mcap", f"{name}.line.mcap"):
        with pytest.raises(ValueError, match="is a device on Windows"):
            checked_name(f"folder/{each}")
        assert checked_name(no_device(each)) == each.replace(name, f"{name}_")


@pytest.mark.parametrize("name", ["console", "null", "com10", "comb", "auxiliary.mcap", ".con"])
def test_a_name_that_windows_does_not_reserve_stays(name: str) -> None:
    assert no_device(name) == checked_name(name) == name


def test_the_folders_of_failures_are_different_ones_where_case_does_not_count() -> None:
    state = State()
    for invariant in ("stop", "Stop", "aux", "AUX_", "Corpus", "nul"):
        broken = BrokenInvariant(invariant, f"{invariant} is broken", 0, 0, "")
        state.note([Counterexample(Scenario(), broken, 1)])
    assert [*state.folders.values()] == ["stop", "Stop-2", "aux_", "AUX_-2", "Corpus-2", "nul_"]


def test_the_folder_of_a_test_is_no_device() -> None:
    assert file_name("aux") == "aux_"


def test_no_path_is_compared_with_a_slash_at_its_end() -> None:
    """On Windows code is in folders whose names end in a backslash: scanrack's own would be the user's."""
    ends = re.compile(r"""(parents?(\[\d\])?( / \w+)?|__path__\[0\]|get_path\(\w+\))\}/["']""")
    sources = [path for room in ROOMS for path in (ROOT / room).rglob("*.py")]
    assert {path.name for path in sources if ends.search(path.read_text(encoding="utf-8"))} == set()
