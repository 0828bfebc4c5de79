"""Scripted modules and listeners that keep a diary, for the tests of the scan loop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import pytest
from scanrack.io_images.amci3601 import WORDS_3601
from scanrack.io_images.image import Image
from scanrack.runtime import Card, Rack
from scanrack.runtime.loop.events import Event, JsonValue


class ScriptedModule:
    """Answers with word 0 = the time in ms, or as `script` says, and writes down what it is told."""

    def __init__(self, log: list[object] | None = None) -> None:
        self.events: list[Event] = []
        self.log: list[object] = [] if log is None else log
        self.updates: list[tuple[int, int]] = []
        self.script: Callable[[int], int] = lambda now_ns: now_ns // 1_000_000
        self._inputs = Image()

    def update(self, now_ns: int, outputs: Image) -> Image:
        self.log.append(("update", now_ns, outputs[0]))
        self.updates.append((now_ns, outputs[0]))
        self._inputs[0] = self.script(now_ns)
        return self._inputs

    def plc_run(self, running: bool) -> None:
        self.log.append(("plc_run", running))

    def power_cycle(self) -> None:
        self.log.append("power_cycle")


@dataclass
class Diary:
    """A listener that writes everything down."""

    memory: bytearray
    log: list[object] = field(default_factory=list)
    scans: list[tuple[int, int, int]] = field(default_factory=list)
    images: list[bytes] = field(default_factory=list)
    events: list[tuple[int, int, str, dict[str, JsonValue]]] = field(default_factory=list)
    closed: int = 0

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        self.log.append(("event", topic))
        self.events.append((scan, now_ns, topic, dict(fields)))

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        self.log.append(("scan", scan))
        self.scans.append((scan, now_ns, flags))
        self.images.append(bytes(self.memory))

    def close(self) -> None:
        self.log.append("close")
        self.closed += 1

    def word(self, scan: int, word: int = 0, *, inputs: bool = False) -> int:
        """Return a word of slot 1 as it was recorded at a place in the diary."""
        start = 16 * inputs + 2 * word
        return int.from_bytes(self.images[scan][start : start + 2], "little", signed=True)

    def topic(self, name: str) -> list[tuple[int, int, dict[str, JsonValue]]]:
        """Return (scan, time, fields) of all events of a topic."""
        return [(scan, at, fields) for scan, at, topic, fields in self.events if topic == name]


@pytest.fixture
def log() -> list[object]:
    """One diary for all that happens in a test, in order."""
    return []


@pytest.fixture
def module(log: list[object]) -> ScriptedModule:
    return ScriptedModule(log)


@pytest.fixture
def rack(module: ScriptedModule) -> Rack:
    """A rack with the scripted module in slot 1, said to be a 3601."""
    return Rack([Card(1, module, "amci3601", "4.1", WORDS_3601)])


@pytest.fixture
def diary(rack: Rack, log: list[object]) -> Diary:
    return Diary(rack.memory, log)


@pytest.fixture
def new_module() -> Callable[[], ScriptedModule]:
    return ScriptedModule


@pytest.fixture
def new_diary() -> Callable[[bytearray], Diary]:
    return Diary
