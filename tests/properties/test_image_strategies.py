"""The public strategies make what they say, and shrink to what a person would write."""

from __future__ import annotations

import pytest
from bench3601 import Bench
from hypothesis import find, given, settings
from hypothesis import strategies as st
from scanrack.io_images import Image
from scanrack.io_images import strategies as images
from scanrack.io_images.amci3601 import KNOWN, RULES, Configuration, Firmware, check, decode
from scanrack.io_images.amci3601.configuration import INVALID_CONFIGURATIONS

OLDEST = Firmware(2, 0)
EVERY_RULE = [rule for rule, _ in INVALID_CONFIGURATIONS]


@given(st.data(), images.firmwares())
def test_configurations_are_accepted_by_the_firmware_they_are_for(data, firmware):
    image = data.draw(images.configurations(firmware)).to_image()
    assert check(list(image), firmware) == ()
    assert Configuration.from_image(image, firmware).to_image() == image


@pytest.mark.parametrize("rule", EVERY_RULE)
def test_a_configuration_breaks_just_the_rule_it_is_asked_to_break(rule):
    @settings(max_examples=15)
    @given(images.faulty_configurations(OLDEST, (rule,)))
    def broken(faulty):
        assert faulty.rule == rule
        assert check(list(faulty.image), OLDEST) == (rule,)

    broken()


@pytest.mark.parametrize("rule", EVERY_RULE)
def test_the_module_fires_the_rule_that_a_configuration_breaks(rule):
    @settings(max_examples=5)
    @given(images.faulty_configurations(OLDEST, (rule,)))
    def broken(faulty):
        bench = Bench("2.0").out(*faulty.image).run(1)
        assert [fired for fired in bench.fired if fired.startswith("CFG")] == [rule]
        assert {"CONFIG_ERROR", "MODE_CONFIG"} <= bench.bits

    broken()


def test_a_rule_that_no_configuration_of_a_firmware_breaks_is_refused():
    with pytest.raises(
        ValueError, match=r"no configuration of firmware 4\.1 breaks only rule 'CFG-29': choose from CFG-01,"
    ):
        images.faulty_configurations(KNOWN[-1], ("CFG-29",))


@given(st.data(), images.firmwares())
def test_commands_are_read_back(data, firmware):
    command = data.draw(images.commands(1000, firmware))
    assert decode(command.to_image()) == command


@given(images.output_images(1000))
def test_output_images_never_ask_for_another_number_of_words(image):
    assert isinstance(image, Image)
    assert len(list(image)) == 8


def test_nearly_right_images_have_one_word_that_no_command_has():
    """The plainest with a deceleration beyond its range."""
    image = find(images.nearly_right_images(1000), lambda image: image[7] > 2000)
    assert list(image)[1:7] == [0] * 6


@pytest.mark.slow
@given(images.blend_profiles(1000, most=5))
@settings(max_examples=15)
def test_a_blend_profile_is_stored_and_runs_its_whole_length(profile):
    bench = _sent(Bench.ready(), profile.blocks())
    assert "INVALID_PROFILE" not in bench.bits
    bench.out(0x1000).until("MOVE_COMPLETE", ms=60_000)
    assert bench.position == sum(segment.length for segment in profile.segments)


@pytest.mark.parametrize("rule", images.BLEND_FAULTS)
def test_the_module_fires_the_rule_that_a_blend_profile_breaks(rule):
    @settings(max_examples=8)
    @given(images.faulty_blends(1000, [rule]))
    def broken(faulty):
        bench = _sent(Bench.ready(), faulty.blocks)
        partners = RULES[rule].together_with
        assert [fired for fired in bench.fired if fired not in partners] == [rule]

    broken()


def test_a_blend_profile_without_its_last_block_is_not_stored():
    bench = _sent(Bench.ready(), find(images.blend_profiles(1000, most=2), lambda _: True).blocks()[:-1])
    assert not bench.fired
    bench.out(0x1000).run(1)
    assert "CMD-16" in bench.fired


def _sent(bench, blocks):
    bench.fired.clear()
    for image in images.handshake(blocks):
        bench.out(*image).run(1)
    return bench


@pytest.mark.parametrize(
    ("strategy", "plainest"),
    [
        (images.output_images(1000), [0, 0, 0, 0, 0, 0, 0, 0]),
        (images.moves(1000).map(lambda move: move.to_image()), [2, 0, 1, 0, 5, 0, 100, 50]),
        (images.manual_moves(200).map(lambda move: move.to_image()), [128, 0, 0, 0, 1, 0, 100, 50]),
        (images.configurations().map(lambda it: it.to_image()), [0x843E - 65_536, 63, 1, 0, 0, 0, 0, 0]),
        (images.hostile_images(), [1, 0, 0, 0, 0, 0, 0, 0]),
    ],
)
def test_what_a_strategy_shrinks_to(strategy, plainest):
    assert list(find(strategy, lambda _: True)) == plainest


def test_a_fault_in_one_number_shrinks_to_a_command_with_that_number():
    """A gateway that loses the sign of the thousands: what is left is one negative number, all else plain.

    Which negative number depends on the constants that Hypothesis finds in the modules that are loaded.
    """
    image = find(images.plausible_images(1000), lambda image: image[0] == 2 and image[2] < 0)
    words = list(image)
    assert words[:2] + words[4:] == [2, 0, 5, 0, 100, 50]
