"""The package `scanrack` itself: thirty names, found when they are asked for."""

import ast
import importlib.machinery
import importlib.util
import inspect
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest
import scanrack
from scanrack.commands import build
from scanrack.io_images.front_door import homes_in
from typer.testing import CliRunner


def test_every_name_is_there_and_is_shown():
    for name in dir(scanrack):
        assert getattr(scanrack, name) is not None


def test_the_names_are_those_that_a_type_checker_imports_and_no_private_one():
    tree = ast.parse(inspect.getsource(scanrack))
    read = {
        alias.asname
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        and str(node.module).startswith("scanrack.")
        and node.names[0].asname
        for alias in node.names
    }
    assert {*read, "__version__"} == set(dir(scanrack))
    assert not any(str(name).startswith("_") for name in read)


def test_importing_it_imports_nothing_else():
    code = "import sys, scanrack; print([name for name in sys.modules if name.startswith('scanrack.')])"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, encoding="utf-8"
    )
    assert done.stdout.strip() == "[]"


def test_a_name_that_is_not_there_is_refused_with_what_was_meant():
    with pytest.raises(AttributeError, match="no attribute 'Moov'; did you mean Move"):
        _ = scanrack.Moov


def test_the_version_is_that_of_the_distribution():
    assert scanrack.__version__ == version("scanrack")
    assert CliRunner().invoke(build(), ["--version"]).stdout == f"scanrack {version('scanrack')}\n"


def test_the_package_is_a_command():
    done = subprocess.run(
        [sys.executable, "-m", "scanrack", "--version"], capture_output=True, text=True, encoding="utf-8"
    )
    assert (done.returncode, done.stdout) == (0, f"scanrack {scanrack.__version__}\n")


@pytest.mark.slow
def test_a_first_program_needs_the_front_door_only(tmp_path):
    """A scan is 2 ms: 100 ms are 50 scans, the last one at 98 ms; the timer takes 20 ms."""
    example = Path(__file__).parents[3] / "examples/first"
    for name in ("first.py", "rack.toml"):
        (tmp_path / name).write_text((example / name).read_text(encoding="utf-8"), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "first.py"], cwd=tmp_path, capture_output=True, text=True, encoding="utf-8"
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == [
        "50 scans, 0 moves, the last scan at 98000000 ns",
        "Late is True",
        "CONFIG_ERROR at scan 0: the module has not been configured since it was powered up "
        "[CER-01, chapter 6]",
    ]


def test_a_function_of_this_process_runs_in_place_of_a_racks_program(tmp_path):
    def logic(scan: scanrack.LogicScan) -> None:
        scan.slot[1].outputs[4] = 7

    (tmp_path / "rack.toml").write_text(
        'program = "none.rung"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8"
    )
    rack = scanrack.load_rack(tmp_path / "rack.toml", logic)
    assert scanrack.run(rack, scans=3, trace=tmp_path / "t.mcap").scans == 3
    with scanrack.open_trace(tmp_path / "t.mcap") as trace:
        assert [scan.outputs(1)[4] for scan in trace.scans()] == [7] * 3
        assert next(each.name for each in trace.attachments()).endswith("test_front_door.py")


def test_a_rack_can_not_be_run_for_a_time_and_a_number_of_scans(tmp_path):
    with pytest.raises(ValueError, match="give only one of them"):
        scanrack.run(Path(__file__).parents[3] / "examples/first/rack.toml", "1 s", scans=3)


def test_the_names_are_found_where_pytest_loads_the_package():
    """Its loader, which takes every module of a package with a plugin, gives data and no source."""
    spec = importlib.util.find_spec("scanrack.ladder")
    bare = type("Loader", (), {"get_data": lambda _, path: Path(path).read_bytes()})()
    assert spec is not None
    beneath = importlib.machinery.ModuleSpec(spec.name, bare, origin=spec.origin)
    assert homes_in(beneath) == homes_in(spec) != {}
