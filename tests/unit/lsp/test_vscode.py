"""The extension of VS Code: what it names exists, its schema is ours, and its grammars color all."""

from __future__ import annotations

import json
import shutil
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from debug_client import DebugClient, connected
from scanrack.runtime.config.rack_schema import rack_schema

HOUSE = Path(__file__).parents[3]
FOLDER = HOUSE / "editors/vscode"
MISSING = 3
"""The status of the reader without its packages."""

READER = HOUSE / "tests/peers/read_colors.cjs"
PACKAGE = json.loads((FOLDER / "package.json").read_text("utf-8"))
PROJECT = tomllib.loads((HOUSE / "pyproject.toml").read_text("utf-8"))

STEPS = """\
SLOT 2
words 843Eh 003Fh 1      until MODE_CONFIG -CONFIG_ERROR  # configured
RELATIVE_MOVE target -10000 speed 5000 until MOVE_COMPLETE
idle for 20.5 ms
"""
BLOCK = """\
TAG Go : BOOL
TAG Delay : FBD_TIMER := {"PRE": 500}
Delay.TimerEnable := Go AND NOT axis.status.INPUT_ERROR;   (* both *)
IF Delay.DN THEN Level[0] [:=] 16#FF; END_IF;
"""


def colors(folder: Path, scope: str, *files: Path) -> list[tuple[int, str, str]]:
    """Return line, text and innermost scope of each token, as VS Code colors it."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    words = [node, str(READER), str(folder), scope, *map(str, files)]
    done = subprocess.run(words, capture_output=True, text=True, check=False, encoding="utf-8")
    if done.returncode == MISSING:
        pytest.skip(
            "vscode-textmate and vscode-oniguruma are not installed where node finds them (NODE_PATH)"
        )
    assert done.returncode == 0, done.stderr
    return [tuple(each) for each in json.loads(done.stdout)]


def paths(node: Any) -> list[str]:
    """Return every relative path in a description."""
    if isinstance(node, dict):
        return [path for each in node.values() for path in paths(each)]
    if isinstance(node, list):
        return [path for each in node for path in paths(each)]
    return [node] if isinstance(node, str) and node.startswith("./") else []


def test_what_the_description_names_is_there() -> None:
    assert [path for path in paths(PACKAGE) if not (FOLDER / path).is_file()] == []
    assert PACKAGE["version"] == PROJECT["project"]["version"]
    assert PACKAGE["contributes"]["configuration"]["properties"]["scanrack.command"]["default"][1:] == [
        "editor",
        "lsp",
    ]
    for each in PACKAGE["contributes"]["grammars"]:
        assert json.loads((FOLDER / each["path"]).read_text("utf-8"))["scopeName"] == each["scopeName"]


def test_its_schema_is_that_of_this_version() -> None:
    written = json.loads((FOLDER / "rack.schema.json").read_text("utf-8"))
    assert written == rack_schema(draft4=True), "python -m tests.tools.generate schema"


@pytest.mark.slow
def test_npm_packs_it() -> None:
    npm = shutil.which("npm")
    if npm is None:
        pytest.skip("npm is not installed")
    words = [npm, "pack", "--dry-run", "--json", "--offline"]
    done = subprocess.run(words, cwd=FOLDER, capture_output=True, text=True, check=True, encoding="utf-8")
    (packed,) = json.loads(done.stdout)
    names = {each["path"] for each in packed["files"]}
    assert {path.removeprefix("./") for path in paths(PACKAGE)} <= names


@pytest.mark.slow
def test_rungs_have_colors() -> None:
    program = HOUSE / "examples/feeder/feeder.rung"
    chart = HOUSE / "examples/l5x/palletizer.rung"
    found = colors(FOLDER / "syntaxes", "source.rung", program, chart)
    bare = [text for _, text, scope in found if scope in ("source.rung", "meta.embedded.st.rung")]
    assert bare == []
    first = {text: scope for _, text, scope in reversed(found)}
    assert first["XIC"] == "keyword.other.contact.rung"
    assert first["OTE"] == "keyword.other.coil.rung"
    assert first["TON"] == "support.function.instruction.rung"
    assert first["ROUTINE"] == "keyword.control.rung"
    assert first["Strokes"] == "variable.other.declaration.rung"
    assert first["16#843C"] == "constant.numeric.rung"
    assert first["Configure.Done"] == "variable.other.rung"


@pytest.mark.slow
def test_steps_and_structured_text_have_colors(tmp_path: Path) -> None:
    steps, block = tmp_path / "a.steps", tmp_path / "b.st"
    steps.write_text(STEPS, encoding="utf-8")
    block.write_text(BLOCK, encoding="utf-8")
    found = colors(FOLDER / "syntaxes", "source.steps", steps)
    assert [text for _, text, scope in found if scope == "source.steps"] == []
    first = {text: scope for _, text, scope in reversed(found)}
    assert first["843Eh"] == "constant.numeric.hex.steps"
    assert first["MODE_CONFIG"] == first["RELATIVE_MOVE"] == "constant.other.bit.steps"
    assert first["-10000"] == first["20.5"] == "constant.numeric.steps"
    assert first["target"] == "variable.parameter.steps"
    assert first["until"] == "keyword.control.steps"
    assert first["# configured"] == "comment.line.number-sign.steps"
    found = colors(FOLDER / "syntaxes", "source.rung.st", block)
    assert [text for _, text, scope in found if scope == "source.rung.st"] == []
    first = {text: scope for _, text, scope in reversed(found)}
    assert first["IF"] == "keyword.control.rung"
    assert first["AND"] == "keyword.operator.word.rung"
    assert first["[:=]"] == "keyword.operator.rung"
    assert first["FBD_TIMER"] == "entity.name.type.rung"


def extension_with(program: Path, line: int) -> Any:
    """Return what the extension does with a program that stands at a line."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    script = HOUSE / "tests/peers/vscode_extension.cjs"
    words = [node, str(script), str(FOLDER / "extension.js"), str(program), str(line - 1)]
    done = subprocess.run(words, capture_output=True, text=True, check=False, encoding="utf-8", timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture
def client() -> Iterator[DebugClient]:
    with connected() as found:
        yield found


@pytest.mark.slow
def test_values_in_the_lines_are_those_of_the_stop(client: DebugClient) -> None:
    """Each name that the extension finds is a tag; its value is what a watch shows."""
    program = HOUSE / "examples/feeder/feeder.rung"
    client.begin(program.with_suffix(".toml"), speed="max")
    client.ask("configurationDone")
    client.stopped()
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "Feeding changes"}])
    client.go()
    stop = client.frames()[0]
    lines = program.read_text(encoding="utf-8").splitlines()
    shown = extension_with(program, stop["line"])["shown"]
    rungs = [each for each in shown if lines[each[0]].endswith(";") and "(" in lines[each[0]]]
    assert {line for line, _column, _name in shown} <= set(range(stop["line"]))
    assert [name for line, _column, name in rungs if line == stop["line"] - 1]
    for line, column, name in rungs:
        assert lines[line][column:].startswith(name)
        found = client.ask("evaluate", expression=name, context="watch", frameId=stop["id"])
        assert found["result"]


@pytest.mark.slow
def test_a_saved_program_is_tested_by_a_button() -> None:
    found = extension_with(HOUSE / "examples/feeder/feeder.rung", 1)
    evaluated = [["evaluate", {"expression": each, "context": "repl"}] for each in ("test", "accept")]
    assert found["requests"] == evaluated
    assert [each[-1] for each in found["contexts"]] == [True, True, True, False]
    assert sorted(found["commands"]) == sorted(each["command"] for each in PACKAGE["contributes"]["commands"])
