"""The bench of `scanrack drive` for modules with 8 + 8 words and discrete inputs.

Time runs in whole exchange periods. The words and levels at the start of a period are in effect during the
period. The input image is the module's image at the end of the period.
"""

from __future__ import annotations

from collections.abc import Callable, Set
from decimal import Decimal
from typing import Any, Protocol

from scanrack.io_images.amci3601 import InputBit, StatusMsw
from scanrack.io_images.amci3601.words import WORDS_3601, Profile
from scanrack.io_images.image import Image
from scanrack.io_images.thousands import join_reported
from scanrack.runtime.loop.events import Event, JsonValue
from scanrack.runtime.loop.module import Module
from scanrack.runtime.machine import Machine, MachineSpec, Switch
from scanrack.runtime.modules.record import ModuleRecord, Trait

from .requests import Encoder, ImageBenchOptions, Request, RequestError, Until, read

NS_PER_MS = 1_000_000


class BenchModule(Module, Protocol):
    """A module with a machine."""

    machine: Machine

    def look_again(self) -> None:
        """Make the module read its inputs at the next tick. Called after an input changes."""


class ImageBench:
    """A module on the bench.

    Attributes:
        requests: the model of a request.
    """

    requests: type[Request] = Request

    def __init__(
        self, make: Callable[[ImageBenchOptions], BenchModule], profile: Profile = WORDS_3601
    ) -> None:
        self._make, self._profile = make, profile
        self._renew(ImageBenchOptions())

    def _renew(self, options: ImageBenchOptions) -> None:
        """Start a fresh bench at time 0 with a first image; raise RequestError for a wrong option."""
        try:
            module = self._make(options)
        except ValueError as error:
            raise RequestError(f"new: {error}") from None
        self.module = module
        self.scan_ns = int(options.scan_ms * NS_PER_MS)
        self.now_ns = 0
        self.scan = 0
        self._wired = options.machine.wired
        self._outputs = Image()
        self._inputs = module.update(0, self._outputs)

    def answer(self, line: str) -> dict[str, Any]:
        """Carry out the request in a line; return the reply that `drive` prints.

        Raises:
            RequestError: the request is illegal; nothing has changed.
        """
        request = read(line, self.requests, self._profile)
        self._check(request)
        if request.new is not None:
            self._renew(request.new)
        if request.power_cycle:
            self.module.power_cycle()
        self._act_on_line(request)
        if request.plc_mode is not None:
            self.module.plc_run(request.plc_mode == "run")
        if request.out is not None:
            self._outputs = Image(request.out)
        self._set_inputs(request)
        scans = -(-int(request.for_ms * NS_PER_MS) // self.scan_ns)
        if request.encoder is not None:
            self._turn(request.encoder, scans)
        if scans == 0:
            self._inputs = self.module.update(self.now_ns, self._outputs)
        changes: list[list[Any]] = []
        met = self._run(scans, request.until, changes if request.changes else None)
        reply = self._reply()
        if request.until is not None:
            reply["met"] = met
        if request.changes:
            reply["changes"] = changes
        return reply

    def _act_on_line(self, request: Request) -> None:
        """Apply the faults of a request to the module's line; for subclasses with a line."""

    def _check(self, request: Request) -> None:
        """Raise RequestError for the level of an input that a switch of the machine operates."""
        wired = self._wired if request.new is None else request.new.machine.wired
        for name in wired:
            if getattr(request.inputs, name) is not None:
                raise RequestError(
                    f"inputs.{name}: a switch of the machine operates this input: remove the key"
                )

    def _set_inputs(self, request: Request) -> None:
        for name, level in request.inputs:
            if level is not None:
                self.module.machine.set_input(InputBit[name.upper()], bool(level))
                self.module.look_again()

    def _turn(self, encoder: Encoder, scans: int) -> None:
        """Turn the encoder evenly during the next scans, and set its marker pulses."""
        machine = self.module.machine
        if encoder.counts:
            machine.turn_encoder(encoder.counts, self.now_ns, self.now_ns + scans * self.scan_ns)
        for offset in encoder.markers_ms:
            machine.marker_at(self.now_ns + max(1, int(offset * NS_PER_MS)))  # the module has passed now_ns
        self.module.look_again()

    def _run(self, scans: int, until: Until | None, changes: list[list[Any]] | None) -> bool:
        """Run up to `scans` exchange periods; return whether the status bits match `until`.

        Args:
            changes: receives the time and contents of each changed input image; None = not needed.
        """
        latest_bytes = self._inputs.raw.tobytes()
        for _ in range(scans):
            self.now_ns += self.scan_ns
            self.scan += 1
            self._inputs = self.module.update(self.now_ns, self._outputs)
            image_bytes = self._inputs.raw.tobytes()
            if image_bytes != latest_bytes:
                latest_bytes = image_bytes
                if changes is not None:
                    changes.append([time_ms(self.now_ns), list(self._inputs)])
            if until is not None and self._is_met(until):
                self.module.machine.let_go(self.now_ns)
                self.module.look_again()
                return True
        return scans == 0 and until is not None and self._is_met(until)

    def _status_names(self) -> list[str]:
        return self._profile.status_names(self._inputs[0] & 0xFFFF, self._inputs[1] & 0xFFFF)

    def _is_met(self, until: Until) -> bool:
        names = set(self._status_names())
        return names.issuperset(until.set) and names.isdisjoint(until.clear)

    def _reply(self) -> dict[str, Any]:
        """Return the reply: the time, the image and its values, and the rules since the last reply."""
        words = list(self._inputs)
        is_configuring = bool(words[0] & StatusMsw.MODE_CONFIG.value)
        position, encoder, captured = (
            None if is_configuring else join_reported(words[index], words[index + 1]) for index in (2, 4, 6)
        )
        return {
            "t_ms": time_ms(self.now_ns),
            "scan": self.scan,
            "in": words,
            "bits": self._status_names(),
            "position": position,
            "encoder": encoder,
            "captured": captured,
            "rules": self._rules(),
        }

    def _rules(self) -> list[str]:
        """Return the IDs of the rules that have set an error bit since the last reply."""
        error_names = {name for name, mask in self._profile.masks.items() if mask & self._profile.error_bits}
        ids = [event.name for event in self.module.events if _sets_error(event, error_names)]
        self.module.events.clear()
        return ids


def _sets_error(event: Event, error_names: Set[str]) -> bool:
    bits: JsonValue = event.fields.get("bits")
    return event.kind == "rule" and isinstance(bits, list) and not error_names.isdisjoint(bits)


def time_ms(now_ns: int) -> int | float:
    """Return a time in ms as an exact JSON number, as an integer if possible."""
    whole_ms, part_ns = divmod(now_ns, NS_PER_MS)
    return whole_ms if part_ns == 0 else float(Decimal(now_ns) / NS_PER_MS)


def on_bench(record: ModuleRecord, options: ImageBenchOptions) -> Any:
    """Create a simulated module for a fresh bench."""
    switches = (Switch(InputBit[name.upper()], *span) for name, span in options.machine.wired.items())
    return record.make(
        firmware=options.firmware,
        machine=MachineSpec(switches=tuple(switches)),
        seed=0,
        options=options.options,
        wiring=options.wiring if Trait.LINE not in record.traits else None,
    )
