"""Every row of what the adapters' controllers can't do: its bits, and that nothing is sent but questions.

A configuration is refused with CONFIG_ERROR; a value that the controller can't run at with INVALID_PROFILE
and COMMAND_ERROR; a function that it lacks with COMMAND_ERROR; the first block of a blend profile with
INVALID_PROFILE; a search for home with HOME_INVALID and COMMAND_ERROR.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import pytest
from adapterbench import (
    CONFIGURE,
    CONFIGURE_006,
    CONFIGURE_DRIVE,
    AdapterBench,
    AdapterBench006,
    AdapterBenchDrive,
    move,
)
from overheard import Overheard
from scanrack.runtime.modules.adapters.amci_drive import amci_drive_capabilities as amci_drive
from scanrack.runtime.modules.adapters.amci_drive.driver import IDLE
from scanrack.runtime.modules.adapters.pcl601 import pcl601_capabilities as pcl601
from scanrack.runtime.modules.adapters.pmc006 import pmc006_capabilities as pmc006

pytestmark = pytest.mark.slow  # together they take seconds

FUNCTION = {"COMMAND_ERROR"}
PROFILE = {"INVALID_PROFILE", "COMMAND_ERROR"}
HOMING = {"HOME_INVALID", "COMMAND_ERROR"}
BLOCK = {"INVALID_PROFILE", "BLEND_ACK"}

WITH_ENCODER = (0x853E, 63, 1, 0)
MANUAL = (128, 0, 0, 0, 2, 0, 100, 100)
BLEND = (0, 256 + 512, 2, 0, 0, 100)
"""Header of two segments, constant acceleration."""

SEGMENTED = {"blend": "segmented"}
AFTER_HEADER = (BLEND, (0, 256))


@dataclass(frozen=True)
class Case:
    """What is refused.

    Attributes:
        row: name of the row.
        words: that are refused.
        bits: error bits and acknowledgment, as they then are; left out for configurations.
        options: of the adapter.
        configuration: before them.
        before: words that come first.
    """

    row: str
    words: Iterable[int]
    bits: set[str] = field(default_factory=set)
    options: Mapping[str, object] = field(default_factory=dict)
    configuration: tuple[int, ...] = ()
    before: tuple[Iterable[int], ...] = ()


CONFIGURATIONS_601 = (
    Case("starting speed", (0x843E, 63, 5, 1)),
    Case("capture input", (0x843F, 63, 1, 0), options={"capture": "reject"}),
    Case("capture input", (0x843F, 63, 1, 0), options={"limit_sense": "inputs"}),
    Case("backplane home proximity", (0x847E, 63, 1, 0)),
    Case("diagnostic feedback", (0x863E, 63, 1, 0)),
    Case("CW/CCW pulses", (0x803E, 63, 1, 0)),
    Case("marker home", (0x953C, 63, 1, 0)),
    Case("normally closed end limit", (0x843E, 63 & ~16, 1, 0)),
    Case("normally closed end limit", (0x843E, 63 & ~32, 1, 0)),
    Case("normally closed home switch or emergency stop", (0x843E, 63 & ~4, 1, 0)),
    Case("normally closed home switch or emergency stop", (0x843E, 63 & ~8, 1, 0)),
)

COMMANDS_601 = (
    Case("encoder move", (2, 4, 0, 100, 5, 0, 20, 20), PROFILE, configuration=WITH_ENCODER),
    Case("encoder follower", (0, 128, 1, 1), FUNCTION, configuration=WITH_ENCODER),
    Case("blend move", BLEND, BLOCK),
    Case("speed change", (*MANUAL[:4], 3, 0, 100, 100), PROFILE | {"STOPPED"}, before=(MANUAL,)),
    Case("speed", move(10, 50_001), PROFILE),
    Case("speed", (128, 0, 0, 0, 50, 1, 20, 20), PROFILE),
    Case("speed", (32, 0, 0, 0, 50, 1, 20, 20), PROFILE),
    Case("speed", (128, 0, 0, 0, 0, 1), PROFILE),
    Case("speed", (0, 256 + 512, 4, 0, 50, 1, 100), PROFILE | BLOCK, SEGMENTED, before=AFTER_HEADER),
    Case("different rates", move(10, 5000, 20, 10), PROFILE, {"strict": True}),
    Case("distance", move(-8_388_608), PROFILE),
    Case("registration distance", (128, 0, 1, 199, 5, 0, 10, 20), PROFILE),
)

CONFIGURATIONS_006 = (
    Case("home_stroke", CONFIGURE_006, options={"home_stroke": None}),
    Case("starting speed", (0x843C, 63, 0, 64)),
    Case("starting speed", (0x843C, 63, 30, 1)),
    Case("capture input", (0x843D, 63, 1, 0)),
    Case("external input", (0x843E, 63, 1, 0)),
    Case("FSET", (0x843E, 63, 1, 0), options={"hold": "immediate"}),
    Case("FSET", (0x843D, 63, 1, 0), options={"capture": "fset"}),
    Case("backplane home proximity", (0x847C, 63, 1, 0)),
    Case("encoder", (0x853C, 63, 1, 0)),
    Case("diagnostic feedback", (0x863C, 63, 1, 0)),
    Case("levels of home switch and CCW limit", (0x843C, 63 & ~32, 1, 0)),
)

COMMANDS_006 = (
    Case("blend move", BLEND, BLOCK),
    Case("registration move", (128, 0, 0, 500, 5, 0, 100, 100), PROFILE),
    Case("speed change", (*MANUAL[:4], 3, 0, 100, 100), PROFILE | {"STOPPED"}, before=(MANUAL,)),
    Case("hold", (4,), FUNCTION | {"MOVING_CW"}, before=(move(10_000, 2000),)),
    Case("find home CW", (32, 0, 0, 0, 2, 0, 20, 20), HOMING),
    Case("speed", move(10, 256_001), PROFILE),
    Case("speed", (64, 0, 0, 0, 256, 1, 20, 20), PROFILE),
    Case("speed", (128, 0, 0, 0, 0, 64), PROFILE),
    Case("rate", move(10, 5000, 20, 5), PROFILE),
    Case("rate", move(10, 5000, 5, 20), PROFILE),
    Case("rate", (128, 0, 0, 0, 5, 0, 20, 5), PROFILE),
    Case("final deceleration", (*BLEND[:5], 5), PROFILE | BLOCK, SEGMENTED),
    Case("acceleration", (0, 256 + 512, 4, 0, 3, 0, 5), PROFILE | BLOCK, SEGMENTED, before=AFTER_HEADER),
    Case("ramps", move(10, 5000), PROFILE, {"strict": True}),
    Case("registration distance", (128, 0, 0, 404, 5, 0, 100, 100), PROFILE, {"registration": "polled"}),
)

CONFIGURATIONS_DRIVE = (
    Case("inputs", CONFIGURE_006),
    Case("one input twice", CONFIGURE_DRIVE, options={"in2": "home", "unwired": "inactive"}),
    Case("encoder", (0x8514, 63, 1, 0), options={"counts_per_turn": 0}),
    Case("backplane home proximity", (0x8454, 63, 1, 0)),
    Case("diagnostic feedback", (0x8614, 63, 1, 0)),
    Case("marker home", (0x9514, 63, 1, 0)),
)

ENCODER_OF_THE_DRIVE = (0x8514, 63, 1, 0)

COMMANDS_DRIVE = (
    Case("encoder move", (2, 4, 0, 100, 5, 0, 20, 20), PROFILE, configuration=ENCODER_OF_THE_DRIVE),
    Case("encoder follower", (0, 128, 1, 1), FUNCTION, configuration=ENCODER_OF_THE_DRIVE),
    Case("home input", (32, 0, 0, 0, 5, 0, 20, 20), HOMING, {"in1": "none", "unwired": "inactive"}),
    Case("speed", (128, 0, 0, 0, 0, 500, 20, 20), PROFILE),
    Case("S-curve in a blend move", (*BLEND[:4], 1, 100), BLOCK),
    Case("S-curve in a blend move", (*BLEND[:5], 100 | 0x4000), BLOCK),
    Case("S-curve in a registration move", (128, 1, 2, 0, 5, 0, 100, 100), PROFILE),
    Case("S-curve", (2, 1, 20, 0, 1000, 0, 1, 1), PROFILE),
    Case("S-curve", (2, 1, 20, 0, 5, 0, 30, 20), PROFILE, {"strict": True}),
    Case("distance", move(-8_388_608), PROFILE),
)

UNREACHED = {"encoder move", "encoder follower", "preset encoder", "marker home"}
"""On a PMC006: without an encoder, which it has not, the 3601's own rules are first."""

QUESTIONS = {AdapterBench: (3, 4), AdapterBench006: tuple(b"jcxO")}
"""Functions of Modbus, the second byte of a frame, and instructions, the third, that change nothing."""

NOTHING = b"".join(word.to_bytes(2, "big") for word in IDLE)
"""The words that a drive gets with each question while no command is on."""


def only_asks(bench: AdapterBench, frames: Iterable[tuple[bytes, str]]) -> bool:
    if isinstance(bench, AdapterBenchDrive):
        return all(frame[7] == 4 or (frame[7] == 23 and frame[17:] == NOTHING) for frame, _ in frames)
    place = 2 if isinstance(bench, AdapterBench006) else 1
    return all(frame[place] in QUESTIONS[type(bench)] for frame, _ in frames)


def each(kind: type[AdapterBench], cases: Iterable[Case]) -> list[object]:
    return [pytest.param(kind, case, id=f"{kind.__name__}-{case.row}") for case in cases]


@pytest.mark.parametrize(
    ("kind", "case"),
    [
        *each(AdapterBench, CONFIGURATIONS_601),
        *each(AdapterBench006, CONFIGURATIONS_006),
        *each(AdapterBenchDrive, CONFIGURATIONS_DRIVE),
    ],
)
def test_a_configuration_is_refused_before_anything_is_sent(kind, case):
    bench = kind(**case.options).run(200)
    heard = Overheard(bench)
    bench.give(*case.words, ms=600)
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "MODE_CONFIG"}
    assert bench.reasons == [case.row]
    assert only_asks(bench, heard.frames)


@pytest.mark.parametrize(
    ("kind", "case"),
    [
        *each(AdapterBench, COMMANDS_601),
        *each(AdapterBench006, COMMANDS_006),
        *each(AdapterBenchDrive, COMMANDS_DRIVE),
    ],
)
def test_a_command_is_refused_before_anything_is_sent(kind, case):
    bench = kind(**case.options).configured(*case.configuration)
    for words in case.before:
        bench.give(*words, ms=500)
    at_rest = "MOVING_CW" not in bench.bits
    heard = Overheard(bench)
    bench.give(*case.words)
    assert bench.bits == {"MODULE_OK"} | case.bits
    assert bench.reasons == [case.row]
    if at_rest:
        assert only_asks(bench, heard.frames)
        assert bench.motor == 0


@pytest.mark.parametrize(
    ("room", "cases", "unreached"),
    [
        (pcl601, CONFIGURATIONS_601 + COMMANDS_601, set()),
        (pmc006, CONFIGURATIONS_006 + COMMANDS_006, UNREACHED),
        (amci_drive, CONFIGURATIONS_DRIVE + COMMANDS_DRIVE, set()),
    ],
    ids=["PCL601", "PMC006", "drive"],
)
def test_every_row_has_a_case(room, cases, unreached):
    rows = Counter(row.name for row in (*room.CONFIGURATION_ROWS, *room.COMMAND_ROWS))
    assert rows - Counter(case.row for case in cases) == Counter(unreached)


@pytest.mark.parametrize(
    ("words", "bits"),
    [((2, 4, 0, 100, 5, 0, 20, 20), PROFILE), ((0, 128, 1, 1), FUNCTION), ((1024,), FUNCTION)],
    ids=["encoder move", "encoder follower", "preset encoder"],
)
def test_without_an_encoder_the_3601_itself_refuses_with_the_same_bits(words, bits):
    bench = AdapterBench006().configured().give(*words)
    assert bench.bits == {"MODULE_OK"} | bits
    assert bench.reasons == []


@pytest.mark.parametrize("words", [CONFIGURE, (0x843E, 63, 0, 1), (0x843E, 63, 5, 0)])
def test_what_a_pcl601_can_just_do_is_not_refused(words):
    bench = AdapterBench().give(*words, ms=600)
    assert bench.bits >= {"MODULE_OK", "MODE_CONFIG"}
    assert "CONFIG_ERROR" not in bench.bits


@pytest.mark.parametrize("words", [CONFIGURE_DRIVE, (0x8414, 63, 0, 1), (0x8514, 63, 1000, 0)])
def test_what_a_drive_can_just_do_is_not_refused(words):
    bench = AdapterBenchDrive().give(*words, ms=600)
    assert bench.bits >= {"MODULE_OK", "MODE_CONFIG"}
    assert "CONFIG_ERROR" not in bench.bits


@pytest.mark.parametrize("words", [CONFIGURE_006, (0x843C, 63, 0, 65), (0x843C, 63, 30, 0)])
def test_what_a_pmc006_can_just_do_is_not_refused(words):
    bench = AdapterBench006().give(*words, ms=600)
    assert bench.bits >= {"MODULE_OK", "MODE_CONFIG"}
    assert "CONFIG_ERROR" not in bench.bits


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        (AdapterBench, move(10, 50_000)),
        (AdapterBench, move(10, 2)),
        (AdapterBench, (128, 0, 1, 200, 5, 0, 10, 20)),
        (AdapterBench006, move(10, 256_000, 6, 6)),
        (AdapterBench006, (128, 0, 0, 0, 0, 65)),
        (AdapterBenchDrive, move(10, 1_000_000, 2000, 2000)),
        (AdapterBenchDrive, (128, 0, 1, 200, 5, 0, 20, 10)),
    ],
)
def test_a_command_at_the_edge_of_what_it_can_is_carried_out(kind, words):
    bench = kind().configured()
    if list(words)[4:6] == [0, 2]:
        bench = kind().configured(0x843E, 63, 0, 1)
    assert bench.give(*words, ms=1500).reasons == []
    assert bench.motor > 0
