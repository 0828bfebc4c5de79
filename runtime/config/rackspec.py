"""A rack as typed objects, from a rack file or from Python.

    RackSpec(
        program=logic,
        scan_ms=2,
        slot=[SlotSpec(number=1, module="amci3601", machine=MachineSpec(...))],
    )

Fields have the names of the rack file's keys. A `RackSpec` is always valid: slots are
unique, addresses of forces exist, modules accept their options.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from decimal import Decimal
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import (
    BeforeValidator,
    Field,
    GetPydanticSchema,
    PlainValidator,
    PrivateAttr,
    ValidationInfo,
    WithJsonSchema,
    model_validator,
)
from pydantic_core import PydanticCustomError, core_schema
from scanrack.io_images.addresses import allowed, parse_address
from scanrack.io_images.amci3601.firmware import KNOWN, Firmware
from scanrack.io_images.amci3601.words import WORDS_3601, Profile, is_stepper
from scanrack.io_images.memory_layout import MemoryLayout, memory_layout
from scanrack.io_images.module_words import ModuleWords
from scanrack.io_images.site import SettingError, SiteError
from scanrack.io_images.times import exact_ns

from ..loop.events import JsonValue
from ..loop.forces import check_value
from ..loop.incidents import ON_THE_LINE, FaultKind, InjectedFault
from ..loop.module import Module
from ..machine import MachineSpec
from ..machine.spec import INPUT_NAMES
from ..modules.record import LiveModule, ModuleRecord, Trait
from ..modules.registry import MODULES, OWN, live_port
from .axis_tables import AxisTable
from .export_table import ExportTable
from .fuzz_table import FuzzTable
from .machine_tables import MachineTable, Rare, Table
from .prove_tables import ProveTable
from .quantities import Milliseconds, Number, Seconds, between
from .serial_units import UnitSpec
from .server_table import ServerTable
from .stub_tables import StubTable
from .tomllines import KeyPath

Result = TypeVar("Result")

SIMULATED = "sim"
"""The port of an adapter whose controller is simulated."""


MISSING_TAGS, DECLARE = "missing_tags", "declare"
REFUSED, EMPTY = "refused", "empty"
STUB_SETTINGS = {MISSING_TAGS: DECLARE, REFUSED: EMPTY}
"""Keys in `[stubs]` that are settings, each with its only allowed value."""


_FAMILIES = {"micrologix": "1762", "compactlogix": "1769"}
"""Card family by controller: 1762 I/O for a MicroLogix, 1769 Compact I/O for a CompactLogix."""

_CONTROLLER_OF_EXPORT = {".SLC": "micrologix", ".L5X": "compactlogix"}

_CONTROLLER_NAMES = {"micrologix": "MicroLogix", "compactlogix": "CompactLogix"}


class MisplacedError(ValueError):
    """A mistake in a key, with the key's path from the top of the specification."""

    def __init__(self, path: KeyPath, value: object, message: str) -> None:
        super().__init__(message)
        self.path = path
        self.value = value


def _machine_schema(_source: Any, handler: Any) -> core_schema.CoreSchema:
    """Accept a MachineSpec, or a table that describes one."""

    def convert(value: object, describe: Callable[[object], MachineTable]) -> MachineSpec:
        return value if isinstance(value, MachineSpec) else describe(value).spec()

    return core_schema.no_info_wrap_validator_function(convert, handler.generate_schema(MachineTable))


def _modules_of_file(info: ValidationInfo) -> Mapping[str, ModuleRecord]:
    """Return the modules listed in `[modules]` of the rack file."""
    return info.context or {}


def _module_name(value: object, info: ValidationInfo) -> object:
    if isinstance(value, str) and value not in MODULES and value not in _modules_of_file(info):
        names = [*MODULES, *_modules_of_file(info)]  # looks for installed packages, which takes time
        raise PydanticCustomError("name", "{hint}", {"hint": allowed(value, names)})
    return value


def _firmware_text(value: object) -> object:
    if isinstance(value, Decimal | float):
        raise PydanticCustomError("allowed", 'text in quotes, such as "{given}"', {"given": str(value)})
    return value


def _plain_options(value: object) -> object:
    """Convert a rack file's decimals to floats, for options and JSON."""
    if not isinstance(value, Mapping):
        raise PydanticCustomError("allowed", "a table")
    return {key: float(option) if isinstance(option, Decimal) else option for key, option in value.items()}


def _bit_or_word(value: object) -> object:
    return int(value) if isinstance(value, bool) else value


def _program(value: object) -> str | Callable[..., Any]:
    if isinstance(value, str) or callable(value):
        return value
    raise PydanticCustomError("allowed", "a path in quotes")


def _stub_schema(_source: Any, handler: Any) -> core_schema.CoreSchema:
    """Accept a string or a table."""

    def convert(value: object, describe: Callable[[object], StubTable]) -> str | StubTable:
        if not isinstance(value, str | StubTable | Mapping):
            raise PydanticCustomError("allowed", "text in quotes, or a table")
        return value if isinstance(value, str | StubTable) else describe(value)

    return core_schema.no_info_wrap_validator_function(convert, handler.generate_schema(Rare[StubTable]))


Version = Annotated[
    str,
    BeforeValidator(_firmware_text),
    WithJsonSchema(
        {"anyOf": [{"enum": list(map(str, KNOWN))}, {"type": "string", "pattern": r"^serial \d+$"}]}
    ),
]
"""A firmware version, or a serial number."""


class SlotSpec(Table):
    """A slot and its module.

    Attributes:
        number: slot number, from 1.
        module: catalog name of the module.
        firmware: firmware version, or a serial number such as "serial 96317".
        needs_firmware: oldest firmware version that the program supports; `scanrack fuzz` never tries an
            older version.
        options: options of the module by name.
        machine: the machine that the module drives.
        wiring: "diagnostic": the step outputs are wired to the encoder inputs.
        port: for an adapter, "sim" or the port of a real controller (a serial device, or tcp:HOST:PORT).
        address: for an adapter, address of the controller at the port; defaults to the factory address.
    """

    number: Annotated[int, Field(ge=1)]
    module: Annotated[str, BeforeValidator(_module_name)]
    firmware: Version = "4.1"
    needs_firmware: Version = str(KNOWN[0])
    options: Annotated[
        Mapping[str, JsonValue], PlainValidator(_plain_options), WithJsonSchema({"type": "object"})
    ] = Field(default_factory=dict)
    machine: Annotated[MachineSpec, GetPydanticSchema(_machine_schema)] = MachineSpec()
    wiring: Literal["diagnostic"] | None = None
    port: str = SIMULATED
    address: int | None = None
    _record: ModuleRecord = PrivateAttr()

    @property
    def record(self) -> ModuleRecord:
        """The record of the slot's module."""
        return self._record

    def has(self, trait: Trait) -> bool:
        """Return whether the slot's module has a trait."""
        return trait in self._record.traits

    @property
    def is_live(self) -> bool:
        """Whether the slot has a real controller."""
        return self.port != SIMULATED

    def open(self) -> LiveModule:
        """Open the real port with the slot's adapter; the caller closes it.

        Raises:
            ValueError: the port can't be opened.
        """
        return live_port(self.module, self._record.live, self.port, self.address).open(
            self.port, self.address, self.options
        )

    @property
    def recorded_firmware(self) -> str:
        """The module's firmware as recorded in the trace; "" for a module without firmware."""
        return self.firmware if self._record.has_firmware else ""

    @property
    def words(self) -> ModuleWords:
        """Names of the module's words and bits."""
        return self._record.words(self.options)

    def make(self, seed: int) -> Module:
        """Make the module, with a simulated controller even if the slot has a real port.

        Raises:
            ValueError: the module does not accept the firmware or an option.
        """
        return self._record.make(
            firmware=self.firmware,
            machine=self.machine,
            seed=seed,
            options=self.options,
            wiring=self.wiring,
        )

    @model_validator(mode="after")
    def _can_be_made(self, info: ValidationInfo) -> Self:
        """Look up the record of the module; refuse a slot whose module can't be made."""
        file_modules = _modules_of_file(info)
        self._record = file_modules[self.module] if self.module in file_modules else MODULES[self.module]
        self.make(seed=0)
        # only compared if set, because firmware of other modules than the 3601 has no order
        needs_firmware = "needs_firmware" in self.model_fields_set
        if needs_firmware and Firmware.parse(self.firmware) < Firmware.parse(self.needs_firmware):
            text = f"the program needs {self.needs_firmware} or newer (needs_firmware)"
            raise SettingError("firmware", f"firmware {self.firmware}: {text}")
        if self.is_live:
            live_port(self.module, self._record.live, self.port, self.address)
        elif self.address is not None:
            raise SettingError("address", f"address {self.address}: only a real port has an address")
        return self


def profile_in(slots: Iterable[SlotSpec], number: int | None) -> Profile:
    """Return the profile of a slot's stepper, else of the rack's fastest stepper, else of a 3601."""
    steppers = {slot.number: words for slot in slots if is_stepper(words := slot.words)}
    if number in steppers:
        return steppers[number]
    return max(steppers.values(), key=lambda profile: profile.limits.speed, default=WORDS_3601)


class ForceSpec(Table):
    """A force that is in effect from the first scan on.

    Attributes:
        address: address of a bit or a word, such as "Local:1:I.Data[1].2", "I:1.0/14" or
            "slot1.status.MOVE_COMPLETE".
        value: 0 or 1 for a bit, -32,768 to 65,535 for a word.
    """

    address: str
    value: Annotated[int, BeforeValidator(_bit_or_word), WithJsonSchema({"type": ["integer", "boolean"]})]


def _fault_kind(value: object) -> object:
    """Return the fault kind for a name; refuse an unknown name."""
    if isinstance(value, FaultKind):
        return value
    names = [kind.value for kind in FaultKind]
    if value not in names:
        raise PydanticCustomError("name", "{hint}", {"hint": allowed(value, names)})
    return FaultKind(value)


class InjectedFaultSpec(Table):
    """An injected fault of a module or of the controller.

    Attributes:
        at_ms: start of the fault, ms; or use `at_s`.
        what: "power-cycle", "link-lost", "removed", "fatal-error", "asic-lost", "torn-update",
            "program-mode"; for an adapter, "line-down", "replies-lost", "replies-damaged" or
            "controller-power-cycle"; for a drive, "condition".
        slot: slot of the module; omit it for "program-mode"; optional in a rack with one module.
        for_ms: duration, ms; or use `for_s`. Unlimited if omitted; a torn update lasts one RPI.
        late_words: for "torn-update": the output words that arrive late.
        state: for "condition": the new state, such as "temperature=95" or "cable=lost".
    """

    at_ms: Milliseconds | None = None
    at_s: Seconds | None = None
    what: Annotated[
        FaultKind,
        PlainValidator(_fault_kind),
        WithJsonSchema({"enum": [kind.value for kind in FaultKind]}),
    ]
    slot: int | None = None
    for_ms: Milliseconds | None = None
    for_s: Seconds | None = None
    late_words: Annotated[tuple[int, ...], Field(strict=False)] = ()
    state: str = ""

    def incident(self, only_slot: int = 1) -> InjectedFault:
        """Return the injected fault; raise ValueError if times or words are missing or conflict.

        Args:
            only_slot: slot of the rack's only module, for a fault without the key `slot`.
        """
        for_ns = 0 if self.for_ms is None and self.for_s is None else self.ns("for")
        slot = 0 if self.what is FaultKind.PROGRAM_MODE else self.slot or only_slot
        return InjectedFault(self.ns("at"), self.what, slot, for_ns, self.late_words, self.state)

    @model_validator(mode="after")
    def _is_valid_fault(self) -> Self:
        self.incident()
        return self


KEPT_TRACES = 3
"""Number of earlier traces to keep, unless the rack file sets it."""


class RackSpec(Table):
    """A rack and the settings of its runs.

    Attributes:
        program: the logic, given as a path (`path[:function]`, relative to the rack file) or, in Python, a
            function.
        name: name of the rack in reports.
        scan_ms: time from one scan to the next, 0.01 to 1000 ms.
        controller: "micrologix" exchanges images at the start and end of the scan, "compactlogix" every RPI.
        rpi_ms: the RPI of a CompactLogix, 0.01 to 1000 ms; 2 if omitted.
        watchdog_ms: maximum processor time of the logic in one scan, ms; 0 = no watchdog. The wall-clock
            limit is ten times as long.
        run_for_s: machine time of a run; the command line overrides it.
        tags: patterns of the program's tags to record in addition to the images.
        stubs: replacements for a ladder program's instructions, message results, and partners for consumed
            tags, by name; `missing_tags = "declare"` declares missing tags, `refused = "empty"` runs an
            exported program without its refused parts.
        trace: path of the trace, relative to the rack file.
        keep_traces: number of earlier traces to keep; their names are numbered; 0 = none.
        axes: axes of a ladder program's motion instructions, by tag; each is a 3601 or ideal.
        prove: properties and assumptions of `scanrack prove`.
        fuzz: settings of `scanrack fuzz`.
        export: how an exported program starts.
        server: tags that clients of a tag server see and may write.
        seed: seed for random numbers, for example for slips.
        mode: position of the controller's keyswitch at power-up.
        modules: your own modules by name. Each is a Python file, followed by the name of its ModuleRecord
            unless that name is RECORD: "blinker.py:OTHER".
        slot: the slots, at least one.
        force: bits and words to force from the first scan on.
        incident: injected faults of modules and of the controller.
        unit: controllers outside the rack, on serial lines.
    """

    program: Annotated[str | Callable[..., Any], PlainValidator(_program), WithJsonSchema({"type": "string"})]
    name: str = "rack"
    scan_ms: Annotated[Number, between("0.01", "1000")] = Decimal(2)
    controller: Literal["micrologix", "compactlogix"] = "micrologix"
    rpi_ms: Annotated[Number, between("0.01", "1000")] | None = None
    watchdog_ms: Annotated[Number, between("0", "3600000")] = Decimal(500)
    run_for_s: Annotated[Number, between("0.00001", "1000000000")] | None = None
    trace: str | None = None
    keep_traces: Annotated[int, Field(ge=0, le=1000)] = KEPT_TRACES
    tags: Annotated[tuple[str, ...], Field(strict=False)] = ()
    stubs: dict[str, Annotated[str | StubTable, GetPydanticSchema(_stub_schema)]] = Field(
        default_factory=dict
    )
    axes: dict[str, Rare[AxisTable]] = Field(default_factory=dict)
    prove: Rare[ProveTable] = Field(default_factory=ProveTable.model_construct)
    fuzz: Rare[FuzzTable] = Field(default_factory=FuzzTable.model_construct)
    export: Rare[ExportTable] = Field(default_factory=ExportTable.model_construct)
    server: Rare[ServerTable] = Field(default_factory=ServerTable.model_construct)
    seed: Annotated[int, Field(ge=0)] = 0
    mode: Literal["run", "program", "test"] = "run"
    modules: dict[str, str] = Field(default_factory=dict)
    slot: Annotated[tuple[SlotSpec, ...], Field(strict=False, min_length=1)]
    force: Annotated[tuple[Rare[ForceSpec], ...], Field(strict=False)] = ()
    incident: Annotated[tuple[Rare[InjectedFaultSpec], ...], Field(strict=False)] = ()
    unit: Annotated[tuple[Rare[UnitSpec], ...], Field(strict=False)] = ()

    @property
    def incidents(self) -> tuple[InjectedFault, ...]:
        """The injected faults, in the order of the file."""
        return tuple(spec.incident(self.slot[0].number) for spec in self.incident)

    @property
    def scan_ns(self) -> int:
        """Time from one scan to the next, ns."""
        return exact_ns(self.scan_ms, "ms")

    @property
    def layout(self) -> MemoryLayout:
        """The layout of the images in the rack's memory."""
        return memory_layout(self.words.items())

    @property
    def words(self) -> Mapping[int, ModuleWords]:
        """The words of the modules by slot, in the order of the rack's memory."""
        return {slot.number: slot.words for slot in sorted(self.slot, key=lambda slot: slot.number)}

    @property
    def rpi_ns(self) -> int:
        """The RPI, ns."""
        return exact_ns(Decimal(2) if self.rpi_ms is None else self.rpi_ms, "ms")

    @model_validator(mode="after")
    def _is_consistent(self) -> Self:
        """Refuse a rack whose tables contradict each other; report only the first contradiction."""
        self._check_times()
        self._check_stubs()
        self._check_axes()
        self._check_properties()
        self._check_slots()
        self._check_cams()
        self._check_modules()
        self._check_forces()
        self._check_incidents()
        self._check_units()
        return self

    def _check_times(self) -> None:
        """Refuse a time that is not a whole number of ns, and an RPI of a MicroLogix."""
        for key, unit in (("scan_ms", "ms"), ("rpi_ms", "ms"), ("watchdog_ms", "ms"), ("run_for_s", "s")):
            value = getattr(self, key)
            if value is not None:
                _check_at((key,), value, exact_ns, value, unit, key)
        if self.rpi_ms is not None and self.controller == "micrologix":
            raise MisplacedError(("rpi_ms",), self.rpi_ms, 'goes with controller = "compactlogix" only')

    def _check_stubs(self) -> None:
        for name, only_value in STUB_SETTINGS.items():
            setting = self.stubs.get(name, only_value)
            if setting != only_value:
                raise MisplacedError(("stubs", name), setting, f'must be "{only_value}"')

    def _check_axes(self) -> None:
        """Refuse an axis whose slot is empty or belongs to another axis."""
        slot_numbers = [slot.number for slot in self.slot]
        axis_names: dict[int, str] = {}
        for name, axis in self.axes.items():
            path: KeyPath = ("axes", name, "slot")
            if axis.slot is None:
                continue
            if axis.slot not in slot_numbers:
                slot_list = ", ".join(map(str, slot_numbers))
                raise MisplacedError(path, axis.slot, f"this slot is empty: modules sit in {slot_list}")
            if axis.slot in axis_names:
                raise MisplacedError(path, axis.slot, f"{axis_names[axis.slot]} has this slot already")
            axis_names[axis.slot] = name

    def _check_properties(self) -> None:
        """Refuse two properties with the same name, in any case."""
        names: set[str] = set()
        for index, claim in enumerate(self.prove.property):
            if claim.name.upper() in names:
                path: KeyPath = ("prove", "property", index, "name")
                raise MisplacedError(path, claim.name, "another property has this name")
            names.add(claim.name.upper())

    def _check_modules(self) -> None:
        for name, file in self.modules.items():
            if name in MODULES:
                raise MisplacedError(("modules", name), file, "another module has this name")

    def _check_slots(self) -> None:
        """Refuse slots with the same number, unsuitable firmware, and cards for another controller."""
        numbers: set[int] = set()
        for index, slot in enumerate(self.slot):
            if slot.number in numbers:
                path: KeyPath = ("slot", index, "number")
                raise MisplacedError(path, slot.number, f"slot {slot.number} is used twice")
            numbers.add(slot.number)
            firmware_path: KeyPath = ("slot", index, "firmware")
            if "controller" in self.model_fields_set:
                check = slot.record.check_controller
                _check_at(firmware_path, slot.firmware, check, slot.firmware, self.controller)
            if "firmware" in slot.model_fields_set and not slot.record.has_firmware:
                reason = f"a {slot.module} has no firmware here: remove this key"
                raise MisplacedError(firmware_path, slot.firmware, reason)
            self._check_family(index, slot)

    def _check_family(self, index: int, slot: SlotSpec) -> None:
        """Refuse a card that does not fit the controller, if the rack or its program determines one."""
        family = slot.record.family
        controller = _CONTROLLER_OF_EXPORT.get(str(self.program)[-4:].upper(), "")
        if "controller" in self.model_fields_set:
            controller = self.controller
        expected_family = _FAMILIES.get(controller, family)
        if family and family != expected_family:
            cards = ", ".join(name for name, record in OWN.items() if record.family == expected_family)
            problem = f"this card does not fit a {_CONTROLLER_NAMES[controller]}"
            reason = f"{problem}; choose from {cards}, discrete16"
            raise MisplacedError(("slot", index, "module"), slot.module, reason)

    def _check_cams(self) -> None:
        """Refuse a card with inputs that follow a slot without a simulated machine, or a missing switch."""
        machines = {
            slot.number: slot.machine
            for slot in self.slot
            if (slot.has(Trait.MACHINE) or slot.record.unread) and not slot.is_live
        }
        for index, slot in enumerate(self.slot):
            path: KeyPath = ("slot", index, "options", "cam")
            for number in sorted(slot.record.follows(slot.options)):
                if number not in machines:
                    slot_list = ", ".join(map(str, machines)) or "none"
                    reason = f"cam: slot {number} has no simulated stepper; there is one in {slot_list}"
                    raise MisplacedError(path, number, reason)
            for number, switch in slot.record.switches(slot.options):
                machine = machines[number]
                wired_bits = machine.fed_inputs | sum({entry.input.value for entry in machine.timeline})
                if not wired_bits & INPUT_NAMES[switch].value:
                    names = [name for name, bit in INPUT_NAMES.items() if wired_bits & bit.value]
                    problem = f"cam: the machine of slot {number} has no switch {switch!r}"
                    reason = f"{problem}; its switches are {', '.join(names) or 'none'}"
                    raise MisplacedError(path, switch, reason)

    def _check_forces(self) -> None:
        """Refuse a force on an unknown address, or with a value that does not fit it."""
        words = {slot.number: slot.words for slot in self.slot}
        if any(slot.record.unread for slot in self.slot):
            return  # names of bits may be in a module's file, which is not executed
        for index, force in enumerate(self.force):
            path: KeyPath = ("force", index)
            address = _check_at((*path, "address"), force.address, parse_address, force.address, words)
            _check_at((*path, "value"), force.value, check_value, force.address, address, force.value)

    def _check_incidents(self) -> None:
        """Refuse a fault in a wrong or missing slot, on a real line, or with unknown late words."""
        slot_numbers = [slot.number for slot in self.slot]
        slot_list = ", ".join(map(str, slot_numbers))
        for index, incident in enumerate(self.incident):
            path: KeyPath = ("incident", index, "slot")
            if incident.what is FaultKind.PROGRAM_MODE:
                if incident.slot is not None:
                    reason = "the key switch of the CPU has no slot: remove this key"
                    raise MisplacedError(path, incident.slot, reason)
            elif incident.slot is None and len(slot_numbers) > 1:
                raise MisplacedError(path, "", f"is needed: modules sit in {slot_list}")
            elif incident.slot is not None and incident.slot not in slot_numbers:
                reason = f"this slot is empty: modules sit in {slot_list}"
                raise MisplacedError(path, incident.slot, reason)
            elif incident.what in ON_THE_LINE and self._slot_of(incident).is_live:
                reason = "the line of a real port can't be disturbed"
                raise MisplacedError(("incident", index, "what"), incident.what.value, reason)
            elif incident.late_words:
                outputs = len(self._slot_of(incident).words.outputs)
                key_path = ("incident", index, "late_words")
                check_late_words = incident.incident().check_late_words
                _check_at(key_path, list(incident.late_words), check_late_words, outputs)

    def _slot_of(self, incident: InjectedFaultSpec) -> SlotSpec:
        """Return the slot of a fault; without the key `slot`, the first one."""
        return next(slot for slot in self.slot if slot.number == (incident.slot or self.slot[0].number))

    def _check_units(self) -> None:
        """Refuse two units with the same address."""
        addresses: set[int] = set()
        for index, unit in enumerate(self.unit):
            if unit.address in addresses:
                path: KeyPath = ("unit", index, "address")
                raise MisplacedError(path, unit.address, f"address {unit.address} is used twice")
            addresses.add(unit.address)


def _check_at(path: KeyPath, value: object, check: Callable[..., Result], *arguments: Any) -> Result:
    """Return `check(*arguments)`; raise its ValueError as a `MisplacedError` for the value at `path`."""
    try:
        return check(*arguments)
    except ValueError as error:
        reason = error.reason if isinstance(error, SiteError) else str(error)
        raise MisplacedError(path, value, reason) from None
