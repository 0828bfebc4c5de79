"""Traces made to run code, to read or to write where they should not: none does without `--trust`.

Every forgery would write `canary` in the folder above if its Python ran, and shows `SECRET` if a file
outside of the trace is read. The user's folder has a program `line.py` that imports `helper.py`.

Broken on purpose: trust asked for by the suffix of the recorded address, as before (12 forgeries run),
only Python sources compared with the user's (.pyc, .so and package folders run), names unchecked.
"""

from __future__ import annotations

import importlib.util
import socket
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import forked
import made_traces
import pytest
from golden import app as golden_app
from scanrack.commands import build
from scanrack.traces import Attachment, ScanRecorder
from typer.testing import CliRunner, Result

PYC = importlib.util.cache_from_source("helper.py")  # __pycache__/helper.cpython-3xx.pyc
SECRET = "the word is swordfish"
EVIL = "open({canary!r}, 'w').close()\ndef logic(scan): pass\ndef rack(): pass\n"
LINE = "import helper\ndef logic(scan): helper.turn(scan)\n"
HELPER = "def turn(scan): scan.slot[1].outputs[5] = 0\n"
RUNGS = "PROGRAM quiet\nROUTINE Main\nXIC(S:FS)NOP();\nEND\n"
RACK = 'program = "{program}"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
UNIT = "[[unit]]\ncontroller = \"pcl601\"\nprogram = '{path}'\n"


def rack(program: str = "line.py", unit: str | None = None, more: str = "") -> str:
    return RACK.format(program=program) + (UNIT.format(path=unit) if unit else "") + more


class Forgery(NamedTuple):
    """A trace: the files in it, what its metadata say they are, and what `rerun` says of it.

    Text of a file in which {canary}, {outside} or {port} stands is filled in; bytes are compiled EVIL.
    """

    files: Mapping[str, str | bytes]
    program: str
    says: str | None
    rack: str = "rack.toml"


COMPILED = b"compiled"
OUT = "leads out of its folder"
TRUST = "this would run Python that came with the trace"
NO_PROGRAM = "a program must be a .py, .rung, .st, .steps, .L5X or .SLC file"


def program(name: str, says: str, file: str = "e.py") -> Forgery:
    return Forgery({"rack.toml": rack(file), file: EVIL}, name, says)


def rack_file(name: str, says: str, file: str = "e.py") -> Forgery:
    return Forgery({file: EVIL}, name, says, rack=name)


def beside(name: str, content: str | bytes = EVIL, says: str = TRUST) -> Forgery:
    """Return a trace of the user's own program with something beside it that would shadow its helper."""
    return Forgery({"rack.toml": rack(), "line.py": LINE, name: content}, "line.py:logic", says)


def unit(path: str, says: str, **more: str) -> Forgery:
    return Forgery({"rack.toml": rack("q.rung", unit=path), "q.rung": RUNGS, **more}, "q.rung", says)


FORGERIES = {
    "rack file called the program": Forgery(
        {"rack.toml": rack("e.py"), "e.py": EVIL}, "rack.toml", NO_PROGRAM
    ),
    "rack file called the program, program outside": Forgery(
        {"rack.toml": rack("{outside}/e.py")}, "rack.toml:logic", NO_PROGRAM
    ),
    "program e.py": program("e.py", TRUST),
    "program e.py:logic": program("e.py:logic", TRUST),
    "program e.py/": program("e.py/", "empty part"),
    "program e.py/.": program("e.py/.", "has a part '.'"),
    "program ./e.py": program("./e.py", "has a part '.'"),
    "program e.txt": program("e.txt", NO_PROGRAM, "e.txt"),
    "program e.PY": program("e.PY", NO_PROGRAM, "e.PY"),
    "program e.pyw": program("e.pyw", NO_PROGRAM, "e.pyw"),
    "program e": program("e", NO_PROGRAM, "e"),
    "program e.pyc": Forgery({"rack.toml": rack("e.pyc"), "e.pyc": COMPILED}, "e.pyc", NO_PROGRAM),
    "program words.json": program("words.json", NO_PROGRAM, "words.json"),
    "program ../e.py": program("../outside/e.py", OUT),
    "program up and down": program("a/../../outside/e.py", OUT),
    "program absolute": program("{outside}/e.py", OUT),
    "program ..\\e.py": program("..\\outside\\e.py", OUT),
    "program C:e.py": program("C:e.py", "drive"),
    "program C:/e.py": program("C:/e.py", "drive"),
    "program with a space at its end": program("e.py ", "ends in a dot or a space"),
    "program with a dot at its end": program("e.py.", "ends in a dot or a space"),
    "program with a line feed": program("e.py\n", "can't be printed", "e.py\n"),
    "program written backwards": program("\u202eyp.e", "can't be printed"),
    "program that is a device": program("con.py", "is a device", "con.py"),
    "program not in the trace": Forgery({"rack.toml": rack()}, "line.py", "has no file line.py"),
    "program of rungs that is Python": program("e.rung", "e.rung:1:", "e.rung"),
    "program of steps that is Python": program("e.steps", "e.steps:1:", "e.steps"),
    "rungs whose comment ends early": Forgery(
        {
            "rack.toml": rack("q.rung"),
            "q.rung": "PROGRAM q\nROUTINE Main\n// no\r\x0b\x0c\x1c\x85\u2028" + "open({canary!r}, 'w')"
            "\nNOP();\nEND\n",
        },
        "q.rung",
        "q.rung:",
    ),
    "rack e.py": rack_file("e.py", TRUST),
    "rack e.py:rack": rack_file("e.py:rack", TRUST),
    "rack e.py/": rack_file("e.py/", "empty part"),
    "rack e.py/.:rack": rack_file("e.py/.:rack", "has a part '.'"),
    "rack e.PY": rack_file("e.PY", "a rack must be a .toml or .py file", "e.PY"),
    "rack outside": rack_file("../outside/e.py:rack", OUT),
    "rack absolute": rack_file("{outside}/e.py:rack", OUT),
    "rack twice, in two cases": Forgery(
        {"e.py": EVIL, "E.py": EVIL}, "e.py:rack", "may be the same file", rack="e.py:rack"
    ),
    "helper.py": beside("helper.py"),
    "helper.pyc": beside("helper.pyc", COMPILED),
    "helper/__init__.pyc": beside("helper/__init__.pyc", COMPILED),
    "helper/__init__.py": beside("helper/__init__.py"),
    "compiled helper in __pycache__": beside(PYC, COMPILED),
    "helper.so": beside("helper.so"),
    "helper.abi3.so": beside("helper.abi3.so"),
    "helper.pyd": beside("helper.pyd"),
    "helper.zip": beside("helper.zip"),
    "line.pth": beside("line.pth", "import os; open({canary!r}, 'w')"),
    "sitecustomize.py": beside("sitecustomize.py"),
    "usercustomize/__init__.py": beside("usercustomize/__init__.py"),
    "a module of the library": beside("random.py"),
    "helper outside": beside("../helper.py", says=OUT),
    "unit's program called helper.py": Forgery(
        {"rack.toml": rack(unit="helper.py"), "line.py": LINE, "helper.py": EVIL},
        "line.py",
        "the suffix .pclt",
    ),
    "unit's program absolute": unit("{outside}/secret.pclt", OUT),
    "unit's program in ..": unit("../outside/secret.pclt", OUT),
    "unit's program in a\\..": unit("..\\outside\\secret.pclt", OUT),
    "unit's program on a drive": unit("D:secret.pclt", "drive"),
    "unit's program is not in the trace": unit("line.pclt", "has no file line.pclt"),
    "unit's program through a link": unit("link/secret.pclt", "has no file link/secret.pclt"),
    "unit's program beside Python": Forgery(
        {"rack.toml": rack(unit="{outside}/secret.pclt"), "line.py": LINE, "helper.py": HELPER},
        "line.py",
        OUT,
    ),
    "rack file with a long key": Forgery(
        {"rack.toml": "a." * 16 + "a = 1", "line.py": LINE, "helper.py": HELPER},
        "line.py",
        "a name of more than 16 parts",
    ),
    "rack file nested without end": Forgery(
        {"rack.toml": "a = " + "[" * 33, "line.py": LINE, "helper.py": HELPER},
        "line.py",
        "nested deeper than 32",
    ),
    "trace written outside": Forgery(
        {"rack.toml": "trace = '{outside}/written'\n" + rack("q.rung"), "q.rung": RUNGS}, "q.rung", None
    ),
    "real port": Forgery(
        {
            "rack.toml": RACK.format(program="q.rung").replace("amci3601", "pcl601-adapter")
            + "port = 'tcp:127.0.0.1:{port}'\n",
            "q.rung": RUNGS,
        },
        "q.rung",
        " is real, ",
    ),
    "harmless, with Python that is not needed": Forgery(
        {"rack.toml": rack("q.rung"), "q.rung": RUNGS, "sitecustomize.py": EVIL, "../e.py": EVIL},
        "q.rung",
        None,
    ),
}


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The user's folder; beside it `outside`, which no trace may read, run or write to."""
    own, outside = tmp_path / "own", tmp_path / "outside"
    own.mkdir()
    outside.mkdir()
    (own / "line.py").write_text(LINE, encoding="utf-8")
    (own / "helper.py").write_text(HELPER, encoding="utf-8")
    (own / "link").symlink_to(outside)
    (outside / "secret").write_text(SECRET, encoding="utf-8")
    (outside / "secret.pclt").write_text(SECRET, encoding="utf-8")
    (outside / "e.py").write_text(EVIL.format(canary=str(tmp_path / "canary")), encoding="utf-8")
    monkeypatch.chdir(own)
    monkeypatch.setattr(sys, "path", list(sys.path))
    yield own
    for name in [name for name in sys.modules if name == "helper" or name.startswith("scanrack_program_")]:
        del sys.modules[name]


def forge(own: Path, forgery: Forgery, port: int = 1) -> Path:
    """Write a forged trace."""
    known = {"canary": str(own.parent / "canary"), "outside": str(own.parent / "outside"), "port": port}
    files = [Attachment(name, made(content, known)) for name, content in forgery.files.items()]
    recorder = ScanRecorder(
        own / "forged.mcap",
        bytearray(32),
        [made_traces.A3601],
        scan_period_ns=2_000_000,
        attachments=files,
        metadata={"rack_file": filled(forgery.rack, known), "program_file": filled(forgery.program, known)},
    )
    for scan in range(3):
        recorder.scan(scan, scan * 2_000_000, 1)
    recorder.close()
    return own / "forged.mcap"


def filled(text: str | bytes, known: Mapping[str, object]) -> str:
    assert isinstance(text, str)
    for name, value in known.items():
        text = text.replace(f"{{{name}}}", str(value)).replace(f"{{{name}!r}}", repr(value))
    return text


def made(content: str | bytes, known: Mapping[str, object]) -> bytes:
    return compiled(known["canary"]) if content == COMPILED else filled(content, known).encode()


def compiled(canary: object) -> bytes:
    """Return compiled Python that is used whatever the source beside it says."""
    code = compile(EVIL.format(canary=str(canary)), "helper.py", "exec")
    return bytes(importlib._bootstrap_external._code_to_hash_pyc(code, bytes(8), checked=False))  # type: ignore[attr-defined]


def scanrack(*arguments: object) -> Result:
    return CliRunner().invoke(build(), [str(argument) for argument in arguments])


def golden(*arguments: object) -> Result:
    return CliRunner().invoke(golden_app, [str(argument) for argument in arguments])


def seen(folder: Path) -> dict[str, bytes | None]:
    """Return all files below a folder, and what is in them."""
    return {str(path): path.read_bytes() if path.is_file() else None for path in sorted(folder.rglob("*"))}


COMMANDS = {
    "rerun": ["replay", "--into", "session", "forged.mcap"],
    "replay": ["replay", "forged.mcap"],
    "replay into program": ["replay", "forged.mcap", "--into", "program"],
    "replay own program": ["replay", "forged.mcap", "--into", "program", "--program", "line.py"],
    "replay into rack": ["replay", "forged.mcap", "--into", "rack"],
    "fuzz": ["fuzz", "forged.mcap", "--runs", "1", "--jobs", "1", "--only", "link"],
    "why": ["why", "forged.mcap", "T"],
    "xref": ["xref", "forged.mcap"],
    "ladder": ["ladder", "forged.mcap"],
    "run": ["run", "forged.mcap"],
    "show": ["show", "forged.mcap"],
    "extract": ["show", "forged.mcap", "--extract", "../taken"],
}


@pytest.mark.slow
@pytest.mark.parametrize("name", FORGERIES)
def test_no_forgery_runs_code_or_leaves_its_folder(place: Path, name: str) -> None:
    forgery = FORGERIES[name]
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.setblocking(False)
        forge(place, forgery, server.getsockname()[1])
        before = seen(place.parent / "outside")
        for command, words in COMMANDS.items():
            path = list(sys.path)
            result = scanrack(*words)
            assert not (place.parent / "canary").exists(), f"{command} has run code"
            assert seen(place.parent / "outside") == before, f"{command} has written outside"
            assert SECRET not in result.output, command
            assert isinstance(result.exception, SystemExit | None), (command, result.exception)
            if command == "rerun" and forgery.says is not None:
                assert forgery.says in " ".join(result.stderr.split())
                assert result.exit_code == 2
                assert sys.path == path, "the trace is searched for modules"
            elif command == "rerun":
                assert result.exit_code in (0, 1), result.output
            elif command in ("why", "xref", "ladder", "run"):
                assert result.exit_code == 2, "these read no traces"
        with pytest.raises(BlockingIOError):
            server.accept()


def test_there_are_enough() -> None:
    assert len(FORGERIES) >= 50


@pytest.mark.parametrize("name", ["program e.py", "helper.pyc", "helper/__init__.pyc", "helper.py"])
def test_what_needs_trust_is_listed_and_runs_with_it(place: Path, name: str) -> None:
    """The forgeries are good ones: with --trust they run."""
    import hashlib

    forgery = FORGERIES[name]
    trace = forge(place, forgery)
    refused = scanrack("replay", "--into", "session", trace)
    listed = [line.split() for line in refused.stderr.splitlines()[1:-1]]
    assert [words[0] for words in listed] == [list(forgery.files)[-1]]
    file = place.parent / "taken" / listed[0][0]
    scanrack("show", trace, "--extract", place.parent / "taken")
    data = file.read_bytes()
    assert listed[0][1:] == [f"{len(data):,}", "bytes", "SHA-256", hashlib.sha256(data).hexdigest()]
    scanrack("replay", "--into", "session", trace, "--trust")
    assert (place.parent / "canary").exists()


def test_files_equal_to_the_users_own_need_no_trust(place: Path) -> None:
    files = {"rack.toml": rack(), "line.py": LINE, "helper.py": HELPER}
    forge(place, Forgery(files, "line.py:logic", None))
    result = scanrack("replay", "--into", "session", "forged.mcap")
    assert result.exit_code in (0, 1), result.output
    sys.modules.pop("helper", None)
    (place / "helper.py").write_text(HELPER + "\n", encoding="utf-8")
    assert TRUST in scanrack("replay", "--into", "session", "forged.mcap").stderr


def test_the_users_own_program_does_not_find_modules_of_the_trace(place: Path) -> None:
    """--program is the user's; the rack in TOML is the trace's, and nothing else of it is written out."""
    forge(place, beside("helper.pyc", COMPILED))
    result = scanrack("replay", "forged.mcap", "--into", "program", "--program", "line.py")
    assert result.exit_code in (0, 1), result.output
    assert not (place.parent / "canary").exists()


@pytest.mark.parametrize("name", ["sitecustomize.py", "helper.pyc"])
def test_a_process_of_its_own_runs_none_either(place: Path, name: str) -> None:
    forge(place, FORGERIES[name])
    command = [sys.executable, "-m", "scanrack", "fuzz", "forged.mcap", "--runs", "2", "-j", "2"]
    result = forked.run(command, capture_output=True, text=True, check=False, timeout=120, encoding="utf-8")
    assert result.returncode == 2, result.stderr
    assert not (place.parent / "canary").exists()


@pytest.mark.parametrize("links", ["a file", "nothing", "a folder"])
def test_extracting_follows_no_link(place: Path, links: str) -> None:
    outside = place.parent / "outside"
    names = {"a file": ("rack.toml", "secret"), "nothing": ("rack.toml", "new"), "a folder": ("sub", ".")}
    name, to = names[links]
    taken = place.parent / "taken"
    taken.mkdir()
    (taken / name).symlink_to(outside / to)
    forge(place, Forgery({"rack.toml": SECRET, "sub/e.py": EVIL}, "sub/e.py", None))
    before = seen(outside)
    result = scanrack("show", "forged.mcap", "--extract", taken)
    assert (result.exit_code, "is a symbolic link" in result.stderr) == (2, True)
    assert seen(outside) == before


def test_extracting_writes_nothing_if_one_name_is_refused(place: Path) -> None:
    forge(place, Forgery({"rack.toml": RACK, "../e.py": EVIL}, "e.py", None))
    result = scanrack("show", "forged.mcap", "--extract", place.parent / "taken")
    assert (result.exit_code, OUT in result.stderr) == (2, True)
    assert not (place.parent / "taken").exists()


@pytest.mark.parametrize("left", ["helper.pyc", "helper/__init__.pyc", "helper.so", "helper"])
def test_a_search_finds_no_module_that_was_left_in_its_folder(place: Path, left: str) -> None:
    forge(place, Forgery({"rack.toml": rack(), "line.py": LINE, "helper.py": HELPER}, "line.py", None))
    path = place / "forged-fuzz" / "recording" / left
    path.parent.mkdir(parents=True)
    (place / "forged-fuzz" / ".lock").touch()  # as an earlier campaign leaves it
    if path.suffix:
        path.write_bytes(compiled(place.parent / "canary"))
    else:
        path.symlink_to(place.parent / "outside")
    result = scanrack(*COMMANDS["fuzz"])
    assert (result.exit_code, "already exists" in result.stderr) == (2, True)
    assert not (place.parent / "canary").exists()


def test_compiled_python_that_was_left_in_its_folder_is_dropped(place: Path) -> None:
    forge(place, Forgery({"rack.toml": rack(), "line.py": LINE, "helper.py": HELPER}, "line.py", None))
    path = place / "forged-fuzz" / "recording" / PYC
    path.parent.mkdir(parents=True)
    (place / "forged-fuzz" / ".lock").touch()
    path.write_bytes(compiled(place.parent / "canary"))
    result = scanrack(*COMMANDS["fuzz"])
    assert result.exit_code in (0, 1), result.output
    assert not (place.parent / "canary").exists()


SCENARIO = """\
[start]
none = ""
[[scenario]]
name = "{name}"
group = "g"
says = "s"
start = "none"
steps = "zero"
run_ms = 40
rules = ["CER-01"]
bits = ["CONFIG_ERROR", "POSITION_INVALID"]
slot = '''{slot}'''
"""


@pytest.mark.parametrize("name", ["../outside/made", "a/../../outside/made", "x\\n", "/tmp/made"])
def test_a_golden_library_names_no_files_elsewhere(place: Path, name: str) -> None:
    (place / "scenarios.toml").write_text(SCENARIO.format(name=name, slot=""), encoding="utf-8")
    before = seen(place.parent)
    assert golden(place, "--update").exit_code == 2
    assert seen(place.parent) == before


@pytest.mark.parametrize(
    "path", ["{outside}/secret.pclt", "../outside/secret.pclt", "..\\outside\\secret.pclt"]
)
def test_a_golden_library_reads_no_files_elsewhere(place: Path, path: str) -> None:
    named = path.replace("{outside}", str(place.parent / "outside"))
    (place / "scenarios.toml").write_text(
        SCENARIO.format(name="made", slot=UNIT.format(path=named).replace("'", '"').replace("\\", "\\\\")),
        encoding="utf-8",
    )
    result = golden(place)
    assert (result.exit_code, OUT in result.stderr) == (2, True), result.output
    assert SECRET not in result.output


@pytest.mark.parametrize("name", ["made.mcap", "made.txt", "index.md"])
def test_a_golden_library_is_not_written_through_a_link(place: Path, name: str) -> None:
    library = place / "library"
    library.mkdir()
    (library / "scenarios.toml").write_text(SCENARIO.format(name="made", slot=""), encoding="utf-8")
    (library / name).symlink_to(place.parent / "outside" / "secret")
    golden(library, "--update")
    assert (place.parent / "outside" / "secret").read_text(encoding="utf-8") == SECRET
    assert not (library / name).is_symlink()


@pytest.mark.parametrize("name", ["e.py", "rack.toml"])
def test_a_recording_of_a_golden_library_is_compared_and_not_run(place: Path, name: str) -> None:
    (place / "scenarios.toml").write_text(SCENARIO.format(name="forged", slot=""), encoding="utf-8")
    forge(place, Forgery({"rack.toml": rack("e.py"), "e.py": EVIL}, name, None))
    (place / "forged.txt").write_text("", encoding="utf-8")
    assert golden(place).exit_code == 1
    assert not (place.parent / "canary").exists()
