"""A 3601 on the bench, in words that read like the manual: for the tests of its rules.

bench = Bench.ready()                     # configured, command mode, position 0 and valid
bench.relative(10_000, speed=5_000, up=20, down=10)
bench.run(200)                            # ms
assert bench.position == 600
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from functools import cache

from scanrack.io_images.amci3601 import InputBit, status_names
from scanrack.io_images.image import Image
from scanrack.io_images.thousands import join_reported, split_thousands
from scanrack.runtime import Amci3601
from scanrack.runtime.machine import EncoderSpec, Machine, MachineSpec, Switch

CONFIGURATION = (0x843E, 0x003F, 1, 0, 0, 0, 0, 0)
"""External input, home switch, emergency stop, both limits; step and direction; starting speed 1000."""

ENCODER = 0x0100
DIAGNOSTIC = 0x0200
CAPTURE = 0x0001
BACKPLANE_PROXIMITY = 0x0040
MARKER = 0x1000

ABSOLUTE, RELATIVE, HOLD, RESUME, IMMEDIATE_STOP = 0x0001, 0x0002, 0x0004, 0x0008, 0x0010
HOME_CW, HOME_CCW, MANUAL_CW, MANUAL_CCW = 0x0020, 0x0040, 0x0080, 0x0100
PRESET, PRESET_ENCODER, RESET = 0x0200, 0x0400, 0x0800
BLEND_CW, BLEND_CCW = 0x1000, 0x2000


def configuration(*, add: int = 0, drop: int = 0, levels: int = 0x3F, start: int = 1000) -> tuple[int, ...]:
    """Return the usual configuration with MSW bits added or dropped, other levels or starting speed."""
    return ((CONFIGURATION[0] | add) & ~drop, levels, *split_thousands(start), 0, 0, 0, 0)


class Bench:
    """One simulated 3601 with its words, its inputs and a clock in ms.

    Args:
        firmware: "2.0" to "4.1".
        scan_ms: exchange period.
        machine: switch ranges by input name, e.g. {"home": (3000, 3500), "cw_limit": (9000, None)}.
        encoder: what the shaft turns, if it turns an encoder.
        diagnostic_wiring: step outputs wired to the encoder inputs.
        options: options of the model.
    """

    def __init__(
        self,
        firmware: str = "4.1",
        *,
        scan_ms: float = 0.25,
        machine: dict[str, tuple[int | None, int | None]] | None = None,
        encoder: EncoderSpec | None = None,
        diagnostic_wiring: bool = False,
        **options: bool | int,
    ) -> None:
        switches = tuple(
            Switch(InputBit[name.upper()], first, last) for name, (first, last) in (machine or {}).items()
        )
        spec = MachineSpec(switches=switches, encoder=encoder)
        self.module = Amci3601(firmware, Machine(spec), options, diagnostic_wiring=diagnostic_wiring)
        self.scan_ns = int(Decimal(str(scan_ms)) * 1_000_000)
        self.now_ns = 0
        self.outputs = Image()
        self.image = self.module.update(0, self.outputs)
        self.fired: list[str] = []
        self._drain()

    @classmethod
    def configured(cls, firmware: str = "4.1", *, config: Sequence[int] = CONFIGURATION, **kwargs) -> Bench:
        """Return a bench that has accepted a configuration and is back in command mode, position invalid."""
        bench = cls(firmware, **kwargs)
        bench.out(*config).run(10)
        assert bench.bits == {"MODE_CONFIG", "MODULE_OK"}, bench.bits
        bench.idle(10)
        bench.fired.clear()
        return bench

    @classmethod
    def ready(cls, firmware: str = "4.1", *, position: int = 0, **kwargs) -> Bench:
        """Return a configured bench with a preset, valid position."""
        bench = cls.configured(firmware, **kwargs)
        bench.out(PRESET, 0, *split_thousands(position)).run(10)
        bench.idle(10)
        assert "POSITION_INVALID" not in bench.bits
        return bench

    # -- what the PLC does

    def out(self, *words: int) -> Bench:
        """Write output words, missing ones 0; nothing happens before time runs."""
        self.outputs = Image(words)
        return self

    def command(
        self,
        msw: int,
        target: int = 0,
        *,
        speed: int = 5000,
        up: int = 20,
        down: int = 10,
        lsw: int = 0,
        ms: float = 0,
    ) -> Bench:
        """Write a command with its parameters, then let `ms` run."""
        self.out(msw, lsw, *split_thousands(target), *split_thousands(speed), up, down)
        return self.run(ms) if ms else self

    def relative(self, distance: int, **parameters) -> Bench:
        return self.command(RELATIVE, distance, **parameters)

    def absolute(self, target: int, **parameters) -> Bench:
        return self.command(ABSOLUTE, target, **parameters)

    def manual(self, direction: int = 1, target: int = 0, **parameters) -> Bench:
        return self.command(MANUAL_CW if direction > 0 else MANUAL_CCW, target, **parameters)

    def idle(self, ms: float = 1) -> Bench:
        """Zero the command words, keep the parameters, let time run."""
        return self.out(0, 0, *list(self.outputs)[2:]).run(ms)

    def reset_errors(self, ms: float = 1) -> Bench:
        self.out(RESET).run(ms)
        return self.idle(ms)

    def plc(self, mode: str) -> Bench:
        self.module.plc_run(mode == "run")
        return self

    # -- what the world does

    def inputs(self, **levels: int) -> Bench:
        """Set electrical levels by input name, 1 = energized."""
        for name, level in levels.items():
            self.module.machine.set_input(InputBit[name.upper()], bool(level))
        self.module.look_again()
        return self

    def turn_encoder(self, counts: int, ms: float) -> Bench:
        """Turn the encoder by hand during the next `ms`, and let them run."""
        end_ns = self.now_ns + self._scans(ms) * self.scan_ns
        self.module.machine.turn_encoder(counts, self.now_ns, end_ns)
        self.module.look_again()
        return self.run(ms)

    def marker_in(self, ms: float) -> Bench:
        """Let a Z pulse come so long from now."""
        self.module.machine.marker_at(self.now_ns + int(Decimal(str(ms)) * 1_000_000))
        self.module.look_again()
        return self

    def power_cycle(self) -> Bench:
        self.module.power_cycle()
        return self

    # -- time

    def run(self, ms: float) -> Bench:
        """Let time run, rounded up to whole scans, with one exchange at its end.

        The exchanges before it would change nothing: tests/properties/test_module_in_pieces.py.
        """
        return self._advance(self._scans(ms))

    def poll(self, ms: float) -> Bench:
        """Let time run with an exchange in every scan, as a PLC does."""
        for _ in range(self._scans(ms)):
            self.scan()
        return self

    def scan(self) -> Bench:
        """One exchange."""
        return self._advance(1)

    def _scans(self, ms: float) -> int:
        return -(-int(Decimal(str(ms)) * 1_000_000) // self.scan_ns)

    def _advance(self, scans: int) -> Bench:
        self.now_ns += scans * self.scan_ns
        self.image = self.module.update(self.now_ns, self.outputs)
        if self.module.events:
            self._drain()
        return self

    def until(self, *names: str, clear: Sequence[str] = (), ms: float = 10_000) -> float:
        """Run until these bits are set and those clear; return the ms it took, or fail."""
        start = self.now_ns
        end_ns = start + self._scans(ms) * self.scan_ns
        while self.now_ns < end_ns:
            self.to_change(end_ns)
            if self.bits.issuperset(names) and self.bits.isdisjoint(clear):
                return (self.now_ns - start) / 1_000_000
        raise AssertionError(
            f"{names} set, {clear} clear not within {ms} ms: {sorted(self.bits)} at {self.position}"
        )

    def to_change(self, end_ns: int) -> Bench:
        """Let time run to the first scan that can show other bits, at most to `end_ns`."""
        change_ns = min(self.module.calm_until_ns(self.outputs), end_ns)
        return self._advance(max(1, -(-(change_ns - self.now_ns) // self.scan_ns)))

    # -- what the module shows

    @property
    def bits(self) -> frozenset[str]:
        return _names(self.image[0] & 0xFFFF, self.image[1] & 0xFFFF)

    @property
    def words(self) -> list[int]:
        return list(self.image)

    @property
    def position(self) -> int:
        return join_reported(self.image[2], self.image[3])

    @property
    def encoder(self) -> int:
        return join_reported(self.image[4], self.image[5])

    @property
    def captured(self) -> int:
        return join_reported(self.image[6], self.image[7])

    def _drain(self) -> None:
        """Collect the ids of the rules that have fired in `fired`."""
        self.fired += [event.name for event in self.module.events if event.kind == "rule"]
        self.module.events.clear()


@cache
def _names(word0: int, word1: int) -> frozenset[str]:
    return frozenset(status_names(word0, word1))
