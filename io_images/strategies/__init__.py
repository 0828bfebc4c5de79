"""Hypothesis strategies for valid and invalid output words of a 3601 and serial traffic.

    from hypothesis import given
    from scanrack.io_images import strategies as images

    @given(images.output_images(starting_speed=1000))
    def test_my_gateway_passes_words_on(image): ...

Every strategy in this package states which words it generates: legal words, words that break exactly one
rule,
or any words. The rule table and the classes of `amci3601` define validity. The first value in every list is
the simplest, so that a failing example shrinks to a natural one.

Only tests and searches import this package, so nothing else in `io_images` needs Hypothesis.

>>> from hypothesis import find
>>> find(moves(1000), lambda move: True).to_image()
Image([2, 0, 1, 0, 5, 0, 100, 50])
>>> faulty = find(faulty_configurations(), lambda faulty: faulty.rule == "CFG-02")
>>> [f"{word & 0xFFFF:04X}h" for word in faulty.image][:3]
['840Eh', '003Fh', '0001h']
"""

from __future__ import annotations

from .blends import BLEND_FAULTS, BlendProfile, FaultyBlend, blend_profiles, faulty_blends, handshake
from .command_values import (
    DISTANCES,
    FAULTY_RATES,
    RATES,
    STARTING_SPEEDS,
    firmwares,
    plain_speeds,
    rates,
    shapes,
    speeds,
    starting_speeds,
    targets,
)
from .commands import (
    commands,
    find_homes,
    followers,
    manual_moves,
    moves,
    presets,
    registration_moves,
    resumes,
)
from .configurations import FaultyConfiguration, configurations, faulty_configurations
from .images import (
    Words,
    any_images,
    hostile_images,
    nearly_right_images,
    output_images,
    parameter_words,
    plausible_images,
)
from .sequences import Act, Showing, acting, acts, configuring, sequences, waiting
from .wires import Piece, damaged, line_traffic, modbus_frame, modbus_requests, noise, pmc006_requests

__all__ = [
    "BLEND_FAULTS",
    "DISTANCES",
    "FAULTY_RATES",
    "RATES",
    "STARTING_SPEEDS",
    "Act",
    "BlendProfile",
    "FaultyBlend",
    "FaultyConfiguration",
    "Piece",
    "Showing",
    "Words",
    "acting",
    "acts",
    "any_images",
    "blend_profiles",
    "commands",
    "configurations",
    "configuring",
    "damaged",
    "faulty_blends",
    "faulty_configurations",
    "find_homes",
    "firmwares",
    "followers",
    "handshake",
    "hostile_images",
    "line_traffic",
    "manual_moves",
    "modbus_frame",
    "modbus_requests",
    "moves",
    "nearly_right_images",
    "noise",
    "output_images",
    "parameter_words",
    "plain_speeds",
    "plausible_images",
    "pmc006_requests",
    "presets",
    "rates",
    "registration_moves",
    "resumes",
    "sequences",
    "shapes",
    "speeds",
    "starting_speeds",
    "targets",
    "waiting",
]
