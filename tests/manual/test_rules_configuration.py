"""Configuration mode, rule by rule [chapter 3; chapter 6, Configuration Error].

The usual configuration is 843Eh 003Fh 1 0: external, home, emergency stop and both limits used, all
active high, step and direction (bit 10), starting speed 1000.
"""

from __future__ import annotations

import pytest
from bench3601 import BACKPLANE_PROXIMITY as BACKPLANE
from bench3601 import CAPTURE, CONFIGURATION, DIAGNOSTIC, ENCODER, HOME_CW, MARKER, Bench
from bench3601 import configuration as config
from refusals3601 import goes

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])

HOME, LIMITS, CW_ONLY, CCW_ONLY = 0x0004, 0x0030, 0x0020, 0x0010  # the last two: what to drop
PULSES = 0x0400  # step and direction; without it CW and CCW pulses
REJECTED = {"CONFIG_ERROR", "MODULE_OK", "MODE_CONFIG"}
ACCEPTED = {"MODULE_OK", "MODE_CONFIG"}


def speed(msw: int, lsw: int) -> tuple[int, ...]:
    """The usual configuration with the starting speed in these words."""
    return (*CONFIGURATION[:2], msw, lsw, 0, 0, 0, 0)


def word(number: int, value: int) -> tuple[int, ...]:
    """The usual configuration with another word 4 to 7."""
    return tuple(value if at == number else CONFIGURATION[at] for at in range(8))


def row(what: str, rules: str, broken: tuple[int, ...], legal: tuple[int, ...], also: str = ""):
    """A row: rules broken, words that break them, nearest words that do not; rules that say so, too."""
    marks = pytest.mark.rules(*rules.split(), *also.split(), "CER-02", "CFG-30")
    return pytest.param(rules.split(), broken, legal, id=what, marks=marks)


BOTH = config(add=ENCODER | DIAGNOSTIC)
MARKED = MARKER | ENCODER
TWICE_MARKED = config(add=MARKED | BACKPLANE)
TWO_TRAINS = config(add=DIAGNOSTIC, drop=PULSES)

INVALID = [
    row("1 no home", "CFG-01", config(drop=HOME), CONFIGURATION),
    row("1 no proximity", "CFG-01", config(add=BACKPLANE, drop=HOME), config(add=BACKPLANE)),
    row("2 no limit, but CW", "CFG-02", config(drop=LIMITS), config(drop=CW_ONLY)),
    row("2 no limit, but CCW", "CFG-02", config(drop=LIMITS), config(drop=CCW_ONLY)),
    row("3 not with feedback", "CFG-03", BOTH, config(add=ENCODER)),
    row("3 not with encoder", "CFG-03", BOTH, config(add=DIAGNOSTIC)),
    row("4 marker alone", "CFG-04", config(add=MARKER), config(add=MARKED), "CFG-21"),
    row("4 feedback", "CFG-04", config(add=MARKER | DIAGNOSTIC), config(add=DIAGNOSTIC), "CFG-21"),
    row("5 not two trains", "CFG-05", TWO_TRAINS, config(add=DIAGNOSTIC), "CFG-22"),
    row("5 not feedback", "CFG-05", TWO_TRAINS, config(drop=PULSES), "CFG-22"),
    row("6 speed 0", "CFG-06", speed(0, 0), speed(0, 1), "CFG-26"),
    row("6 speed 1,000,001", "CFG-06", speed(1000, 1), speed(1000, 0), "CFG-26"),
    row("6 speed -1000", "CFG-06", speed(-1, 0), speed(1, 0)),
    row("6 and 7 speed -1", "CFG-06 CFG-07", speed(0, -1), speed(0, 1)),
    row("7 LSW 1000", "CFG-07", speed(1, 1000), speed(1, 999)),
    row("7 LSW -1", "CFG-07", speed(1, -1), speed(1, 0)),
    row("7 LSW 1001 and MSW -1", "CFG-07", speed(-1, 1001), speed(0, 1)),
    *(row(f"8 MSW {bit}", "CFG-08", config(add=1 << bit), CONFIGURATION) for bit in (7, 11, 13, 14)),
    *(row(f"8 LSW {at}", "CFG-08", config(levels=0x3F | 1 << at), CONFIGURATION) for at in range(6, 16)),
    row("9 marker", "CFG-09", config(add=MARKED, drop=HOME), config(add=MARKED | BACKPLANE, drop=HOME)),
    row("10 not backplane", "CFG-10", TWICE_MARKED, config(add=MARKED)),
    row("10 not home", "CFG-10", TWICE_MARKED, config(add=MARKED | BACKPLANE, drop=HOME)),
    *(row(f"11 word {at}: 1", "CFG-11", word(at, 1), CONFIGURATION) for at in (4, 5, 6, 7)),
    *(row(f"11 word {at}: -1", "CFG-11", word(at, -1), CONFIGURATION) for at in (4, 5, 6, 7)),
    row("2 and 11 at once", "CFG-02 CFG-11", (0x840C, 0x3F, 1, 0, 0, 0, 0, 9), CONFIGURATION),
]


def mirror(words) -> list[int]:
    """Input words 0 to 3 as they show these configuration words: bits 13 to 15 are not mirrored."""
    return [words[0] & 0x1FFF, *words[1:4]]


def shown(bench: Bench) -> list[int]:
    return [bench.words[0] & 0x1FFF, *bench.words[1:4]]


@pytest.mark.parametrize(("rules", "broken", "legal"), INVALID)
def test_invalid_configurations(rules, broken, legal):
    """The first thing after power-up: nothing is mirrored (reading A-06); the legal neighbor is."""
    bench = Bench().run(1)
    bench.fired.clear()
    bench.out(*broken).run(5)
    assert (bench.bits, bench.fired) == (REJECTED, [*rules, "CER-02"])
    assert [word & 0xFFFF for word in bench.words] == [0xE000, 0, 0, 0, 0, 0, 4, 1]
    bench.out(*legal).run(5)
    assert (bench.bits, bench.fired) == (ACCEPTED, [*rules, "CER-02"])
    assert shown(bench) == mirror(legal)


@pytest.mark.rules("CFG-30", "CER-02", "CFG-28", "CFG-13", "STS-M13")
def test_a_rejected_configuration_replaces_the_accepted_one():
    """Nothing moves any more until a valid one is sent (readings A-05 to A-07)."""
    bench = Bench.ready()
    bench.out(*config(drop=HOME)).run(5)
    assert bench.bits == REJECTED
    assert shown(bench) == mirror(CONFIGURATION)
    bench.idle(5)
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}
    bench.relative(100, ms=50).idle().reset_errors()
    assert (bench.bits, bench.position) == ({"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}, 0)
    bench.out(*CONFIGURATION).run(5)
    assert bench.bits == ACCEPTED
    bench.idle(5)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID"}
    goes(bench)


@pytest.mark.rules("CFG-30", "CFG-16")
def test_words_are_judged_in_every_scan_of_configuration_mode():
    """A program that writes word by word sees errors that pass (reading A-08)."""
    bench = Bench().out(0x843E).run(2)
    assert bench.bits == REJECTED
    bench.out(0x843E, 0x003F).run(2)
    assert (bench.bits, shown(bench)) == (REJECTED, [0, 0, 0, 0])
    bench.out(0x843E, 0x003F, 12).run(0.25)
    assert (bench.bits, shown(bench)) == (ACCEPTED, [0x043E, 0x003F, 12, 0])
    bench.out(0x843E, 0x003F, 12, 345).run(0.25)
    assert (bench.bits, shown(bench)) == (ACCEPTED, [0x043E, 0x003F, 12, 345])
    bench.out(0x843E, 0x003F, 12, 1000).run(0.25)
    assert (bench.bits, shown(bench)) == (REJECTED, [0x043E, 0x003F, 12, 345])


@pytest.mark.rules("CFG-30", "CER-02")
def test_words_that_stay_are_not_judged_again():
    """Whatever the inputs do meanwhile: the rule is named once."""
    bench = Bench.ready().out(*config(drop=HOME)).run(2)
    for level in (1, 0, 1):
        bench.inputs(external=level).run(2)
    assert (bench.bits, bench.fired) == (REJECTED, ["CFG-01", "CER-02"])


@pytest.mark.rules("CFG-30")
def test_switch_a_rejected_configuration_is_mirrored_too():
    """Option `mirror_rejected_config` (reading A-06)."""
    bench = Bench(mirror_rejected_config=True).out(*config(drop=HOME, start=12_345)).run(2)
    assert (bench.bits, shown(bench)) == (REJECTED, [0x043A, 0x003F, 12, 345])


@pytest.mark.rules("CFG-29", "CER-02")
@pytest.mark.parametrize("firmware", ["2.0", "2.1", "2.2", "3.1", "4.1"])
def test_revision_0_1_capture_without_encoder(firmware):
    """Capture of the position came with 2.1; with an encoder capture was always legal."""
    alone = Bench(firmware).out(*config(add=CAPTURE)).run(2)
    if firmware == "2.0":
        assert (alone.bits, alone.fired) == (REJECTED, ["CER-01", "CFG-29", "CER-02"])
    else:
        assert (alone.bits, alone.fired) == (ACCEPTED, ["CER-01"])
    counting = Bench(firmware).out(*config(add=CAPTURE | ENCODER)).run(2)
    assert (counting.bits, counting.fired) == (ACCEPTED, ["CER-01"])


# -- the mode -------------------------------------------------------------------------------------


@pytest.mark.rules("CFG-12", "CER-01", "STS-M13", "STS-M14")
def test_power_up_is_command_mode_with_a_configuration_error():
    """6400h: Module OK (14), Configuration Error (13), Position Invalid (10; reading A-04)."""
    bench = Bench()
    assert bench.words == [0x6400, 0, 0, 0, 0, 0, 0, 0]
    assert bench.run(5).words == [0x6400, 0, 0, 0, 0, 0, 0, 0]
    assert bench.fired == ["CER-01"]


@pytest.mark.rules("CFG-28", "CFG-13", "CER-01")
@pytest.mark.parametrize("bit", range(15))
def test_nothing_works_before_a_configuration(bit):
    """Whatever is commanded, the image stays that of power-up and the motor stands still."""
    bench = Bench()
    bench.command(1 << bit, 0 if bit in (5, 6) else 500).run(100)
    assert (bench.words, bench.module.machine.shaft) == ([0x6400, 0, 0, 0, 0, 0, 0, 0], 0)
    bench.idle(5)
    assert (bench.words, bench.fired) == ([0x6400, 0, 0, 0, 0, 0, 0, 0], ["CER-01"])


@EVERY_SCAN
@pytest.mark.rules("CFG-15", "STS-M15", "CFG-16", "IOM-07", "IOM-08", "CFG-27")
def test_bit_15_selects_the_mode(scan_ms):
    """Mirror of words 0 to 3, zeros in 4 and 5 though the encoder counts, firmware in 6 and 7."""
    bench = Bench("3.1", scan_ms=scan_ms).run(2)
    bench.out(*config(add=ENCODER, levels=0x3B, start=12_345)).run(scan_ms)
    bench.turn_encoder(77, 10)
    assert [word & 0xFFFF for word in bench.words] == [0xC53E, 0x003B, 12, 345, 0, 0, 3, 1]
    bench.idle(scan_ms)
    assert [word & 0xFFFF for word in bench.words] == [0x4400, 0x0004, 0, 0, 0, 77, 0, 0]
    bench.inputs(home=1).run(2)  # active low here
    # the starting speed of words 2 and 3: 12,345 steps in a second without ramps
    bench.relative(12_345, speed=12_345)
    assert bench.until("MOVE_COMPLETE") == pytest.approx(1000, abs=scan_ms)


@pytest.mark.rules("CFG-27", "IOM-08")
@pytest.mark.parametrize("firmware", ["2.0", "2.1", "2.2", "3.1", "4.1"])
def test_firmware_revision_in_words_6_and_7(firmware):
    bench = Bench(firmware).out(*CONFIGURATION).run(2)
    assert bench.words[6:] == [int(part) for part in firmware.split(".")]


@pytest.mark.rules("IOM-09")
def test_bits_13_to_15_are_status_in_either_mode():
    """A configuration word with bits 13 and 14 is invalid; the input bits show what is the case."""
    bench = Bench(mirror_rejected_config=True).out(0xE43E, 0x3F, 1).run(2)
    assert bench.words[0] & 0xFFFF == 0xE43E  # error: 13; OK: 14; mode: 15
    bench.out(0x843E, 0x3F, 1).run(2)
    assert bench.words[0] & 0xFFFF == 0xC43E  # no error any more, still OK
    bench.out(0xC43E, 0x3F, 1).run(2)
    assert bench.words[0] & 0xFFFF == 0xE43E  # bit 14 was sent, bit 13 was not
    bench.out(0x643E, 0x3F, 1).run(2)
    assert bench.words[0] & 0xFFFF == 0x6400  # bit 15 was not sent: command mode


@pytest.mark.rules("CFG-17", "CFG-15", "IOM-08", "POS-01", "STS-M10")
def test_leaving_configuration_mode_makes_the_position_zero_and_invalid():
    bench = Bench.ready(position=4_321, config=config(add=ENCODER))
    bench.out(0x0400, 0, 0, 99).run(2)  # Preset Encoder
    bench.out(*config(add=ENCODER)).run(2)
    assert bench.words[4:6] == [0, 0]
    bench.fired.clear()
    bench.idle(2)
    assert (bench.position, bench.bits) == (0, {"MODULE_OK", "POSITION_INVALID"})
    assert (bench.fired, bench.encoder) == (["POS-01"], 99)


@pytest.mark.rules("IOM-19")
def test_a_bit_of_the_configuration_word_is_no_edge_of_a_command():
    """843Eh has the bits of a relative move and of Find Home; they start nothing (reading A-11)."""
    for command in (0x0002, HOME_CW):
        bench = Bench().out(*CONFIGURATION).run(2)
        bench.command(command, 0 if command == HOME_CW else 500, ms=20)
        assert bench.bits == {"MODULE_OK", "POSITION_INVALID"}
        bench.idle().command(command, 0 if command == HOME_CW else 500, ms=20)
        assert "MOVING_CW" in bench.bits


@pytest.mark.rules("CFG-15", "IOM-19")
def test_a_command_may_come_in_the_image_that_leaves_configuration_mode():
    """Bit 7 was 0 in the configuration word, so a manual move starts at once."""
    bench = Bench().out(*CONFIGURATION).run(2)
    bench.manual(ms=1)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "MOVING_CW", "ACCELERATING"}
