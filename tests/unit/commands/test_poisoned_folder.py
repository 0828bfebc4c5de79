"""Commands in a folder that has a module of every name there is: none of them runs.

The commands run one after the other in one process whose search path is that of the `scanrack` command; the
helpers that they start are processes of their own.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from importlib import import_module
from importlib.metadata import packages_distributions
from importlib.util import find_spec
from pathlib import Path

import pytest
from scanrack.commands import COMMANDS
from scanrack.jobs import ProgramError, load_program
from scanrack.jobs.trust import launcher
from scanrack.jobs.trust.attachments import forget_imported
from scanrack.jobs.trust.launcher import PIPE, launch
from scanrack.traces.format.limits import Limits, limited

ROOT = Path(__file__).parents[3]
FEEDER, L5X = ROOT / "examples/feeder", ROOT / "examples/l5x"

POISON = "open('ran', 'a').write(__name__ + ' ')\n"

OPTIONAL = {"IPython", "attr", "dask", "distributed", "lz4", "matplotlib", "orjson", "pandas", "polars"}
"""Names that we or a library try to import, installed or not."""

PROGRAM = """
import json
import helper

def logic(scan):
    import bisect, graphlib, late_helper
    scan.slot[1].outputs[4] = helper.WORD
"""

INVARIANTS = """
import helper
from scanrack import always

@always
def nothing_is_sent(now):
    return helper.WORD != 1
"""

SMALL = "PROGRAM small\nTAG A : BOOL\nTAG B : BOOL\nROUTINE Main\nXIC(A)OTE(B);\nEND\n"
RACK = '[[slot]]\nnumber = 1\nmodule = "amci3601"\n'

DRIVER = """
import contextlib, io, json, os, sys
from scanrack.__main__ import main

told = {}
for words in json.load(sys.stdin):
    sys.argv = ["scanrack", *words]
    sys.stdin = io.StringIO()
    sys.stdin.buffer = io.BytesIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as errors:
        try:
            main()
        except SystemExit as end:
            told[" ".join(words)] = [end.code or 0, errors.getvalue()]
    assert os.getcwd() not in sys.path, words
print(json.dumps(told))
"""

WORDS = {
    "run feeder.toml --for 20ms --record t.mcap": 0,
    "run line.toml --for 20ms --record p.mcap": 0,
    "watch feeder.toml --for 20ms --time-scale max": 0,
    "watch line.toml --for 20ms --time-scale max": 0,
    "debug": 0,  # an editor that ends at once
    "share t.mcap --out shared.html": 0,
    "show t.mcap": 0,
    "query t.mcap slot1.in.MODULE_OK": 0,
    "plot t.mcap --out t.html": 0,
    "plot t.mcap --out t.pdf": 2,
    "export t.mcap --csv t.csv": 0,
    "compare t.mcap t.mcap": 0,
    "repair t.mcap --out repaired.mcap": 0,
    "import missing.pcapng": 2,
    "conform --list": 0,
    "replay t.mcap": 0,
    "replay --into session t.mcap": 0,
    "replay --into session p.mcap --trust": 0,
    "ladder feeder.rung": 0,
    "tags feeder.toml": 0,
    "l5x missing.L5X": 2,
    "why t.mcap Feeding": 0,
    "why p.mcap O:1.4 --trust": 0,
    "xref feeder.toml Feeding": 0,
    "fuzz line.toml --for 20ms --runs 2 --jobs 1 --invariants must.py": 1,
    "prove small.rung": 0,
    "drive pcl601": 0,
    "serve pcl601 --program missing": 2,
    "serve anf2 --tcp 0 --axes 13": 2,
    "device pcl601 --tcp 127.0.0.1:1 status": 1,
    "device pmc006 --serial missing status": 1,
    "device list": 0,
    "device identify tcp:127.0.0.1:1": 1,
    "check missing.pclt": 2,
    "check feeder.toml": 0,
    "check line.toml": 0,
    "editor schema --write": 0,
    "editor lsp": 0 if find_spec("pygls") else 2,  # an editor that ends at once
    "doctor": 0,
    "rules amci3601": 0,
    "new project --from feeder": 0,
}
"""Each command once at least, and its exit status."""


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    """A folder with two racks and a poisoned module of every name."""
    place: Path = tmp_path_factory.mktemp("poisoned")
    for name in {*sys.stdlib_module_names, *packages_distributions(), *OPTIONAL, "sitecustomize"}:
        if name.isidentifier():
            (place / f"{name}.py").write_text(POISON, encoding="utf-8")
    for file in ("feeder.toml", "feeder.rung"):
        shutil.copy(FEEDER / file, place)
    files = {
        "line.py": PROGRAM,
        "line.toml": f'program = "line.py"\n{RACK}',
        "helper.py": "WORD = 1\n",
        "small.rung": SMALL,
        "must.py": INVARIANTS,
    }
    for name, text in {**files, "late_helper.py": ""}.items():
        (place / name).write_text(text, encoding="utf-8")
    return place


@pytest.mark.slow
def test_no_command_runs_a_module_of_the_current_folder(place: Path, tmp_path: Path) -> None:
    driver = tmp_path / "driver.py"  # its folder takes the place of that of the command's script
    driver.write_text(DRIVER, encoding="utf-8")
    asked = json.dumps([words.split() for words in WORDS])
    done = subprocess.run(
        [sys.executable, driver], cwd=place, input=asked, capture_output=True, text=True, encoding="utf-8"
    )
    assert not (place / "ran").exists(), (place / "ran").read_text(encoding="utf-8")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    for words, status in WORDS.items():
        assert told[words][0] == status, (words, told[words])
    assert {words.split()[0] for words in WORDS} == set(COMMANDS)


@pytest.mark.slow
def test_python_m_scanrack_runs_none_either(place: Path, tmp_path: Path) -> None:
    """But for what Python itself imports before scanrack begins, as it does for any module."""
    folder = tmp_path / "poisoned"
    shutil.copytree(place, folder, ignore=shutil.ignore_patterns("scanrack.py"))
    (folder / "nothing_at_all.py").touch()
    ran, nothing = folder / "ran", [sys.executable, "-m", "nothing_at_all"]
    while subprocess.run(nothing, cwd=folder, stderr=subprocess.DEVNULL).returncode or ran.exists():
        for name in ran.read_text(encoding="utf-8").split():
            (folder / f"{name}.py").unlink()
        ran.unlink()
    words = [sys.executable, "-m", "scanrack", "watch", "feeder.toml", "--for", "20ms", "--time-scale", "max"]
    done = subprocess.run(words, cwd=folder, capture_output=True)
    assert not (folder / "ran").exists(), (folder / "ran").read_text(encoding="utf-8")
    assert done.returncode == 0, done.stderr


def test_a_helper_has_the_path_and_the_limits_of_this_process(
    place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = "import sys\nfrom scanrack.traces.format.limits import limits\n"
    (tmp_path / "asked.py").write_text(
        f"{told}def main(*words): print(sys.path, limits(), words, sys.flags.safe_path)\n", encoding="utf-8"
    )
    path = [str(tmp_path), *filter(None, sys.path)]
    monkeypatch.setattr(sys, "path", ["", *path])
    monkeypatch.setattr(
        launcher, "subprocess", subprocess
    )  # a process of its own, see tests/support/forked.py
    monkeypatch.chdir(place)
    with limited(Limits(123, 456)), launch("asked:main", 7, "a b", stdout=PIPE) as helper:
        assert helper.communicate()[0].decode() == f"{path} {Limits(123, 456)} {('7', 'a b')} True\n"
    assert not (place / "ran").exists()


@pytest.mark.parametrize("text", ["from queue import Feeder", "import queue; queue.feeder"])
def test_a_module_beside_a_program_that_is_installed_too_is_named(place: Path, text: str) -> None:
    program = place / "hidden.py"
    program.write_text(text, encoding="utf-8")
    with pytest.raises(
        ProgramError, match=f"; {place}/queue.py is not imported: an installed module has its name$"
    ):
        load_program(str(program))


def test_only_a_program_and_its_helpers_find_the_modules_beside_it(tmp_path: Path) -> None:
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    for name, text in {
        "one/line.py": "import one_helper\nfrom one_package import part\nlogic = one_helper.logic\n",
        "one/one_helper.py": "import importlib\ndef logic(scan): importlib.import_module('one_late')\n",
        "one/one_late.py": "",
        "one/one_package/__init__.py": "",
        "one/one_package/part.py": "import one_other\n",
        "one/one_other.py": "",
        "two/line.py": "import one_unknown\n",
        "one/one_unknown.py": "",
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    path = list(sys.path)
    load_program(str(tmp_path / "one/line.py")).function(None)
    assert sys.path == path
    with pytest.raises(ProgramError, match="No module named 'one_unknown'"):
        load_program(str(tmp_path / "two/line.py"))
    with pytest.raises(ModuleNotFoundError):
        import_module("one_unknown")
    forget_imported(tmp_path / "one")
