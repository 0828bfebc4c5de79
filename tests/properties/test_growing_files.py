"""Every file that a command takes, made by somebody else: work grows as the file does, not as its square.

What takes a file is asked of the commands, so that a new option or argument is met by name: it is read, and
`READ` says how, or it is nothing to read. A command runs in a process that is forked for it, which counts the
lines of Python that it executes and its memory, for files of two sizes that the limits allow. Bounds are
wide: eight times the file may take 16 times as much, where the square takes 64.

--long gives each kind of reader all that grows, see tests/support/large_files.py.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import pytest
import typer
from commands_page import commands
from costs import lines_executed, most_memory
from large_files import FILES, LARGEST
from scanrack.commands import build
from scanrack.traces.export.formats import FORMATS
from typer.testing import CliRunner

if not hasattr(os, "fork"):
    pytest.skip("a command runs in a process that is forked for it", allow_module_level=True)

SIZES = (1 << 11, 1 << 14)
LINEAR = 2.0  # how many times more than in proportion a larger file may take
LEAST_LINES, LEAST_BYTES = 60_000, 1 << 20
"""What only a larger file may begin, such as a search for frames, and what may differ for other reasons."""

RACKS = (".toml", ".py", ".L5X", ".SLC")
PROGRAMS = (".rung", ".st")
TRACE = (".mcap",)

READ: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "run rack": ("run {} --for 2ms --no-record -q", (*RACKS, ".unit", ".steps", *PROGRAMS)),
    "run --record": ("run good.toml --for 2ms -q --record {}", TRACE),
    "run --retain": ("run good.toml --for 2ms --no-record -q --retain {}", (".json",)),
    "watch rack": ("watch {} --time-scale max --for 2ms", RACKS),
    "watch rack, a trace": ("watch {} --port 0", (*TRACE, ".html")),
    "watch --record": ("watch good.toml --time-scale max --for 2ms --record {}", TRACE),
    "share trace": ("share {} --out shared.html", TRACE),
    "share --out": ("share good.mcap --out {}", (".html",)),
    "show trace": ("show {}", TRACE),
    "query trace": ("query {} Run", TRACE),
    "plot trace": ("plot {} --out plot.html", TRACE),
    "plot --out": ("plot good.mcap --out {}", (".html",)),
    "export trace": ("export {} --csv out.csv", TRACE),
    **{
        f"export {each.option}": (
            f"export good.mcap {each.option} {{}}",
            (".html",) if each.selects_signals else TRACE,
        )
        for each in FORMATS
    },
    "compare a": ("compare {} good.mcap", TRACE),
    "compare b": ("compare good.mcap {}", TRACE),
    "import capture": ("import {} --as pcl601 --rtu-over-tcp --out new.mcap", (".pcap", ".log")),
    "import --out": ("import missing.pcap --as pcl601 --out {}", TRACE),
    "import --simulated": ("import missing.pcap --as pcl601 --simulated {}", TRACE),
    "repair trace": ("repair {} --out repaired.mcap", TRACE),
    "repair --out": ("repair good.mcap --out {}", TRACE),
    "replay path": ("replay {}", TRACE),
    "replay --rack": ("replay good.mcap --into program --rack {}", RACKS),
    "replay --program": ("replay good.mcap --into program --program {}", (".py", *PROGRAMS)),
    "replay path, a session": ("replay --into session {}", TRACE),
    "replay --record": ("replay --into session good.mcap --record {}", TRACE),
    "ladder file": ("ladder {}", (".toml", ".py", *PROGRAMS)),
    "ladder --svg": ("ladder good.rung --svg {}", (".html",)),
    "l5x file": ("l5x {}", (".L5X", ".SLC")),
    "l5x --against": ("l5x good.L5X --against {}", (".L5X", ".SLC")),
    "l5x --html": ("l5x good.L5X --against good.L5X --html {}", (".html",)),
    "l5x --out": ("l5x missing.L5X --out {}", (".L5X",)),
    "why file": ("why {} Run --at 0", (*RACKS, *TRACE)),
    "xref file": ("xref {}", (".toml", ".py", *PROGRAMS)),
    "prove rack": ("prove {}", (*RACKS, *PROGRAMS)),
    "prove new": ("prove good.rung {}", (*RACKS, *PROGRAMS)),
    "prove --html": ("prove good.rung --html {}", (".html",)),
    "fuzz rack": ("fuzz {} --for 2ms --runs 1 --jobs 1", (*RACKS, *TRACE)),
    "fuzz --invariants": ("fuzz good.toml --for 2ms --runs 1 --jobs 1 --invariants {}", (".py",)),
    "fuzz --out": ("fuzz good.toml --for 2ms --runs 1 --jobs 1 --out {}", (".campaign",)),
    "fuzz --corpus": ("fuzz good.toml --for 2ms --runs 1 --jobs 1 --corpus {}", (".campaign", ".mcap")),
    "fuzz --scenario": ("fuzz good.toml --scenario {}", (".json",)),
    "conform plan": ("conform {} --list", (".plan",)),
    "conform --judge": ("conform --judge {}", (".json", ".mcap")),
    "conform --html": ("conform --judge missing.json --html {}", (".html",)),
    "conform --out": ("conform --judge missing.json --out {}", (".json",)),
    "tags rack": ("tags {}", (*RACKS, *PROGRAMS)),
    "serve rack": ("serve amci3601 {} --tcp 1.2.3.4.5:1", RACKS),
    "serve --machine": ("serve pcl601 --machine {} --serial missing", RACKS),
    "serve --program": ("serve pcl601 --program {} --serial missing", (".pclt",)),
    "serve --memory": ("serve pcl601 --memory {} --serial missing", (".json",)),
    "serve --record": ("serve pcl601 --record {} --serial missing", TRACE),
    "device pcl601 program write file": ("device pcl601 --tcp 127.0.0.1:1 program write {}", (".pclt",)),
    "device pmc006 program check file": ("device pmc006 program check {}", (".pmc",)),
    "device pmc006 program write file": ("device pmc006 --serial missing program write {}", (".pmc",)),
    "device pcl601 program list file": ("device pcl601 program list {}", (".pclt",)),
    "check files": ("check {}", (*RACKS, *PROGRAMS, ".pclt")),
}
"""Words with a file for {}, and the kinds of files, by command and option or argument."""

NOT_READ = {
    "new folder": "it has to be new or empty",
    "show --extract": "it is written, and has to be new or empty",
    "prove --out": "a folder for scenarios",
    "fuzz --write-tests": "a folder for tests",
    "run --opc-ua-users": "64 KiB of it, see tests/unit/live/test_ua_files.py",
    "watch --opc-ua-users": "64 KiB of it, see tests/unit/live/test_ua_files.py",
}
"""Paths of folders that nothing is read from."""

WORDS = {
    *(
        "TIME",
        "A:B",
        "TIME|SCAN",
        "PATTERN",
        "SIGNAL",
        "start|SIGNAL",
        "QUERY",
        "BIT",
        "VALUE",
        "[WHAT]",
        "[TAG]",
        "TAG",
        "WORDS",
        "SOFTWARE",
    ),
    *("NAME", "EXAMPLE", "TAGS", "KIND", "ID", "KEY", "VERSION", "MODULE", "PROGRAM[.ROUTINE]", "TARGET"),
    *(
        "PROTOCOL[:[HOST:]PORT]",
        "ADDRESS",
        "HOST[:PORT][,SLOT]",
        "[HOST:]PORT",
        "PORT",
        "DEVICE",
        "FACTOR",
        "TEXT",
        "N",
    ),
    *("TAG:MS", "INPUT=TAG", "NAME=STATE", "DIGITS", "FAULT", "DRIVE"),
}
"""What a text that names no file is called in the help of its command."""

OTHER_WORDS = {"new --from"}
"""Texts without a name of their own in the help."""

APPLICATION = build()


class Cost(NamedTuple):
    """What a command took for a file of one size."""

    size: int
    lines: int
    memory: int  # the most, bytes


def takes_text() -> Iterator[tuple[str, str | None]]:
    """Yield what may be a path: command and option or argument, and what the help calls it."""
    for words, command in commands(typer.main.get_command(build())):
        for each in command.params:
            if each.type_descriptor.annotation in (Path, str, list[Path], list[str]):
                name = each.opts[0] if each.param_type_name == "option" else each.name
                yield f"{words.removeprefix('scanrack ')} {name}", each.metavar


def test_each_option_and_argument_that_may_name_a_file_is_known() -> None:
    """A new one gets a row in READ, or is called in its help what names no file."""
    there = dict(takes_text())
    files = {each for each, name in there.items() if name not in WORDS and each not in OTHER_WORDS}
    assert files == {*(row.partition(",")[0] for row in READ), *NOT_READ}
    assert there.keys() >= OTHER_WORDS


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with a rack, its program and its recording, which is the current one."""
    place = tmp_path_factory.mktemp("growing")
    rack = 'program = "{}"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
    (place / "good.rung").write_text(
        "PROGRAM p\nTAG Run : BOOL\nROUTINE Main\nXIC(Run)OTE(Run);\nEND\n", encoding="utf-8"
    )
    (place / "good.toml").write_text(rack.format("good.rung"), encoding="utf-8")
    for suffix in (".rung", ".st", ".steps"):
        (place / f"rack{suffix}.toml").write_text(rack.format(f"file{suffix}"), encoding="utf-8")
    (place / "rack.unit.toml").write_text(
        f'{rack.format("good.rung")}[[unit]]\nprogram = "file.pclt"\n', encoding="utf-8"
    )
    (place / "good.L5X").write_bytes(FILES[".L5X"]["rungs"](1))
    before = Path.cwd()
    os.chdir(place)
    CliRunner().invoke(APPLICATION, ["run", "good.toml", "--for", "100ms", "-q", "--record", "good.mcap"])
    yield place
    os.chdir(before)


def given(row: str, kind: str) -> tuple[list[str], Path]:
    """Return the words of a command, and the file that grows."""
    words = READ[row][0]
    if kind == ".campaign":
        Path("campaign").mkdir(exist_ok=True)
        return words.format("campaign").split(), Path("campaign/state.json")
    if kind == ".unit":
        return words.format("rack.unit.toml").split(), Path("file.pclt")
    file = Path(f"file{kind}" if kind != ".plan" else "plan.toml")
    named = f"rack{kind}.toml" if row == "run rack" and Path(f"rack{kind}.toml").exists() else str(file)
    return words.format(named).split(), file


def costs(words: list[str], file: Path, make: Callable[[int], bytes]) -> list[Cost]:
    """Run a command with a small and a large file in a process of its own; return what each took."""
    file.write_bytes(make(1 << 10))
    CliRunner().invoke(APPLICATION, words)  # imports what it needs
    reader, writer = os.pipe()
    if not (child := os.fork()):
        try:
            os.write(writer, json.dumps(list(_measured(words, file, make))).encode())
        finally:
            os._exit(0)
    os.close(writer)
    with open(reader, "rb") as pipe:
        said = pipe.read()
    os.waitpid(child, 0)
    assert said, f"{' '.join(words)}: its process ended"
    return [Cost(*each) for each in json.loads(said)]


def _measured(words: list[str], file: Path, make: Callable[[int], bytes]) -> Iterator[Cost]:
    """Yield what each size takes."""
    for size in SIZES:
        file.write_bytes(make(size))
        lines = lines_executed(lambda: CliRunner().invoke(APPLICATION, words))
        file.write_bytes(make(size))
        memory = most_memory(lambda: CliRunner().invoke(APPLICATION, words))
        yield Cost(len(make(size)), lines, memory)


def check(what: str, taken: list[Cost]) -> None:
    """Compare what the large file took with what the small one did."""
    small, large = taken
    times = LINEAR * large.size / small.size
    assert large.lines <= times * small.lines + LEAST_LINES, (what, taken)
    assert large.memory <= times * small.memory + LEAST_BYTES, (what, taken)


@pytest.mark.slow
@pytest.mark.parametrize(("row", "kind"), [(row, kind) for row, (_, kinds) in READ.items() for kind in kinds])
def test_a_command_takes_as_much_as_its_file_is_large(place: Path, row: str, kind: str) -> None:
    words, file = given(row, kind)
    check(f"{' '.join(words)}: {LARGEST[kind]}", costs(words, file, FILES[kind][LARGEST[kind]]))


READERS = {kind: next(row for row, (_, kinds) in READ.items() if kind in kinds) for kind in FILES}


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind, texts in FILES.items() for name in texts])
def test_a_reader_does_too(place: Path, kind: str, name: str, request: pytest.FixtureRequest) -> None:
    if not request.config.getoption("--long"):
        pytest.skip("with --long")
    words, file = given(READERS[kind], kind)
    check(f"{' '.join(words)}: {name}", costs(words, file, FILES[kind][name]))
