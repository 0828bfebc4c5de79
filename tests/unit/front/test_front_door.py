"""The package `scanrack` itself: thirty names, found when they are asked for."""

import ast
import inspect
import subprocess
import sys
from importlib.metadata import version

import pytest
import scanrack
from scanrack.commands import build
from typer.testing import CliRunner


def test_every_name_is_there_and_is_shown():
    assert set(scanrack.__all__) <= set(dir(scanrack))
    for name in scanrack.__all__:
        assert getattr(scanrack, name) is not None


def test_an_editor_finds_the_names_where_they_are_found_when_running():
    """The imports that type checkers read name the same modules as the table that runs."""
    tree = ast.parse(inspect.getsource(scanrack))
    read = {
        alias.name: node.module
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.level == 1
        for alias in node.names
    }
    run = {name: module for module, names in scanrack._HOMES.items() for name in names}
    assert read == {**run, "strategies": "io_images"}
    assert set(scanrack.__all__) == {*read, "__version__"}


def test_importing_it_imports_nothing_else():
    code = "import sys, scanrack; print([name for name in sys.modules if name.startswith('scanrack.')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_name_that_is_not_there_is_refused_with_what_was_meant():
    with pytest.raises(AttributeError, match="no attribute 'Moov'; did you mean Move"):
        _ = scanrack.Moov


def test_the_version_is_that_of_the_distribution():
    assert scanrack.__version__ == version("scanrack")
    assert CliRunner().invoke(build(), ["--version"]).stdout == f"scanrack {version('scanrack')}\n"


def test_the_package_is_a_command():
    done = subprocess.run([sys.executable, "-m", "scanrack", "--version"], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, f"scanrack {scanrack.__version__}\n")
