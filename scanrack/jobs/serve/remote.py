"""Serves a 3601 as remote I/O: its rack runs in real time, and an external PLC acts as the program.

    external PLC --Modbus TCP--> eight words --each scan--> module, machine
                 <-------------- eight words <------------

Between two scans, the port answers at once with the words of the latest scan. The CPU is in program mode
until the first write, and again if no write arrives for a time. The module then sees that the PLC has left
run mode.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from scanrack.io_images.image import signed_word
from scanrack.io_images.module_words import ModuleWords
from scanrack.io_images.times import exact_ns
from scanrack.runtime.line.ports import ModbusTcpPort
from scanrack.runtime.line.remote_words import RemoteWords
from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.events import Event
from scanrack.runtime.loop.listeners import QuietListener
from scanrack.runtime.loop.pace import RealTime
from scanrack.runtime.loop.scan import CpuMode, LogicScan
from typing_extensions import override

from ..load.loading import LoadedRack, load_rack

CATALOG = "amci3601"
SILENCE_MS = 500.0
SILENCE_MS_MAX = 3_600_000
BARE_RACK = """name = "remote-io"
program = "remote.py"

[[slot]]
number = 1
module = "amci3601"
"""


class ExternalPlc(QuietListener):
    """The program of a rack for an external PLC, and a listener of the rack's scans.

    Attributes:
        slot: number of the module's slot.
        words: the words that the PLC writes and reads.
        silences: number of times that run mode ended because the PLC wrote nothing.

    Args:
        slot: number of the module's slot.
        words: words of the module.
        silence_ns: time without a write after which the CPU leaves run mode, ns.
        whole: whether to refuse writes of fewer words than the module has.
    """

    def __init__(self, slot: int, words: ModuleWords, silence_ns: int, *, whole: bool = False) -> None:
        self.slot, self._silence_ns = slot, silence_ns
        self._now_ns = 0
        self._torn_reported = 0  # torn writes that have been announced
        self._inputs: tuple[int, ...] = (0,) * len(words.inputs)
        self.words = RemoteWords(lambda: self._inputs, len(words.outputs), whole=whole)
        self.silences = 0

    cpu: Cpu
    """The CPU on which it runs; set by `attach`."""

    def attach(self, cpu: Cpu) -> None:
        """Run on a CPU, which is in program mode until the first write."""
        self.cpu = cpu
        cpu.mode = CpuMode.PROGRAM

    def __call__(self, scan: LogicScan) -> None:
        """Copy the words that the PLC last wrote to the output image, all at once."""
        outputs = scan.slot[self.slot].outputs
        for word_index, word in enumerate(self.words.outputs):
            outputs[word_index] = signed_word(word)

    def answer(self, pdu: bytes) -> bytes:
        """Return the reply to a Modbus request between two scans; a write puts the CPU in run mode."""
        reply = self.words.answer(self._now_ns, pdu)
        if self.words.heard_ns == self._now_ns and self.cpu.mode is not CpuMode.RUN:
            self.cpu.mode = CpuMode.RUN
        return reply

    @override
    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Store the scan's input words; leave run mode if the PLC is silent.

        Announce silences and torn writes.
        """
        self._now_ns = now_ns
        self._inputs = tuple(word & 0xFFFF for word in self.cpu.rack.slots[self.slot].inputs)
        heard_ns = self.words.heard_ns
        if self.cpu.mode is CpuMode.RUN and heard_ns is not None and now_ns - heard_ns > self._silence_ns:
            self.cpu.mode = CpuMode.PROGRAM
            self.silences += 1
            after_ms = (now_ns - heard_ns) // 1_000_000
            self._announce("silence", f"the PLC has written nothing for {after_ms:,} ms: run mode ends")
        if self.words.torn != self._torn_reported:
            self._torn_reported = self.words.torn
            text = f"writes of fewer than {len(self.words.outputs)} words so far: {self._torn_reported:,}"
            self._announce("torn write", text)

    def _announce(self, name: str, text: str) -> None:
        self.cpu.announce(Event(self._now_ns, "remote", name, text, {"torn": self.words.torn}))


class ServingPace(RealTime):
    """Paces scans by the wall clock, and serves a port between them."""

    def __init__(self, port: ModbusTcpPort, plc: ExternalPlc) -> None:
        self._port, self._plc = port, plc
        super().__init__(sleep=self._serve)

    @override
    def wait(self) -> bool:
        self._serve(0)  # at least once per scan, even if scans are late
        return super().wait()

    def _serve(self, seconds: float) -> None:
        self._port.serve(seconds, lambda _unit, pdu: self._plc.answer(pdu))


@contextmanager
def remote_job(
    rack: str | None, slot: int | None, silence_ms: float, *, whole: bool
) -> Iterator[tuple[LoadedRack, ExternalPlc]]:
    """Load a rack with an external PLC in place of its program.

    Args:
        rack: rack file, see `load_rack`; None = a rack with a 3601 in slot 1 and a free shaft.
        slot: slot number of the 3601; None = the slot of the only 3601.
        silence_ms: time without a write after which the CPU leaves run mode, ms.
        whole: whether to refuse writes of fewer words than the module has.

    Raises:
        ValueError: the file, the time or the slot is unusable.
    """
    if not 0 < silence_ms <= SILENCE_MS_MAX:
        raise ValueError(f"--silence {silence_ms:g}: must be above 0, at most {SILENCE_MS_MAX:,}")
    with tempfile.TemporaryDirectory() as folder:
        if rack is None:
            rack = str(Path(folder) / "remote-io.toml")
            Path(rack).write_text(BARE_RACK, encoding="utf-8", newline="\n")
        spec = load_rack(rack, _no_logic).spec
        number = _slot_of({slot_spec.number: slot_spec.module for slot_spec in spec.slot}, slot)
        silence_ns = exact_ns(silence_ms, "ms", "--silence")
        plc = ExternalPlc(number, spec.words[number], silence_ns, whole=whole)
        yield load_rack(rack, plc), plc


def _no_logic(_scan: LogicScan) -> None: ...


def _slot_of(modules: dict[int, str], slot: int | None) -> int:
    """Return the number of the slot to serve: `slot`, or the only 3601 if it is None.

    Raises:
        ValueError: that slot has no 3601, or there is not exactly one.
    """
    numbers = [number for number, module in modules.items() if module == CATALOG]
    if slot is None and len(numbers) == 1:
        return numbers[0]
    if slot is None or slot not in numbers:
        problem = "is needed" if slot is None else f"{slot}: no {CATALOG}"
        choices = ", ".join(map(str, numbers)) or "none"
        raise ValueError(f"--slot {problem}; slots with an {CATALOG}: {choices}")
    return slot
