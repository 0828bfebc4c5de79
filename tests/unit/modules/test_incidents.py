"""Incidents: what a rack file says of them, and what module and CPU see."""

import re

import pytest
from scanrack.io_images.amci3601 import StatusMsw
from scanrack.io_images.image import Image
from scanrack.jobs import build_cpu, build_rack
from scanrack.runtime import Amci3601, FaultKind, InjectedFault, RackFileError, RackSpec, load_rack_file
from scanrack.runtime.loop.exposed import ExposedModule
from scanrack.runtime.loop.module_fault import ModuleFault

MS = 1_000_000
CONFIGURE = Image([-31682, 63, 1, 0, 0, 0, 0, 0])  # 843E hex: all inputs in use; starting speed 1000
RELATIVE = Image([2, 0, 10, 0, 5, 0, 20, 10])  # 10,000 steps at 5,000 steps/s
OLD, NEW = Image([1, 2, 3, 4, 5, 6, 7, 8]), Image([11, 12, 13, 14, 15, 16, 17, 18])


class Listening:
    """A module that notes what it is told."""

    def __init__(self):
        self.events = []
        self.seen = []

    def update(self, now_ns, outputs):
        self.seen.append((now_ns // MS, list(outputs)))
        return Image()

    def plc_run(self, running):
        self.seen.append(running)

    def power_cycle(self):
        self.seen.append("power")


def exposed(*incidents):
    module = Listening()
    return module, ExposedModule(module, incidents)


def test_a_torn_update_brings_late_words_an_rpi_after_the_others():
    module, slot = exposed(InjectedFault(3 * MS, FaultKind.TORN_UPDATE, late_words=(0, 5)))
    slot.update(2 * MS, OLD)  # OLD was in force from 0
    slot.update(4 * MS, OLD)  # nothing new since the incident is due
    slot.update(9 * MS, NEW)  # in force from 4 ms on
    torn = [1, 12, 13, 14, 15, 6, 17, 18]
    assert module.seen[2:] == [(6, torn), (9, list(NEW))]
    assert [event.fields for event in slot.events] == [{"late_words": [0, 5]}]


def test_a_torn_update_lasts_as_long_as_it_says_whatever_the_calls():
    incident = InjectedFault(0, FaultKind.TORN_UPDATE, for_ns=3 * MS, late_words=(7,))
    module, slot = exposed(incident)
    for now in (1, 2, 3, 4):
        slot.update(now * MS, NEW)
    torn = [*list(NEW)[:7], 0]
    assert module.seen == [(1, torn), (2, torn), (3, torn), (4, list(NEW))]


def test_power_is_cycled_at_its_instant_between_two_updates():
    module, slot = exposed(InjectedFault(3 * MS, FaultKind.POWER_CYCLE))
    slot.update(10 * MS, OLD)
    assert module.seen == [(3, list(OLD)), "power", (10, list(OLD))]


def moving(incident, until_ms=240):
    """A 3601 in a move that started at 40 ms, with an incident in between."""
    slot = ExposedModule(Amci3601(), [incident])
    slot.update(20 * MS, CONFIGURE)
    slot.update(40 * MS, Image())
    return slot, slot.update(until_ms * MS, RELATIVE)


def test_a_lost_link_freezes_the_inputs_and_comes_back():
    incident = InjectedFault(100 * MS, FaultKind.LINK_LOST, for_ns=300 * MS)
    slot, frozen = moving(incident)
    # 60 ms into the ramp of 20 steps/ms/s from 1,000: 60 ms + 20,000/2 * 0.06^2 s = 96 steps
    assert frozen[3] == 96
    after = slot.update(500 * MS, RELATIVE)
    assert after[0] & StatusMsw.POSITION_INVALID.value  # as if the PLC had left run mode
    told = [(event.at_ns // MS, event.name) for event in slot.events if event.kind == "stimulus"]
    assert told == [(100, "link-lost"), (400, "link-lost")]


def test_a_fatal_error_ends_with_a_power_cycle():
    incident = InjectedFault(100 * MS, FaultKind.FATAL_ERROR, for_ns=100 * MS)
    slot, image = moving(incident, until_ms=150)
    # MODULE_OK goes, and so do the bits of motion: all others were 0 but POSITION_INVALID
    assert image[0] == StatusMsw.POSITION_INVALID.value
    image = slot.update(200 * MS, RELATIVE)  # powered up at this instant
    assert list(image) == list(Amci3601().update(0, Image()))


def test_troubles_may_overlap_and_the_worst_one_holds():
    link = InjectedFault(10 * MS, FaultKind.LINK_LOST, for_ns=60 * MS)
    fatal = InjectedFault(20 * MS, FaultKind.FATAL_ERROR, for_ns=20 * MS)
    out = InjectedFault(30 * MS, FaultKind.REMOVED, for_ns=5 * MS)
    module = Amci3601()
    slot = ExposedModule(module, [link, fatal, out])
    seen = []
    for now in (5, 15, 25, 32, 37, 45, 75):
        slot.update(now * MS, Image())
        seen.append(module.trouble.value if module.trouble else None)
    # taken out, the module forgets its fatal error
    assert seen == [None, "link-lost", "fatal-error", "removed", "link-lost", "link-lost", None]


def test_a_power_cycle_ends_a_fatal_error_only():
    module = Amci3601()
    fatal, link = InjectedFault(0, FaultKind.FATAL_ERROR), InjectedFault(0, FaultKind.LINK_LOST)
    slot = ExposedModule(module, [fatal, link, InjectedFault(10 * MS, FaultKind.POWER_CYCLE)])
    slot.update(5 * MS, Image())
    assert module.trouble is ModuleFault.FATAL_ERROR
    slot.update(15 * MS, Image())
    assert module.trouble is ModuleFault.LINK_LOST


def test_a_module_that_cannot_fail_is_refused():
    with pytest.raises(ValueError, match="link-lost does not apply to Listening"):
        exposed(InjectedFault(0, FaultKind.LINK_LOST))


RACK = """program = "line.py"
[[slot]]
number = 3
module = "amci3601"
[[incident]]
"""


def loaded(tmp_path, text):
    file = tmp_path / "rack.toml"
    file.write_text(text, encoding="utf-8")
    return load_rack_file(file).spec


def test_a_rack_file_says_what_happens(tmp_path):
    spec = loaded(tmp_path, RACK + 'at_s = 1.5\nwhat = "removed"\nfor_ms = 20')
    assert spec.incidents == (InjectedFault(1500 * MS, FaultKind.REMOVED, 3, 20 * MS),)


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ('at_s = 1\nwhat = "lost"', "what"),
        ('what = "removed"', "write one of at_ms and at_s"),
        ('at_s = 1\nwhat = "torn-update"', "name the words that arrive late"),
        ('at_s = 1\nwhat = "torn-update"\nlate_words = [8]', "0 to 7"),
        ('at_s = 1\nwhat = "removed"\nslot = 1', "this slot is empty: modules sit in 3"),
        ('at_s = 1\nwhat = "program-mode"\nslot = 3', "has no slot: remove this key"),
        ('at_s = 1\nwhat = "removed"\nhow = 3', "unknown key"),
    ],
)
def test_mistakes_are_told_with_their_line(tmp_path, keys, says):
    with pytest.raises(RackFileError, match=says) as caught:
        loaded(tmp_path, RACK + keys)
    (line,) = re.findall(r"rack\.toml:(\d+): ", str(caught.value))
    assert 5 <= int(line) <= 5 + len(keys.splitlines())


def test_the_only_slot_of_a_rack_is_on_a_real_port(tmp_path):
    rack = RACK.replace('module = "amci3601"', 'module = "pcl601-adapter"\nport = "tcp:localhost:4001"')
    says = r'rack\.toml:8: incident\.what = "line-down": the line of a real port can\'t be disturbed'
    with pytest.raises(RackFileError, match=says):
        loaded(tmp_path, rack + 'at_s = 1\nwhat = "line-down"')


def test_the_key_is_turned_to_program_and_back():
    modes = []

    class Modes:
        def event(self, scan, now_ns, topic, fields):
            if topic == "/cpu":
                modes.append((now_ns // MS, fields["mode"]))

        def scan(self, scan, now_ns, flags):
            pass

        def close(self):
            pass

    def logic(scan):
        """Rest."""

    spec = RackSpec.model_validate(
        {
            "program": logic,
            "slot": [{"number": 1, "module": "amci3601"}],
            "incident": [{"at_ms": 20, "what": "program-mode", "for_ms": 10}],
        }
    )
    cpu = build_cpu(spec, logic, build_rack(spec), listeners=[Modes()])
    cpu.run(30)
    # the scan at 20 ms is the last in run mode, that at 30 ms the last in program mode
    assert modes == [(0, "run"), (22, "program"), (32, "run")]
