"""An editor for tests of `scanrack debug`; it checks every message against the protocol's schema.

`debug_adapter_protocol.json` is that schema (microsoft/debug-adapter-protocol, e34479c), without its texts.
"""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import IO, Any

from jsonschema import Draft4Validator
from scanrack.dap.adapter import Adapter
from scanrack.dap.requests import REQUESTS
from scanrack.dap.wire import Wire

Json = dict[str, Any]
SCHEMA = json.loads(Path(__file__).with_name("debug_adapter_protocol.json").read_text("utf-8"))


@cache
def validator(kind: str) -> Draft4Validator:
    return Draft4Validator({"$ref": f"#/definitions/{kind}", "definitions": SCHEMA["definitions"]})


def kind_of(message: Json) -> str:
    """Return the definition of a message."""
    if message["type"] == "event":
        name = message["event"]
    elif not message["success"]:
        return "ErrorResponse"
    else:
        name = message["command"]
    return f"{name[0].upper()}{name[1:]}{message['type'].capitalize()}"


def check(message: Json) -> None:
    """Check a message of the adapter: against its definition, and that the definition knows all its keys."""
    kind = kind_of(message)
    validator(kind).validate(message)
    known = properties({"$ref": f"#/definitions/{kind}"})
    unknown_keys(known, message, kind)


def properties(schema: Json) -> Json:
    """Return the properties that a schema names, those of its parts included."""
    if "$ref" in schema:
        return properties(SCHEMA["definitions"][schema["$ref"].rpartition("/")[2]])
    found: Json = {}
    for each in schema.get("allOf", []):
        found |= properties(each)
    return found | schema.get("properties", {})


def unknown_keys(known: Json, value: Json, place: str) -> None:
    for key, inner in value.items():
        assert key in known, f"{place} has no {key}"
        schema = known[key]
        inside = properties(schema.get("items", schema))
        if inside:
            for each in inner if isinstance(inner, list) else [inner]:
                unknown_keys(inside, each, f"{place}.{key}")


class RefusedError(AssertionError):
    """A request that the adapter refused."""


class DebugClient:
    """An editor."""

    def __init__(self, told: IO[bytes], asked: IO[bytes]) -> None:
        self._told, self._asked, self._number = told, asked, 0
        self.events: list[Json] = []  # that no test has waited for yet
        self.skipped: list[Json] = []  # earlier than one that was waited for

    def send(self, data: bytes) -> None:
        self._told.write(data)
        self._told.flush()

    def tell(self, command: str, **arguments: Any) -> int:
        (number,) = self.tell_all((command, arguments))
        return number

    def tell_all(self, *requests: tuple[str, Json]) -> list[int]:
        """Send requests at once; return their numbers."""
        sent = b""
        for command, arguments in requests:
            self._number += 1
            message: Json = {"seq": self._number, "type": "request", "command": command}
            if arguments:
                message["arguments"] = arguments
            data = json.dumps(message).encode()
            sent += b"Content-Length: %d\r\n\r\n%s" % (len(data), data)
        self.send(sent)
        return list(range(self._number - len(requests) + 1, self._number + 1))

    def receive(self) -> Json:
        size = 0
        while line := self._asked.readline().strip():
            size = int(line.partition(b":")[2])
        assert size, "the adapter has ended"
        found: Json = json.loads(self._asked.read(size))
        check(found)
        return found

    def answer_to(self, number: int) -> Json:
        while (message := self.receive())["type"] == "event" or message["request_seq"] != number:
            self.events.append(message)
        return message

    def ask(self, command: str, **arguments: Any) -> Json:
        message = self.answer_to(self.tell(command, **arguments))
        if not message["success"]:
            raise RefusedError(message["message"])
        body: Json = message.get("body", {})
        return body

    def event(self, name: str) -> Json:
        """Wait for an event; earlier ones are skipped."""
        while True:
            for place, each in enumerate(self.events):
                if each.get("event") == name:
                    self.skipped += self.events[:place]
                    del self.events[: place + 1]
                    body: Json = each["body"]
                    return body
            over = [each for each in self.events if each["event"] == "terminated"]
            assert name == "terminated" or not over, self.events
            self.events.append(self.receive())

    # --- what tests ask most

    def begin(self, program: Path | str, **more: Any) -> None:
        self.ask("initialize", adapterID="scanrack")
        self.ask("launch", program=str(program), **more)
        self.event("initialized")

    def go(self, command: str = "continue", **more: Any) -> tuple[str, int]:
        """Move; return the reason of the stop, and its scan."""
        self.ask(command, threadId=1, **more)
        return self.stopped()

    def stopped(self) -> tuple[str, int]:
        return self.event("stopped")["reason"], self.scan()

    def frames(self) -> list[Json]:
        found: list[Json] = self.ask("stackTrace", threadId=1)["stackFrames"]
        return found

    def scan(self) -> int:
        words = self.frames()[-1]["name"].replace(",", "").split()
        return int(words[words.index("scan") + 1])

    def at(self) -> str:
        return str(self.frames()[0]["name"])

    def break_at(self, path: Path, *lines: int, **more: Any) -> list[Json]:
        wanted = [{"line": line, **more} for line in lines]
        found: list[Json] = self.ask("setBreakpoints", source={"path": str(path)}, breakpoints=wanted)[
            "breakpoints"
        ]
        return found

    def value(self, expression: str, **more: Any) -> str:
        return str(self.ask("evaluate", expression=expression, **more)["result"])

    def scope(self, name: str, frame: int = 1) -> dict[str, Json]:
        scopes = self.ask("scopes", frameId=frame)["scopes"]
        (found,) = [each for each in scopes if each["name"] == name]
        return self.opened(found["variablesReference"])

    def opened(self, reference: int, **more: Any) -> dict[str, Json]:
        found = self.ask("variables", variablesReference=reference, **more)["variables"]
        return {each["name"]: each for each in found}


@contextmanager
def connected() -> Iterator[DebugClient]:
    """Connect an editor to an adapter in a thread of this process."""
    to_read, to_write = os.pipe()
    from_read, from_write = os.pipe()
    with os.fdopen(to_read, "rb") as requests, os.fdopen(from_write, "wb") as answers:
        thread = threading.Thread(target=Adapter(Wire(requests, answers), REQUESTS).run, name="adapter")
        thread.start()
        with os.fdopen(to_write, "wb") as told, os.fdopen(from_read, "rb") as asked:
            client = DebugClient(told, asked)
            try:
                yield client
            finally:
                client.tell("disconnect")
                thread.join(20)
                assert not thread.is_alive(), "the adapter has not ended"
