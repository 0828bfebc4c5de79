"""The table of requests, and bad input: each mistake is answered with a sentence; the session continues."""

from __future__ import annotations

import json
import re
import socket
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import debugger_page
import pytest
from debug_client import SCHEMA, DebugClient, RefusedError, properties
from scanrack.dap.requests import ALSO, REQUESTS, capabilities
from scanrack.jobs import load_job
from scanrack.jobs.run.running import JobRun, RunOptions


def test_every_request_and_capability_is_one_of_the_protocol() -> None:
    known = properties({"$ref": "#/definitions/Capabilities"})
    assert set(capabilities()) <= set(known)
    for name in REQUESTS:
        assert f"{name[0].upper()}{name[1:]}Request" in SCHEMA["definitions"]


def test_a_capability_is_announced_only_with_its_request() -> None:
    """What no request stands for is an argument's, and named as such."""
    of_requests = {each.capability for each in REQUESTS.values()} - {""}
    for name, value in capabilities().items():
        assert name in of_requests or name in ALSO
        assert value is not None
    assert "supportsRestartFrame" not in capabilities()


def test_the_page_has_every_request() -> None:
    text = debugger_page.PAGE.read_text(encoding="utf-8")
    assert debugger_page.written(text) == text


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"Content-Length: 3\r\n\r\nabc", "is not JSON"),
        (b"Content-Length: 2\r\n\r\n[]", "must be an object"),
        (b"Content-Length: -1\r\n\r\n", "must be 0 to"),
        (b"Content-Length: 99999999\r\n\r\n", "must be 0 to"),
        (b"hello\r\n", "is not a header"),
        (b'Content-Length: 15\r\n\r\n{"type":"event"', "is not JSON"),
        (b'Content-Length: 10\r\n\r\n{"seq": 0}', "must be a request"),
    ],
)
def test_nonsense_is_answered_and_the_session_continues(client: DebugClient, data: bytes, says: str) -> None:
    client.send(data)
    message = client.receive()  # the protocol has no response to what is no request
    assert (message["event"], says in message["body"]["output"]) == ("output", True)
    assert client.ask("initialize", adapterID="x")["supportsStepBack"] is True


@pytest.mark.parametrize(
    ("command", "arguments", "says"),
    [
        ("fly", {}, "no request 'fly'"),
        ("threads", {}, "launch or attach first"),
        ("next", {"threadId": 1}, "launch or attach first"),
        ("launch", {}, "program None: must be a text"),
        ("launch", {"program": "missing.toml"}, "missing.toml"),
        ("launch", {"program": "rack.toml", "speeed": 1}, "no argument 'speeed'"),
        ("launch", {"program": "rack.toml", "page": 1}, "page 1: must be true or false"),
        ("attach", {"program": "missing.mcap"}, "no such file"),
    ],
)
def test_a_request_that_cannot_be_done_is_refused(
    client: DebugClient, command: str, arguments: dict[str, Any], says: str
) -> None:
    with pytest.raises(RefusedError, match=says):
        client.ask(command, **arguments)
    assert client.ask("initialize", adapterID="x")


def test_arguments_must_be_an_object(client: DebugClient) -> None:
    data = json.dumps({"seq": 1, "type": "request", "command": "launch", "arguments": [1]}).encode()
    client.send(b"Content-Length: %d\r\n\r\n%s" % (len(data), data))
    assert client.receive()["message"] == "launch: arguments must be an object"


@pytest.mark.slow
def test_requests_in_a_stop_that_mean_nothing_there(client: DebugClient) -> None:
    client.begin("examples/feeder/feeder.toml", speed="max")
    client.ask("configurationDone")
    client.stopped()
    for command, arguments, says in (
        ("scopes", {"frameId": 77}, "frame 77: no longer exists"),
        ("variables", {"variablesReference": 99}, "variables 99: no longer exist"),
        ("variables", {"variablesReference": "x"}, "must be a whole number"),
        ("next", {"threadId": 1, "granularity": "mile"}, "must be statement, line, instruction"),
        ("setBreakpoints", {"source": {}}, "path None: must be a text"),
        ("setBreakpoints", {"source": {"path": "x"}, "breakpoints": 4}, "must be a list of objects"),
        ("evaluate", {"expression": "Feeding +"}, "not a query expression"),
        ("evaluate", {"expression": "set Feeding", "context": "repl"}, "write TAG = VALUE"),
        ("setExpression", {"expression": "Nope", "value": "1"}, "no tag Nope"),
        ("setExpression", {"expression": "Feeding", "value": "red"}, "'red' is not a value"),
        ("setExpression", {"expression": "Feeding", "value": "5"}, "Feeding"),
        ("launch", {"program": "x"}, "disconnect first"),
        ("dataBreakpointInfo", {"name": 4}, "name 4: must be a text"),
    ):
        with pytest.raises(RefusedError, match=says):
            client.ask(command, **arguments)
    answers = client.ask(
        "setFunctionBreakpoints",
        breakpoints=[{"name": "Nope > 1"}, {"name": "Feeding", "hitCondition": "often"}, {"name": "Feeding"}],
    )["breakpoints"]
    assert [each["verified"] for each in answers] == [False, False, True]
    assert client.go("next")[0] == "step"


@pytest.mark.slow
def test_places_that_the_program_does_not_have(client: DebugClient, tmp_path: Path) -> None:
    rungs = Path("examples/feeder/feeder.rung").resolve()
    client.begin(rungs.with_suffix(".toml"), speed="max")
    client.ask("configurationDone")
    client.stopped()
    own, last = tmp_path / "other.rung", len(rungs.read_text(encoding="utf-8").splitlines())
    copy = tmp_path / rungs.name
    copy.write_text("another program", encoding="utf-8")
    for path, line, says in (
        (own, 1, "other.rung is not a file of the program, which has axis3601.rung, feeder.rung"),
        (copy, 1, "feeder.rung differs from the program that runs"),
        (rungs, last, f"feeder.rung, line {last}: no instruction from this line to the end"),
        (rungs, 0, ""),
    ):
        (answer,) = client.break_at(path, line)
        assert (answer["verified"], answer.get("message", "")) == (not says, says)
    frame = client.frames()[0]["id"]
    client.ask("scopes", frameId=frame)
    client.go("stepOut")
    client.go("stepIn", granularity="instruction")
    with pytest.raises(RefusedError, match="variables 1: no longer exist, since the program has continued"):
        client.ask("variables", variablesReference=1)
    client.ask("disconnect")
    client.event("terminated")


WRONG: list[Any] = [None, -1, 1 << 70, 0.5, True, "x", [7], {"x": 1}, [{}], [{"name": 7}]]
RIGHT: dict[str, dict[str, Any]] = {
    "setBreakpoints": {"source": {"path": "examples/feeder/feeder.rung"}, "breakpoints": [{"line": 40}]},
    "variables": {"variablesReference": 1},
    "setVariable": {"variablesReference": 1, "name": "Feeding", "value": "0"},
    "setExpression": {"expression": "Feeding", "value": "0"},
    "evaluate": {"expression": "Feeding"},
    "completions": {"text": "Fe", "column": 3},
    "dataBreakpointInfo": {"name": "Feeding"},
}
"""Arguments of which one at a time is wrong."""

MOVES = ("continue", "reverseContinue", "next", "stepIn", "stepOut", "stepBack")
ENDS = ("disconnect", "terminate", "pause", "configurationDone")


@pytest.mark.slow
def test_wrong_arguments_of_each_request_are_refused_with_a_sentence(client: DebugClient) -> None:
    """Each argument that the protocol has, with values of other types; no mistake of the adapter shows."""
    client.begin("examples/feeder/feeder.toml", speed="max")
    client.ask("configurationDone")
    client.stopped()
    mistake = re.compile(r"\b[A-Z]\w*(Error|Exception)\b")
    for command in [each for each in REQUESTS if each not in (*ENDS, "continue", "reverseContinue")]:
        kind = f"{command[0].upper()}{command[1:]}Arguments"
        named = properties({"$ref": f"#/definitions/{kind}"}) if kind in SCHEMA["definitions"] else {}
        for name in named:
            for value in WRONG:
                if command in ("variables", "setVariable"):
                    client.scope("Tags", client.frames()[0]["id"])
                right = RIGHT.get(command, {})
                answer = client.answer_to(client.tell(command, **{**right, name: value}))
                says = answer.get("message", "")
                assert answer["success"] or (says and not mistake.search(says)), (command, name, value, says)
                if answer["success"] and command in MOVES:
                    client.event("stopped")
    assert client.go("next")[0] == "step"


@pytest.mark.slow
def test_a_client_that_goes_ends_the_adapter() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "scanrack", "debug"],
        input=b"Content-Length: 50\r\n\r\n{",
        capture_output=True,
        timeout=60,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


@pytest.mark.slow
def test_a_port_requires_its_key() -> None:
    words = [sys.executable, "-m", "scanrack", "debug", "--port", "0"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, encoding="utf-8") as process:
        assert process.stdout is not None
        place, _, key = process.stdout.readline().strip().partition(" key ")
        host, _, port = place.partition(":")
        with socket.create_connection((host, int(port))) as wrong:
            wrong.sendall(b"key 0\r\n")
            assert wrong.recv(1) == b""
        with socket.create_connection((host, int(port))) as right:
            right.sendall(f"key {key}\n".encode())
            with right.makefile("wb") as requests, right.makefile("rb") as answers:
                client = DebugClient(requests, answers)
                assert client.ask("initialize", adapterID="x")["supportsStepBack"] is True
                client.ask("disconnect")
        assert process.wait(20) == 0


@pytest.mark.slow
@pytest.mark.parametrize("recorded", [False, True], ids=["live", "trace"])
def test_a_number_has_the_unit_that_the_page_shows(
    client: DebugClient, tmp_path: Path, *, recorded: bool
) -> None:
    """The panel of the feeder shows a position in steps and a time in ms; timers count ms."""
    program = Path("examples/feeder/feeder.toml")
    if recorded:
        with ExitStack() as ports:
            JobRun(load_job(str(program)), ports, RunOptions(trace=tmp_path / "run.mcap")).run(2)
        program = tmp_path / "run.mcap"
    client.begin(program)
    client.ask("configurationDone")
    client.stopped()
    for text, value in (
        ("Axis.Position > -4000 steps", "1"),
        ("-1 steps > Axis.Position", "0"),
        ("Quiet.PRE == 1000 ms and Quiet.PRE < 1.5 s", "1"),
        ("time >= 0 ms", "1"),
    ):
        assert client.value(text) == value, text
    for text, says in (
        ("Axis.Position > 40 mm", "40 mm: must be in steps"),
        ("Axis.Position > 2 s", "2 s: must be in steps"),
        ("Quiet.PRE > 3 steps", "3 steps: must be in ms"),
        ("Strokes.ACC > 5 mm", "5 mm: must have no unit, since the page shows no unit"),
        ("Axis.Position + 5 steps > 3", "compare a tag with 5 steps"),
        ("5 steps", "compare a tag with 5 steps"),
    ):
        with pytest.raises(RefusedError, match=says):
            client.value(text)
        (answer,) = client.ask("setFunctionBreakpoints", breakpoints=[{"name": text}])["breakpoints"]
        assert (answer["verified"], says in answer["message"]) == (False, True)
