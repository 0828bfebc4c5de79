"""What looks runnable on a page runs, and moves something.

Every fenced Python block that defines `logic` or a class of `Logic`, every rack file, and the commands of the
README and of the pages about charts and queries, from the root of a fresh copy.
"""

import re
import shlex
import shutil
import sys
from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.runtime import RackSpec, load_rack_file
from typer.testing import CliRunner

ROOT = Path(__file__).parents[3]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
BENCH = 'program = "line.py"\nrun_for_s = 6\n\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
SNIPPETS = [
    pytest.param(language, text, id=f"{page.stem}-{number}")
    for page in PAGES
    for number, (language, text) in enumerate(BLOCK.findall(page.read_text(encoding="utf-8")))
]
LOGIC = [each for each in SNIPPETS if each.values[0] == "python" and "\ndef logic(" in str(each.values[1])]
CLASSES = [each for each in SNIPPETS if each.values[0] == "python" and "(Logic):" in str(each.values[1])]
RACKS = [each for each in SNIPPETS if each.values[0] == "toml" and "program = " in str(each.values[1])]


def scanrack(*arguments):
    return CliRunner().invoke(build(), arguments)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    for file in (ROOT / "examples" / "three_stations").glob("*.py"):
        shutil.copy(file, tmp_path)
    return tmp_path


def moves_of(rack):
    """Run a rack; return how many moves its summary counts."""
    done = scanrack("run", rack, "--no-record")
    assert (done.exit_code, done.stderr) == (0, "")
    moves = re.search(r"^moves +(\d+|none)$", done.stdout, re.MULTILINE)
    assert moves is not None
    return int(moves[1].replace("none", "0"))


def test_there_is_something_to_run():
    assert len(LOGIC) >= 2
    assert CLASSES
    assert len(RACKS) >= 2


@pytest.mark.parametrize(("language", "text"), LOGIC)
def test_logic_moves_the_axis(folder, language, text):
    (folder / "line.py").write_text(text, encoding="utf-8")
    (folder / "line.toml").write_text(BENCH, encoding="utf-8")
    assert moves_of("line.toml") > 0


@pytest.mark.parametrize(("language", "text"), RACKS)
def test_a_rack_file_is_one(folder, language, text):
    (folder / "line.toml").write_text(text, encoding="utf-8")
    if "[[slot]]" in text:
        assert isinstance(load_rack_file("line.toml").spec, RackSpec)


def test_the_rack_of_the_page_about_running_moves_the_axis(folder):
    (text,) = [str(each.values[1]) for each in RACKS if str(each.id).startswith("run-")]
    (folder / "line.toml").write_text(text, encoding="utf-8")
    assert moves_of("line.toml") > 0


@pytest.mark.parametrize(("language", "text"), CLASSES)
def test_sequences_run_on_the_rack_of_their_page(folder, language, text):
    (rack,) = [str(each.values[1]) for each in RACKS if str(each.id).startswith("sequences-")]
    (folder / "line.py").write_text(text, encoding="utf-8")
    (folder / "line.toml").write_text(rack, encoding="utf-8")
    assert moves_of("line.toml") == 4  # home, 0, 4000, 8000


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    """A folder with the examples, as in a fresh clone."""
    clone = tmp_path_factory.mktemp("clone")
    shutil.copytree(ROOT / "examples", clone / "examples", ignore=shutil.ignore_patterns("*.mcap"))
    return clone


READS = r"scanrack (?:show|run|watch|plot|query|export) \S+\.(?:mcap|toml)\b[^`]*"
BIN = r"\.venv/bin/"
INLINE = re.compile(rf"^    (?:python3 .* && {BIN})?(scanrack \S.*)$|`(?:{BIN})?({READS})`", re.MULTILINE)


@pytest.mark.slow
@pytest.mark.parametrize("page", ["README.md", pytest.param("docs/plot.md", marks=pytest.mark.extra("plot"))])
def test_the_commands_of_a_page_run_one_after_the_other(clone, page, monkeypatch):
    monkeypatch.chdir(clone)
    text = (ROOT / page).read_text(encoding="utf-8")
    commands = [shell or inline for shell, inline in INLINE.findall(text)]
    concrete = [each for each in commands if re.search(r"\.(mcap|toml)\b", each)]
    assert len(concrete) >= 2
    for command in concrete:
        ending = ["--scans", "50", "--time-scale", "max"] if " watch " in command else []
        shown = command.replace(" --open", "")  # there may be no browser
        done = scanrack(*shlex.split(shown)[1:], *ending)
        assert (done.exit_code, done.stderr) == (0, ""), command
