"""A line on which some replies come late, and what then has to be true of an adapter at rest.

    question ------ patience, asked again ------>
    reply    ---------------- late ------------------------> answers a later question, by its looks

Requests get through in time, so the controller does what it is asked for. Replies may overtake each other.
All is in virtual time: the same delays give the same run.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from adapterbench import CONFIGURE_006, MS, AdapterBench, AdapterBench006, AdapterBenchDrive, move
from faultyline import FaultyDevice
from scanrack.runtime import Device

RATES = (4, 0, 100, 100)
COMMANDS: dict[str, tuple[tuple[int, ...], ...]] = {
    "relative": (tuple(move(1500, 4000, 100, 100)),),
    "short": (tuple(move(60, 4000, 100, 100)),),
    "manual": ((128, 0, 0, 0, *RATES), ()),
    "stopped": (tuple(move(5000, 4000, 100, 100)), (16,)),
    "held and resumed": (tuple(move(1500, 4000, 100, 100)), (4,), (), (8, 0, 0, 0, *RATES)),
    "registration": ((128, 0, 1, 500, *RATES), (0, 0, 1, 500, *RATES)),
}
"""Images that follow each other, half a second each; the last one for two seconds."""

EACH_MS = 400
MOVING = {"MOVING_CW", "MOVING_CCW"}


class LateDevice(FaultyDevice):
    """A device some of whose replies come late.

    Attributes:
        delays_ms: of the replies from now on, by their number, counted from 0.
    """

    def __init__(self, inner: Device) -> None:
        super().__init__(inner, {})
        self.delays_ms: Mapping[int, int] = {}

    def delay(self, delays_ms: Mapping[int, int]) -> None:
        """Delay replies from now on."""
        self.delays_ms, self.answers = delays_ms, 0

    def fate(self, answer: bytes) -> tuple[int, bytes]:
        return self.delays_ms.get(self.answers, 0) * MS, answer


def bench_for(controller: str) -> AdapterBench:
    """Return a "PCL601", a "PMC006" or a "drive" that takes all commands above."""
    if controller == "drive":
        return AdapterBenchDrive().configured()
    if controller == "PCL601":
        return AdapterBench(registration="polled").configured(*CONFIGURE_006)
    return AdapterBench006(hold="immediate", registration="polled").configured()


def lies(controller: str, command: str, delays_ms: Mapping[int, int]) -> Iterator[str]:
    """Play a command with late replies; yield each scan at which the adapter shows a rest that is none."""
    bench = bench_for(controller)
    faults = bench.module.controller.line.faults
    faults.device = late = LateDevice(faults.device)
    late.delay(delays_ms)
    *first, last = COMMANDS[command]
    for words, ms in [*((words, EACH_MS) for words in first), (last, 2000)]:
        bench.put(*words)
        bench.run(2)  # a command acts at the next scan
        for _ in range(ms // 2):
            bench.run(2)
            if "MODULE_OK" in bench.bits and bench.bits.isdisjoint(MOVING | {"POSITION_INVALID"}):
                if bench.position != bench.motor:
                    at_ms = bench.now_ns // MS
                    yield f"at {at_ms} ms the image shows {bench.position}, the motor is at {bench.motor}"
                elif "CONFIG_ERROR" in bench.bits:
                    yield "the adapter believes in a loss of power"
