"""`scanrack debug` with clients of others: every announced request and capability, forwards and backwards.

debug_requests.toml has the requests. Two clients make them, in each language, live and over a trace: the test
client of the protocol's makers, and the channel of debugpy.

Broken on purpose: a step back that stops as a pause, a request without a row, another capability: red.
"""

from __future__ import annotations

import json
import os
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from queue import Queue
from typing import Any, NamedTuple

import pytest
from scanrack.dap.requests import ALSO, REQUESTS, capabilities
from scanrack.jobs import load_job
from scanrack.jobs.run.running import JobRun, RunOptions

HOUSE = Path(__file__).parents[2]
EXAMPLES = HOUSE / "examples"
MISSING = 3
ADAPTER = "import sys\nfrom scanrack.__main__ import main\nsys.argv = ['scanrack', 'debug']\nmain()\n"
RECORDED = 5000

Json = dict[str, Any]
ROWS: list[Json] = tomllib.loads(Path(__file__).with_name("debug_requests.toml").read_text(encoding="utf-8"))[
    "row"
]


class Language(NamedTuple):
    """A program to debug.

    Attributes:
        source: text of the program, which the test writes; "" for an example.
        text: in the line of a breakpoint.
        condition: of that line, becomes true after some scans.
        tag, scope: a value that changes, and where it is shown.
        named: what the scope calls it.
        changes: a function breakpoint on it.
        completed: a name, of which two letters are completed.
    """

    rack: Path
    file: Path
    text: str
    tag: str
    source: str = ""
    condition: str = "scan > 3"
    scope: str = "Tags"
    named: str = ""
    changes: str = ""
    completed: str = ""


def written(file: str, source: str, text: str, tag: str, **more: Any) -> Language:
    """Return a program that the test writes."""
    return Language(Path("rack.toml"), Path(file), text, tag, source, **more)


RACK = """name = "table"
program = "{}"
scan_ms = 2
[[slot]]
number = 1
module = "{}"
"""
SEQUENCE = """from scanrack import Logic, dwell, sequence


class Table(Logic):
    number = 0

    @sequence
    async def cycle(self) -> None:
        while True:
            self.number += 1
            await dwell("4 ms")
"""
LADDER = """from scanrack import ADD, DINT, Controller

plant = Controller("plant")
number = plant.declare("Number", DINT)
main = plant.program("Main")


@main.routine
def Main(rung):
    rung(ADD(number, 1, number))
"""
FUNCTION = """class State:
    number: int = 0


state = State()


def logic(scan):
    state.number += 1
"""
TEST = """import pytest


@pytest.mark.rack("{}")
def test_rack(bench):
    bench.run_for("12 s")
"""
KINDS = ("live", "test", "trace")
WORD = "Local:1:O.Data[0]"
LANGUAGES: Mapping[str, Language] = {
    "rungs": Language(
        EXAMPLES / "feeder/feeder.toml", EXAMPLES / "feeder/feeder.rung", "OTE(Feeding)", "Feeding"
    ),
    "L5X": Language(
        EXAMPLES / "l5x/mixer.toml",
        EXAMPLES / "l5x/mixer.L5X",
        "OTE(Start",
        "Start",
        scope="Tags of MainProgram",
    ),
    "ladder in Python": written("table.py:plant", LADDER, "rung(ADD", "Number"),
    "structured text": written(
        "table.st", "TAG Number : DINT\nNumber := Number + 1;\n", "Number :=", "Number"
    ),
    "sequences": written("table.py", SEQUENCE, "self.number +=", "table.number", condition="self.number > 3"),
    "Python": written(
        "plain.py", FUNCTION, "state.number += 1", "state.number", condition="state.number > 3"
    ),
    "list of steps": written(
        "line.steps",
        "SLOT 1\n" + "".join(f"words {number % 7} for 6 ms\n" for number in range(40)),
        "words 0",
        WORD,
        scope="Outputs",
        named="slot 1",
        changes=f"{WORD} == 3",
        completed="release",
    ),
}
STEPS = "list of steps"


def line_of(file: Path, text: str) -> int:
    """Return the line of a text in a file."""
    source = file.read_text(encoding="utf-8")
    return source[: source.index(text)].count("\n") + 1


def placed(language: str, folder: Path) -> Language:
    """Return a program, written into a folder unless it is an example."""
    found = LANGUAGES[language]
    if not found.source:
        return found
    module = "amci3601" if language == STEPS else "1762-IQ8"
    program = found.file.name
    found = found._replace(rack=folder / found.rack, file=folder / program.partition(":")[0])
    found.file.write_text(found.source, encoding="utf-8")
    found.rack.write_text(RACK.format(program, module), encoding="utf-8")
    return found


FIXED = {
    "live": "no tags that can be set",
    "test": "the test does everything else",
    "trace": "this is a recording",
}
"""Why a value can't be set."""


def values_of(language: str, folder: Path, kind: str) -> Json:
    """Return what the names in the table stand for."""
    found = placed(language, folder)
    program = found.rack
    if kind == "trace":
        program = folder / "run.mcap"
        with ExitStack() as ports:
            JobRun(load_job(str(found.rack)), ports, RunOptions(trace=program)).run(RECORDED)
    line = line_of(found.file, found.text)
    lines = range(line, line + 40) if language == STEPS else [line]  # a step begins once

    def points(**more: str) -> list[Json]:
        return [{"line": each, **more} for each in lines]

    completed = found.completed or found.tag
    test = folder / "test_rack.py"
    test.write_text(TEST.format(found.rack.as_posix()), encoding="utf-8")
    return {
        "pytest": shlex.join(["-q", "-p", "no:cacheprovider", test.as_posix()]),
        "program": str(program),
        "file": str(found.file),
        "line": line,
        "lines": points(),
        "conditional": points(condition=found.condition),
        "counted": points(hitCondition=">= 1" if language == STEPS else ">= 2"),
        "logged": points(logMessage="logged {1 + 1}"),
        "later": "scan == 60",
        "tag": found.tag,
        "hover": f"{found.tag} = ",
        "unset": "is a module" if language == STEPS else FIXED[kind],
        "fixed": FIXED[kind],
        "scope_name": found.scope,
        "value": found.named or found.tag,
        "changes": found.changes or f"{found.tag} changes",
        "begun": completed[:2],
        "completed": completed,
    }


# --- the clients

Client = Callable[[Path, Sequence[Json], Json], list[Json]]
"""Makes the requests of rows; returns the answer to each: a body or the refusal, an event, output."""


def filled(given: Any, values: Json) -> Any:
    """Return something of a row with values in place of their names."""
    if isinstance(given, str) and given.startswith("$"):
        return values[given[1:]]
    if isinstance(given, dict):
        return {name: filled(each, values) for name, each in given.items()}
    return [filled(each, values) for each in given] if isinstance(given, list) else given


def at(body: Any, path: Sequence[Any]) -> Any:
    """Return what a path leads to; a LookupError if there is nothing."""
    for step in path:
        if isinstance(step, dict):
            some = body if isinstance(body, list) else [body]
            found = [each for each in some if all(each.get(key) == value for key, value in step.items())]
            if not found:
                raise LookupError(step)
            body = found[0]
        else:
            body = body[step]
    return body


def protocols_own(adapter: Path, rows: Sequence[Json], values: Json) -> list[Json]:
    """The test client of the protocol's makers."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    table = adapter.with_name("rows.json")
    table.write_text(json.dumps({"rows": rows, "values": values}), encoding="utf-8")
    words = [
        node,
        str(Path(__file__).with_name("debug_requests.cjs")),
        sys.executable,
        str(adapter),
        str(table),
    ]
    done = subprocess.run(words, capture_output=True, text=True, check=False, encoding="utf-8", timeout=120)
    if done.returncode == MISSING:
        pytest.skip("@vscode/debugadapter-testsupport is not installed where node finds it (NODE_PATH)")
    assert done.returncode == 0, done.stderr
    found: list[Json] = json.loads(done.stdout)
    return found


def debugpys(adapter: Path, rows: Sequence[Json], values: Json) -> list[Json]:
    """The channel of debugpy, which its own tests use."""
    from debugpy.common.messaging import JsonIOStream, JsonMessageChannel, MessageHandlingError

    events: Queue[tuple[str, Json]] = Queue()

    class Handlers:
        def event(self, event: Any) -> None:
            events.put((event.event, dict(event.body)))

        def disconnect(self) -> None:
            pass

    def awaited(name: str) -> tuple[Json, str]:
        printed = ""
        while (found := events.get(timeout=20))[0] != name:
            printed += found[1].get("output", "")
        return found[1], printed

    answers = []
    words = [sys.executable, str(adapter)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        try:
            channel = JsonMessageChannel(JsonIOStream.from_process(process), Handlers())
            channel.start()
            for row in rows:
                answer: Json = {"printed": ""}
                try:
                    answer["body"] = (
                        channel.request(row["request"], filled(row.get("arguments", {}), values)) or {}
                    )
                except MessageHandlingError as error:
                    answer["refused"] = str(error)
                if "awaits" in row:
                    answer["event"], answer["printed"] = awaited(row["awaits"])
                for name, path in row.get("keep", {}).items():
                    values[name] = at(answer["body"], filled(path, values))
                answers.append(answer)
            channel.close()
            assert process.wait(20) == 0
        finally:
            process.kill()  # after a failure; otherwise it has ended
    return answers


CLIENTS: Mapping[str, Client] = {"protocol's own": protocols_own, "debugpy": debugpys}


# --- the table


def test_every_request_and_capability_has_a_row() -> None:
    for kind in KINDS:
        rows = rows_of(kind, "rungs")
        assert set(REQUESTS) - {each["request"] for each in rows} <= ONE_END
    assert set(REQUESTS) == {each["request"] for each in ROWS}
    covered = {name for each in ROWS for name in each.get("covers", [])}
    assert covered == {name for name, value in capabilities().items() if value}
    text = json.dumps([each for each in ROWS if each["request"] == "setExceptionBreakpoints"])
    assert all(f'"{each["filter"]}"' in text for each in ALSO["exceptionBreakpointFilters"])


ONE_END = {"terminate", "disconnect"}


@pytest.fixture
def adapter(tmp_path: Path) -> Path:
    file = tmp_path / "adapter.py"
    file.write_text(ADAPTER, encoding="utf-8")
    return file


@pytest.mark.slow
@pytest.mark.parametrize("client", CLIENTS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("language", LANGUAGES)
def test_every_request_of_the_table(
    adapter: Path, tmp_path: Path, language: str, kind: str, client: str
) -> None:
    values = values_of(language, tmp_path, kind)
    rows = list(rows_of(kind, language))
    answers = CLIENTS[client](adapter, rows, values)
    assert len(answers) == len(rows)
    for number, (row, answer) in enumerate(zip(rows, answers, strict=True)):
        where = f"{number}: {row['request']}: {answer}"
        if "refused" in row:
            assert filled(row["refused"], values) in answer["refused"], where
            continue
        assert "refused" not in answer, where
        for path in row.get("has", []):
            try:
                at(answer["body"], filled(path, values))
            except LookupError as error:
                raise AssertionError(f"{where}: no {error}") from error
        assert filled(row.get("says", ""), values) in json.dumps(answer), where
        if "reason" in row:
            assert answer["event"]["reason"] in row["reason"], where


def rows_of(kind: str, language: str) -> Iterator[Json]:
    """Yield the rows of a kind of session in a language."""
    session = {kind, language}
    if kind == "test":
        session |= {"live", f"{language} in a test"}
    for each in ROWS:
        only, without = set(each.get("only", session)), set(each.get("without", ()))
        if only & session and not without & session:
            yield each


@pytest.mark.slow
def test_neovim_steps_forwards_and_backwards() -> None:
    """With nvim-dap, whose folder NVIM_DAP names; last run with Neovim 0.11.4 and nvim-dap 9e848e0."""
    nvim, plugin = shutil.which("nvim"), os.environ.get("NVIM_DAP")
    if nvim is None or plugin is None:
        pytest.skip("neovim is not installed, or NVIM_DAP does not name the folder of nvim-dap")
    rungs = LANGUAGES["rungs"]
    line = line_of(rungs.file, rungs.text)
    environment = {
        "DEBUG_PYTHON": sys.executable,
        "DEBUG_FILE": str(rungs.file),
        "DEBUG_LINE": str(line),
        "DEBUG_RACK": str(rungs.rack),
    }
    script = Path(__file__).with_name("debug_steps.lua")
    words = [nvim, "--headless", "-u", "NONE", "--cmd", f"set rtp+={plugin}", "-c", f"luafile {script}"]
    done = subprocess.run(
        words, capture_output=True, encoding="utf-8", env=os.environ | environment, timeout=120, check=False
    )
    rung = f"Main, rung 7|{line}"
    assert done.stdout.splitlines() == [
        "Main, rung 0|29",
        rung,
        "Main, rung 8|40",
        rung,
        rung,  # of the next scan
        rung,
        "0",
    ], done.stderr
