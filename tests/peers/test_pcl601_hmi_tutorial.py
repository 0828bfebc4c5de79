"""The manual's HMI tutorial [Section 6]: three stations, played by a script through pymodbus's client.

    System Enabled      output 1; enabling writes acceleration 1000, base speed 500, maximum speed 5000
    Stage 1 complete    input 1: move to 4000, stage 2
    Stage 2 complete    input 2: move to 8000, stage 3
    Stage 3 complete    input 3: move back to 0, stage 1

A stage says that it is complete by a pulse; macros run at its rising edge, and only while output 1 is on.
The position is a double word, low word first; the direction register is 1 on the way right, else 0.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from pymodbus.client import ModbusTcpClient
from scanrack.runtime.machine.contacts import GROUND, OPEN
from serving601 import Serving, serving

GO, STOP_HARD = 1, 5
COMMAND, ACCELERATION, BASE_SPEED, DIRECTION, POSITION, TARGET, BUSY = 1, 4, 6, 9, 13, 15, 35
STAGES = {1: 4000, 2: 8000, 3: 0}
"""Where the system moves to when a stage is complete, by its input."""

SPEED = 20.0
"""The clock of the simulation: a move of 4000 steps takes 3.1 s of the controller's time."""


class Hmi:
    """The screen of the tutorial: what its buttons and macros do, and what it shows."""

    def __init__(self, client: ModbusTcpClient) -> None:
        self._client = client
        self._seen = [False] * 3

    def read(self, reference: int, count: int = 1) -> list[int]:
        return list(self._client.read_holding_registers(reference - 1, count=count, device_id=1).registers)

    def write(self, reference: int, *values: int) -> None:
        assert not self._client.write_registers(reference - 1, list(values), device_id=1).isError()

    @property
    def enabled(self) -> bool:
        return self._client.read_coils(0, count=1, device_id=1).bits[0]

    @property
    def position(self) -> int:
        low, high = self.read(POSITION, 2)
        value = high << 16 | low
        return value - (1 << 32) if value >> 31 else value

    def enable(self) -> None:
        """The button toggles output 1; macro "initialize" runs when that is on."""
        self._client.write_coil(0, True, device_id=1)
        self.write(ACCELERATION, 1000, 0)
        self.write(BASE_SPEED, 500, 5000)

    def disable(self) -> None:
        self._client.write_coil(0, False, device_id=1)

    def stop(self) -> None:
        if self.enabled:
            self.write(COMMAND, STOP_HARD)

    def refresh(self) -> None:
        """Read the inputs; run the macro of each that has come on since."""
        now = list(self._client.read_discrete_inputs(0, count=3, device_id=1).bits[:3])
        for stage, (before, bit) in enumerate(zip(self._seen, now, strict=True), 1):
            if bit and not before and self.enabled:
                self.write(TARGET, STAGES[stage], 0)
                self.write(COMMAND, GO)
        self._seen = now

    def arrive(self) -> set[int]:
        """Refresh until the motor stands; return what the direction register read until then."""
        shown = set()
        for _ in range(20_000):
            self.refresh()
            busy = self.read(BUSY)[0]
            shown.add(self.read(DIRECTION)[0])
            if not busy:
                return shown
        raise AssertionError("the motor does not come to rest")


@pytest.fixture
def system(request: pytest.FixtureRequest) -> Iterator[tuple[Serving, Hmi]]:
    speed = getattr(request, "param", SPEED)
    with (
        serving(tcp="0", speed=speed) as server,
        ModbusTcpClient("127.0.0.1", port=server.port, timeout=120) as client,
    ):
        yield server, Hmi(client)


def complete(server: Serving, hmi: Hmi, stage: int) -> set[int]:
    """Let a stage pulse; return the directions that were shown until the motor stood again."""
    server.connect(**{f"in{stage}": GROUND})
    hmi.refresh()
    server.connect(**{f"in{stage}": OPEN})
    return hmi.arrive()


@pytest.mark.slow
def test_the_stages_are_served_in_turn(system: tuple[Serving, Hmi]) -> None:
    server, hmi = system
    hmi.enable()
    assert hmi.read(ACCELERATION, 4) == [1000, 0, 500, 5000]
    for _ in range(2):
        shown = []
        for stage in STAGES:
            shown.append(complete(server, hmi, stage))
            assert hmi.position == STAGES[stage]
        assert shown == [{1}, {1}, {0}]


def test_nothing_moves_unless_the_system_is_enabled(system: tuple[Serving, Hmi]) -> None:
    server, hmi = system
    complete(server, hmi, 1)
    assert hmi.position == 0
    hmi.enable()
    hmi.disable()
    complete(server, hmi, 1)
    assert hmi.position == 0


@pytest.mark.parametrize("system", [1.0], indirect=True)
def test_the_stop_button_stops_at_once_and_the_next_stage_goes_on_from_there(
    system: tuple[Serving, Hmi],
) -> None:
    """In real time: a move of 8000 steps takes 5 s, so that a slow machine does not miss it."""
    server, hmi = system
    hmi.enable()
    server.connect(in2=GROUND)
    hmi.refresh()
    while hmi.position < 100:
        hmi.refresh()
    hmi.stop()
    assert hmi.read(BUSY) == [0]
    stopped_at = hmi.position
    assert 100 <= stopped_at < 8000
    assert hmi.position == stopped_at
    complete(server, hmi, 3)
    assert hmi.position == 0
