"""A rack as typed objects: from a file or in Python, and the CPU that is built of it."""

from decimal import Decimal
from fractions import Fraction
from typing import Any, cast

import pytest
from pydantic import ValidationError
from scanrack.io_images.amci3601 import InputBit
from scanrack.jobs import build_cpu, build_rack
from scanrack.jobs.load.building import slot_seed
from scanrack.runtime import Amci3601, CpuFault, CpuMode, RackSpec, SlotSpec, load_rack_file
from scanrack.runtime.config.rackspec import ForceSpec
from scanrack.runtime.machine import EncoderSpec, Jam, MachineSpec, Slip, Station, Switch, TimelineEntry
from scanrack.runtime.modules.record import ModuleRecord
from scanrack.runtime.modules.registry import MODULES

MS = 1_000_000

FULL = """
program = "line.py:cycle"
scan_ms = 0.25
controller = "compactlogix"
rpi_ms = 1.5
watchdog_ms = 0
run_for_s = 0.1
seed = 9
mode = "test"

[[slot]]
number = 3
module = "amci3601"
firmware = "3.1"
wiring = "diagnostic"
options.input_scan_us = 500

[slot.machine]
switches = [
  { input = "home", first = 3000, last = 3500 },
  { input = "CW_LIMIT", first = 9000, normally_closed = true },
  { input = "ccw_limit", last = -9000 },
]
timeline = [
  { at_s = 3.2, input = "estop", for_ms = 50 },
  { at_ms = 0, input = "external", energized = true },
  { at_ms = 0.5, input = "external", energized = false, for_s = 1 },
  { at_s = 1, input = "home", energized = "wired" },
]
encoder = { counts_per_step = "4/3", direction = -1, marker_every = 4000, marker_at = 7 }
slips = [{ at = 100, steps = 5, times = "always", chance = 0.25 }, { at = 1, steps = 2, direction = -1 }]
jams = [{ at = 20_000, direction = 1 }]
stations = [{ position = 4000, input = "capture", work_s = 2, pulse_ms = 20 }]

[[force]]
address = "slot3.status.IN_CAPTURE"
value = true
"""

MACHINE = MachineSpec(
    switches=(
        Switch(InputBit.HOME, 3000, 3500),
        Switch(InputBit.CW_LIMIT, 9000, None, normally_closed=True),
        Switch(InputBit.CCW_LIMIT, None, -9000),
    ),
    timeline=(
        TimelineEntry(3200 * MS, InputBit.ESTOP, True),
        TimelineEntry(3250 * MS, InputBit.ESTOP, False),
        TimelineEntry(0, InputBit.EXTERNAL, True),
        TimelineEntry(500_000, InputBit.EXTERNAL, False),
        TimelineEntry(1000 * MS + 500_000, InputBit.EXTERNAL, True),
        TimelineEntry(1000 * MS, InputBit.HOME, None),
    ),
    encoder=EncoderSpec(Fraction(4, 3), -1, 4000, 7),
    slips=(Slip(100, 5, times=None, chance=Fraction(1, 4)), Slip(1, 2, -1)),
    jams=(Jam(20_000, 1),),
    stations=(Station(4000, InputBit.CAPTURE, 2000 * MS, 20 * MS),),
)


SLOT = SlotSpec(number=1, module="amci3601")


@pytest.fixture
def full(tmp_path):
    path = tmp_path / "line.toml"
    path.write_text(FULL, "utf-8")
    return load_rack_file(path)


def test_a_rack_file_means_the_same_as_the_objects(full):
    assert full.spec == RackSpec(
        program="line.py:cycle",
        scan_ms=Decimal("0.25"),
        controller="compactlogix",
        rpi_ms=Decimal("1.5"),
        watchdog_ms=Decimal(0),
        run_for_s=Decimal("0.1"),
        seed=9,
        mode="test",
        slot=(
            SlotSpec(
                number=3,
                module="amci3601",
                firmware="3.1",
                wiring="diagnostic",
                options={"input_scan_us": 500},
                machine=MACHINE,
            ),
        ),
        force=(ForceSpec(address="slot3.status.IN_CAPTURE", value=1),),
    )
    assert full.text == FULL


def test_times_are_exact(full):
    assert (full.spec.scan_ns, full.spec.rpi_ns) == (250_000, 1_500_000)
    assert RackSpec(program="line.py", slot=(SLOT,), scan_ms=cast(Any, 0.1)).scan_ns == 100_000
    assert RackSpec(program="line.py", slot=(SLOT,)).rpi_ns == 2_000_000


def test_a_short_rack_file_has_defaults(tmp_path):
    path = tmp_path / "line.toml"
    path.write_text('program = "line.py"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', "utf-8")
    assert load_rack_file(path).spec == RackSpec(
        program="line.py",
        name="rack",
        scan_ms=Decimal(2),
        controller="micrologix",
        watchdog_ms=Decimal(500),
        mode="run",
        slot=(SlotSpec(number=1, module="amci3601", firmware="4.1", machine=MachineSpec()),),
    )


def test_the_rack_is_built_as_described(full):
    rack = build_rack(full.spec)
    slot = rack.slots[3]
    assert (slot.number, slot.catalog, slot.firmware) == (3, "amci3601", "3.1")
    module = slot.module
    assert isinstance(module, Amci3601)
    assert (str(module.firmware), module.options.input_scan_us, module.machine.spec) == ("3.1", 500, MACHINE)


def test_the_cpu_is_built_as_described(full):
    called = []
    cpu = build_cpu(full.spec, lambda scan: called.append(scan.now_ns), build_rack(full.spec))
    assert (cpu.mode, cpu.period_ns) == (CpuMode.TEST, 250_000)
    assert cpu.forces.active == {"Local:3:I.Data[1].0": 1}
    cpu.run(3)
    assert called == [0, 250_000, 500_000]


@pytest.mark.parametrize(("controller", "seen"), [("micrologix", [0, 1, 2]), ("compactlogix", [0, 0, 2])])
def test_the_controller_decides_when_images_are_exchanged(monkeypatch, controller, seen):
    """Scans every ms; an input that shows the time changes with every scan, or every RPI of 2 ms."""
    updates = []

    def update(self, now_ns, outputs):
        updates.append(now_ns)
        self._image.words[7] = now_ns // MS
        return self._image

    monkeypatch.setattr(Amci3601, "update", update)
    spec = RackSpec(program="-", scan_ms=Decimal(1), controller=controller, slot=(SLOT,))
    inputs = []
    build_cpu(spec, lambda scan: inputs.append(scan.slot[1].inputs[7]), build_rack(spec)).run(3)
    assert inputs == seen


def test_the_watchdog_is_as_described(monkeypatch):
    spec = RackSpec(program="-", watchdog_ms=Decimal(60), slot=(SLOT,))

    def endless(scan):
        while True:
            pass

    with pytest.raises(CpuFault, match="it took longer than 60"):
        build_cpu(spec, endless, build_rack(spec)).run(1)


def test_a_mistake_in_python_is_refused_where_it_is_made():
    with pytest.raises(ValidationError, match="slot 1 is used twice"):
        RackSpec(program="-", slot=(SLOT, SLOT))
    with pytest.raises(ValidationError, match="option input_scan: the simulated 3601 has no such option"):
        SlotSpec(number=1, module="amci3601", options={"input_scan": 1})


def test_a_specification_cannot_be_changed_later():
    spec = RackSpec(program="-", slot=(SLOT,))
    with pytest.raises(ValidationError, match="frozen"):
        spec.scan_ms = Decimal(1)


def test_a_rack_has_a_slot_at_least():
    with pytest.raises(ValidationError, match="at least 1 item"):
        RackSpec(program="-", slot=())


def test_a_module_that_is_added_again_is_counted_once(monkeypatch):
    monkeypatch.setattr(MODULES, "_added", {})
    names = list(MODULES)
    MODULES.add(MODULES["amci3601"])
    assert list(MODULES) == names
    assert len(MODULES) == len(names) == len(set(names))


def test_a_rack_in_python_may_bring_its_own_modules(monkeypatch):
    made = []

    class Probe:
        def __init__(self, **given):
            made.append(given)
            self.events = []

    monkeypatch.setattr(MODULES, "_added", {})
    MODULES.add(ModuleRecord(name="probe", make=cast(Any, Probe), has_firmware=True))
    spec = RackSpec(program="-", seed=5, slot=(SLOT, SlotSpec(number=2, module="probe", firmware="1")))
    rack = build_rack(spec)
    assert isinstance(rack.slots[2].module, Probe)
    assert made[-1] == {
        "firmware": "1",
        "machine": MachineSpec(),
        "seed": slot_seed(5, 2),
        "options": {},
        "wiring": None,
    }
