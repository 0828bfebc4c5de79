"""`scanrack editor lsp` over its pipes: mistakes of unsaved texts, meaning, completion, declarations."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import pytest

pytest.importorskip("pygls", reason="the extra editor is not installed")

from scanrack.jobs.trust import launcher
from scanrack.lsp.server import make_server

pytestmark = [
    pytest.mark.extra("editor"),
    # of pygls 2.1 on Python 3.14
    pytest.mark.filterwarnings("ignore:'asyncio.iscoroutinefunction' is deprecated:DeprecationWarning"),
]

EXAMPLES = Path(__file__).parents[3] / "examples"


class Client:
    """An editor: it writes messages and reads until the one that it waits for."""

    def __init__(self, to_server: IO[bytes], from_server: IO[bytes]) -> None:
        self._to, self._from, self._number = to_server, from_server, 0
        self.versions: dict[Path, int] = {}

    def _send(self, **message: Any) -> None:
        data = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self._to.write(b"Content-Length: %d\r\n\r\n%s" % (len(data), data))
        self._to.flush()

    def _receive(self) -> dict[str, Any]:
        length = 0
        while line := self._from.readline().strip():
            name, _, value = line.partition(b":")
            length = int(value) if name.lower() == b"content-length" else length
        assert length, "the server has ended"
        found: dict[str, Any] = json.loads(self._from.read(length))
        return found

    def tell(self, method: str, **params: Any) -> None:
        self._send(method=method, params=params)

    def ask(self, method: str, **params: Any) -> Any:
        self._number += 1
        self._send(id=self._number, method=method, params=params)
        while (answer := self._receive()).get("id") != self._number:
            pass
        assert "error" not in answer, answer["error"]
        return answer["result"]

    def begin(self, *, trusted: bool) -> None:
        options = {"trusted": trusted}
        self.ask("initialize", processId=None, rootUri=None, capabilities={}, initializationOptions=options)
        self.tell("initialized")

    def end(self) -> None:
        self.ask("shutdown")
        self.tell("exit")

    def show(self, file: Path, text: str | None = None) -> list[tuple[int, str, str]]:
        """Open a file, or change its text; return line, rule and text of what is marked in it."""
        text = file.read_text("utf-8") if text is None else text
        version = self.versions.get(file, 0) + 1
        self.versions[file] = version
        one = {"uri": file.as_uri(), "version": version}
        if version == 1:
            self.tell("textDocument/didOpen", textDocument={**one, "languageId": "", "text": text})
        else:
            self.tell("textDocument/didChange", textDocument=one, contentChanges=[{"text": text}])
        return self.marked(file, version)

    def marked(self, file: Path, version: int | None) -> list[tuple[int, str, str]]:
        """Wait for the marks of a version of a file; None for a file that is not open."""
        while True:
            said = self._receive()
            told = said.get("params", {})
            if told.get("uri") == file.as_uri() and told.get("version") == version:
                return [
                    (each["range"]["start"]["line"] + 1, each["code"], each["message"])
                    for each in told["diagnostics"]
                ]

    def at(self, method: str, file: Path, text: str, before: str) -> Any:
        """Ask about the place behind a piece of the text."""
        above = text[: text.index(before) + len(before)]
        line, column = above.count("\n"), len(above.rpartition("\n")[2])
        place = {"line": line, "character": column}
        return self.ask(f"textDocument/{method}", textDocument={"uri": file.as_uri()}, position=place)

    def offered(self, file: Path, text: str, before: str) -> dict[str, dict[str, Any]]:
        items = self.at("completion", file, text, before)["items"]
        return {each["label"]: each for each in items}


def connected(*, trusted: bool) -> Iterator[Client]:
    """Yield a client of a server in a thread of this process."""
    to_read, to_write = os.pipe()
    from_read, from_write = os.pipe()
    streams = os.fdopen(to_read, "rb"), os.fdopen(from_write, "wb")
    thread = threading.Thread(target=make_server().start_io, args=streams)
    thread.start()
    with os.fdopen(to_write, "wb") as to_server, os.fdopen(from_read, "rb") as from_server:
        client = Client(to_server, from_server)
        client.begin(trusted=trusted)
        yield client
        client.end()
        thread.join()
    for each in streams:
        each.close()


@pytest.fixture
def client() -> Iterator[Client]:
    yield from connected(trusted=False)


@pytest.fixture
def trusting() -> Iterator[Client]:
    yield from connected(trusted=True)


@pytest.fixture
def feeder(tmp_path: Path) -> Path:
    for name in ("feeder.rung", "feeder.toml"):
        shutil.copy(EXAMPLES / "feeder" / name, tmp_path)
    return tmp_path / "feeder.rung"


def line_of(text: str, part: str) -> int:
    return text[: text.index(part)].count("\n") + 1


def test_mistakes_of_unsaved_rungs_are_at_their_lines(client: Client, feeder: Path) -> None:
    text = feeder.read_text(encoding="utf-8")
    assert client.show(feeder) == []
    wrong = text.replace("XIC(Feeding)XIO(OutGo)OTE", "XIC(Feeding)XIO(OutGoo)OTE")
    ((line, rule, said),) = client.show(feeder, wrong)
    assert (line, rule) == (line_of(wrong, "OutGoo"), "read")
    assert "did you mean OutGo?" in said
    ((line, rule, said),) = client.show(feeder, text.replace("TAG Awake", "TAG Spare : DINT\nTAG Awake"))
    assert (line, rule) == (line_of(text, "TAG Awake"), "unused-tag")
    assert client.show(feeder, text) == []
    assert feeder.read_text(encoding="utf-8") == text


def test_a_rack_file_has_all_its_mistakes_and_is_checked_with_an_unsaved_program(
    client: Client, feeder: Path
) -> None:
    rack = feeder.with_suffix(".toml")
    text = rack.read_text(encoding="utf-8")
    wrong = text.replace('"home"', '"hme"').replace("scan_ms = 2", "scan_ms = -2")
    assert [line for line, _, _ in client.show(rack, wrong)] == [
        line_of(wrong, "scan_ms"),
        line_of(wrong, '"hme"'),
    ]
    assert client.show(rack, text) == []
    client.show(
        feeder, feeder.read_text(encoding="utf-8").replace("TAG Awake", "TAG Spare : DINT\nTAG Awake")
    )
    client.tell("textDocument/didSave", textDocument={"uri": rack.as_uri()})
    assert client.marked(rack, client.versions[rack]) == []  # its remark stands in the other file


def test_steps_structured_text_and_python_are_read(client: Client, tmp_path: Path) -> None:
    steps, block, program = (tmp_path / name for name in ("a.steps", "b.st", "c.py"))
    ((line, _, said),) = client.show(steps, "zero for 4 ms\nHOLD_MOVEE\n")
    assert line == 2
    assert "HOLD_MOVEE" in said
    ((line, _, said),) = client.show(block, "TAG a : DINT\na := 1 + ;\n")
    assert line == 2
    ((line, _, said),) = client.show(program, "def logic(scan):\n    if scan\n")
    assert line == 2


def test_test_routines_are_built_with_the_program_of_their_rack(client: Client, feeder: Path) -> None:
    tests = feeder.with_name("test_feeder.rung")
    text = "TEST feeder.toml\nROUTINE test_a\nXIC(Out.Done)ASSERT(Homing);\nEND\n"
    assert client.show(tests, text) == []
    ((line, rule, said),) = client.show(tests, text.replace("ASSERT(Homing)", "ASSERT(Hoping)"))
    assert (line, rule) == (3, "read")
    assert "no tag Hoping" in said
    ((line, _, said),) = client.show(tests, "\nTEST feeder.toml\nTAG A : BOOL\n")
    assert (line, said) == (2, "no routine with a name that begins with test_")


PYTHON = """\
from pathlib import Path

print("hello")
Path(__file__).with_name("ran").touch()

def logic(scan): ...
"""
RACK = 'program = "line.py"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'


def test_opening_a_file_of_a_stranger_runs_nothing(client: Client, tmp_path: Path) -> None:
    for name, text in {
        "line.py": PYTHON,
        "line.toml": RACK,
        "rungs.toml": RACK.replace("line.py", "line.rung") + '[stubs]\nXRP = "line.py:xrp"\n',
        "line.rung": "PROGRAM a\nTAG Go : BOOL\nROUTINE Main\nXIC(Go)OTE(Go);\nEND\n",
        "racked.py": f"{PYTHON}\ndef rack(): ...\n",
    }.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    for each in sorted(tmp_path.iterdir()):
        client.show(each)
    assert not (tmp_path / "ran").exists()


@pytest.mark.slow
def test_a_trusted_folder_runs_its_program_in_a_process_of_its_own(
    trusting: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(launcher, "subprocess", subprocess)  # a thread of a forked process has no others
    program, rack = tmp_path / "line.py", tmp_path / "line.toml"
    rack.write_text(RACK, encoding="utf-8")
    program.write_text("raise SystemError('saved')\n", encoding="utf-8")
    ((line, _, said),) = trusting.show(program, PYTHON + "\nsays = 1 / 0\n")
    assert (tmp_path / "ran").exists()
    assert "division by zero" in said
    assert line == PYTHON.count("\n") + 2


def test_what_an_instruction_and_a_tag_mean(client: Client, feeder: Path) -> None:
    text = feeder.read_text(encoding="utf-8")
    client.show(feeder)
    said = client.at("hover", feeder, text, "IN_ESTOP)TO")["contents"]["value"]
    assert "TON(Timer, Preset, Accum)" in said
    assert "acts on a true and on a false rung" in said
    said = client.at("hover", feeder, text, "IN_ESTOP)TON(Qui")["contents"]["value"]
    assert "TAG Quiet : TIMER" in said
    assert client.at("hover", feeder, text, "IN_ESTOP)TON(Quiet,10") is None


def test_completion_of_rungs_offers_instructions_tags_and_members(client: Client, feeder: Path) -> None:
    text = feeder.read_text(encoding="utf-8") + "XIC("
    client.show(feeder, text)
    offered = client.offered(feeder, text, "END\nXIC(")
    assert offered["OutGo"]["detail"] == "BOOL"
    assert offered["TON"]["detail"] == "TON(Timer, Preset, Accum)"
    assert "ESTRC" not in offered
    members = client.offered(feeder, text, "Quiet.")
    assert {"PRE", "ACC", "DN"} <= members.keys()
    assert "TON" not in members


def test_completion_of_a_rack_file_offers_keys_and_values(client: Client, feeder: Path) -> None:
    rack = feeder.with_suffix(".toml")
    text = rack.read_text(encoding="utf-8")
    client.show(rack)
    assert client.offered(rack, text, "run_for_s = 20\n").keys() >= {"scan_ms", "slot", "axes"}
    assert client.offered(rack, text, 'module = "').keys() >= {'"amci3601"', '"1762-IQ16"'}
    assert client.offered(rack, text, "switches = [\n    { ").keys() == {
        "input",
        "first",
        "last",
        "normally_closed",
    }
    assert '"home"' in client.offered(rack, text, "switches = [\n    { input = ")
    said = client.at("hover", rack, text, "scan_m")["contents"]["value"]
    assert said.startswith("**scan_ms**: time from one scan to the next")
    assert "0.01 to 1000; 2 if left out" in said


def test_a_declaration_is_found_in_units_of_the_protocol(client: Client, tmp_path: Path) -> None:
    program = tmp_path / "a.rung"
    text = "PROGRAM a\nTAG Go : BOOL // 𝄞\nROUTINE Main\n// 𝄞𝄞\nXIC(Go)OTE(Go);\nEND\n"
    client.show(program, text)
    found = client.at("definition", program, text, "XIC(Go)OTE(G")
    assert found["range"] == {"start": {"line": 1, "character": 4}, "end": {"line": 1, "character": 6}}
    assert client.at("definition", program, text, "XI") is None


@pytest.mark.slow
def test_the_command_serves_standard_input_and_output(feeder: Path) -> None:
    words = [sys.executable, "-m", "scanrack", "editor", "lsp"]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as server:
        assert server.stdin is not None
        assert server.stdout is not None
        client = Client(server.stdin, server.stdout)
        client.begin(trusted=False)
        assert client.show(feeder) == []
        client.end()
        assert server.wait() == 0
