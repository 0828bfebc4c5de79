"""One list of tests for three hardwares: a 3601, and the adapters that take its place [chapters 2 to 6].

What a story or a configuration expects is what the 3601's manual says of it; where an adapter's
controller can't do it, that it says so in the 3601's own error bits, before anything moves.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from scanrack.io_images import Image
from scanrack.io_images.amci3601 import InputBit
from three_hardwares import CONFIGURATION, HARDWARES, INPUTS, PCL601, PMC006, Refusal, Step, Teller
from three_stories import ENCODER_STORIES, STORIES

CAPTURE, EXTERNAL = InputBit.CAPTURE, InputBit.EXTERNAL


def config(**changed: Any) -> Image:
    """Return the words of the usual configuration with something else in it."""
    return replace(CONFIGURATION, **changed).to_image()


CONFIGURATIONS = {
    "none refuses": (CONFIGURATION.to_image(), {}),
    "capture": (config(inputs_used=INPUTS | CAPTURE), {PMC006: "capture input"}),
    "external": (config(inputs_used=INPUTS | EXTERNAL), {PMC006: "external input"}),
    "slow": (config(starting_speed=64), {PMC006: "starting speed"}),
    "5,000": (config(starting_speed=5000), {}),
    "fast": (config(starting_speed=5001), {PCL601: "starting speed"}),
    "very fast": (config(starting_speed=30_001), {PCL601: "starting speed", PMC006: "starting speed"}),
    "pulses": (config(step_and_direction=False), {PCL601: "CW/CCW pulses"}),
    "encoder": (config(quadrature_encoder=True), {PMC006: "encoder"}),
    "diagnostic": (
        config(diagnostic_feedback=True),
        {PCL601: "diagnostic feedback", PMC006: "diagnostic feedback"},
    ),
    "normally closed limits": (
        config(active_high=0x3F & ~(InputBit.CW_LIMIT | InputBit.CCW_LIMIT)),
        {PCL601: "normally closed end limit", PMC006: "levels of home switch and CCW limit"},
    ),
    "normally closed home switch and limits": (
        config(active_high=InputBit.ESTOP),
        {PCL601: "normally closed end limit"},
    ),
    "normally closed home switch": (
        config(inputs_used=InputBit.HOME | InputBit.CW_LIMIT, active_high=InputBit.CW_LIMIT),
        {PCL601: "normally closed home switch or emergency stop"},
    ),
}


@pytest.mark.parametrize("hardware", HARDWARES)
@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_one_list_of_configurations(name, hardware):
    words, reasons = CONFIGURATIONS[name]
    refused = {each: Refusal({"CONFIG_ERROR"}, reason) for each, reason in reasons.items()}
    Teller(hardware, ()).tell([Step(words, 600, {"MODE_CONFIG"}, None, refused)])


@pytest.mark.slow
@pytest.mark.parametrize("hardware", HARDWARES)
@pytest.mark.parametrize("story", STORIES + ENCODER_STORIES, ids=lambda story: story.name)
def test_one_story_three_hardwares(story, hardware):
    teller = Teller(hardware, story.switches, story.options.get(hardware))
    teller.tell((*story.begin, *story.steps))
