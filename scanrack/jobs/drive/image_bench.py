"""The bench for image targets of `scanrack drive`: a module, its 8 + 8 words, its discrete inputs.

Time runs in whole exchange periods. The words and levels at the start of a period act during the period. The
input image is the module's image at its end.
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
    """A module on the bench: its machine, and a method to call after an input has changed."""

    machine: Machine

    def look_again(self) -> None:
        """Make the module read its inputs at the next tick."""


class ImageBench:
    """One module on the bench, driven request by request.

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
        self._image = module.update(0, self._outputs)

    def answer(self, line: str) -> dict[str, Any]:
        """Carry out one line of requests; return the reply that `drive` prints.

        Raises:
            RequestError: the request is illegal; nothing has changed.
        """
        request = read(line, self.requests, self._profile)
        self._check(request)
        if request.new is not None:
            self._renew(request.new)
        if request.power_cycle:
            self.module.power_cycle()
        self._befall(request)
        if request.plc_mode is not None:
            self.module.plc_run(request.plc_mode == "run")
        if request.out is not None:
            self._outputs = Image(request.out)
        self._set_inputs(request)
        scans = -(-int(request.for_ms * NS_PER_MS) // self.scan_ns)
        if request.encoder is not None:
            self._turn(request.encoder, scans)
        if scans == 0:
            self._image = self.module.update(self.now_ns, self._outputs)
        changes: list[list[Any]] = []
        met = self._run(scans, request.until, changes if request.changes else None)
        reply = self._reply()
        if request.until is not None:
            reply["met"] = met
        if request.changes:
            reply["changes"] = changes
        return reply

    def _befall(self, request: Request) -> None:
        """Apply further parts of a request before the words; subclasses override this."""

    def _check(self, request: Request) -> None:
        for name in self._wired if request.new is None else request.new.machine.wired:
            if getattr(request.inputs, name) is not None:
                raise RequestError(
                    f"inputs.{name}: this input follows the machine's switch; set the others only"
                )

    def _set_inputs(self, request: Request) -> None:
        for name, level in request.inputs:
            if level is not None:
                self.module.machine.set_input(InputBit[name.upper()], bool(level))
                self.module.look_again()

    def _turn(self, encoder: Encoder, scans: int) -> None:
        machine = self.module.machine
        if encoder.counts:
            machine.turn_encoder(encoder.counts, self.now_ns, self.now_ns + scans * self.scan_ns)
        for offset in encoder.markers_ms:
            machine.marker_at(self.now_ns + max(1, int(offset * NS_PER_MS)))  # the current instant is over
        self.module.look_again()

    def _run(self, scans: int, until: Until | None, changes: list[list[Any]] | None) -> bool:
        """Run up to `scans` exchange periods; return whether `until` was met."""
        met = scans == 0 and until is not None and self._satisfies(until)
        before = self._image.raw.tobytes()
        for _ in range(scans):
            self.now_ns += self.scan_ns
            self.scan += 1
            self._image = self.module.update(self.now_ns, self._outputs)
            image = self._image.raw.tobytes()
            if image != before:
                before = image
                if changes is not None:
                    changes.append([time_ms(self.now_ns), list(self._image)])
            if until is not None and self._satisfies(until):
                self.module.machine.let_go(self.now_ns)
                self.module.look_again()
                return True
        return met

    def _satisfies(self, until: Until) -> bool:
        names = set(self._profile.status_names(self._image[0] & 0xFFFF, self._image[1] & 0xFFFF))
        return names.issuperset(until.set) and names.isdisjoint(until.clear)

    def _reply(self) -> dict[str, Any]:
        words = list(self._image)
        configuring = bool(words[0] & StatusMsw.MODE_CONFIG.value)
        values = [
            None if configuring else join_reported(words[index], words[index + 1]) for index in (2, 4, 6)
        ]
        return {
            "t_ms": time_ms(self.now_ns),
            "scan": self.scan,
            "in": words,
            "bits": self._profile.status_names(words[0] & 0xFFFF, words[1] & 0xFFFF),
            "position": values[0],
            "encoder": values[1],
            "captured": values[2],
            "rules": self._rules(),
        }

    def _rules(self) -> list[str]:
        errors = {name for name, mask in self._profile.masks.items() if mask & self._profile.error_bits}
        ids = [event.name for event in self.module.events if _names_one_of(errors, event)]
        self.module.events.clear()
        return ids


def _names_one_of(errors: Set[str], event: Event) -> bool:
    bits: JsonValue = event.fields.get("bits")
    return event.kind == "rule" and isinstance(bits, list) and not errors.isdisjoint(bits)


def time_ms(now_ns: int) -> int | float:
    """Return a time as an exact JSON number in ms, an integer if possible."""
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
