"""Blend profiles and their handshake, valid or with exactly one fault.

Every segment is long enough for its speed change. The minimum length of a ramp is calculated here
with a margin (an S-curve takes at most twice the distance of a constant acceleration), since
this package does not simulate motion.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

from hypothesis import strategies as st

from ..amci3601 import Acceleration, BlendHeader, BlendSegment, CommandLsw
from ..amci3601.blend import SEGMENTS_MAX, SEGMENTS_MIN
from ..amci3601.parameters import require
from ..image import Image, signed_word
from ..thousands import split_thousands
from .command_values import pick

SEGMENT_RATES = (1000, 2000, 333)
LENGTHS = (1000, 100, 3000, 200)
START_MAX = 100_000
SEGMENT_SPEED_MAX = 250_000
"""Maximum speed, steps/s, at which sixteen segments with ramps stay below 8,388,607 steps."""


@dataclass(frozen=True, slots=True)
class BlendProfile:
    """A legal blend profile: the first block, and the number of segments that it states."""

    header: BlendHeader
    segments: tuple[BlendSegment, ...]

    def blocks(self) -> list[Image]:
        """Return the output images of the blocks, in order of transmission."""
        return [self.header.to_image(), *(segment.to_image() for segment in self.segments)]


class FaultyBlend(NamedTuple):
    """Output images of blocks with one fault."""

    blocks: list[Image]
    rule: str  # id of the broken rule; "" for missing final blocks, which the module ignores silently


def handshake(blocks: Sequence[Image]) -> list[Image]:
    """Return the images that send blocks: bits 8 and 9, then only bit 8, for each; finally neither bit.

    Show each image until the module responds by setting or clearing BLEND_ACK.
    """
    images: list[Image] = []
    for block in blocks:
        between_image = block.copy()
        between_image[1] = CommandLsw.BLEND_PROGRAM.value
        images += [block, between_image]
    return [*images[:-1], Image()]


def blend_profiles(starting_speed: int, *, most: int = SEGMENTS_MAX) -> st.SearchStrategy[BlendProfile]:
    """Return a strategy of valid profiles of at most `most` segments, 2 to 16."""
    require("starting_speed", starting_speed, 1, START_MAX)
    require("most", most, SEGMENTS_MIN, SEGMENTS_MAX)
    return _profile(starting_speed, most)


@cache
def _headers(most: int) -> st.SearchStrategy[tuple[int, int, Acceleration]]:
    """Return a strategy of the number of segments, the final deceleration and its type."""
    return pick(_as_tuple, range(SEGMENTS_MIN, most + 1), SEGMENT_RATES, tuple(Acceleration))


def _as_tuple(*values: Any) -> tuple[Any, ...]:
    return values


_SEGMENT_CHOICES = pick(_as_tuple, tuple(Acceleration), (2, 3, 5, 4, 1), SEGMENT_RATES, LENGTHS)
"""A segment's type, speed as a multiple of the starting speed, rate, and length if it is long enough."""


@st.composite
def _profile(draw: st.DrawFn, starting_speed: int, most: int) -> BlendProfile:
    """Draw a profile; each segment is long enough for its ramp, the last one also for the final ramp."""
    count, final_deceleration, final_type = draw(_headers(most))
    types: list[Acceleration] = []
    segments: list[BlendSegment] = []
    for number in range(1, count + 1):
        acceleration, multiple, rate, length = draw(_SEGMENT_CHOICES)
        previous_speed = segments[-1].speed if segments else starting_speed
        speed = min(SEGMENT_SPEED_MAX, starting_speed * multiple)
        if segments and speed == previous_speed:  # neighbors of equal speed break PRF-06
            speed += 1
        shortest = _ramp_steps(previous_speed, speed, rate)
        if number == count:
            shortest += _ramp_steps(speed, starting_speed, final_deceleration)
        types.append(acceleration)
        segments.append(BlendSegment(max(shortest, length), speed, rate))
    return BlendProfile(BlendHeader(tuple(types), final_deceleration, final_type), tuple(segments))


def _ramp_steps(before: int, after: int, rate: int) -> int:
    """Return a number of steps sufficient for a speed change: twice v**2 / 2a plus a margin."""
    return abs(after * after - before * before) // (1000 * rate) + 10


class _Damage(NamedTuple):
    """Replacement words of one block: the header (0), the first segment (1) or the last one (-1)."""

    block: int
    words: Mapping[int, int]


def _same_speed(blocks: Sequence[Image]) -> _Damage:
    """Return the damage that gives the last segment the speed of the previous segment."""
    return _Damage(-1, {4: blocks[-2][4], 5: blocks[-2][5]})


def _too_slow(starting_speed: int) -> _Damage:
    """Return the damage that gives the last segment a speed below the starting speed."""
    msw, lsw = split_thousands(starting_speed - 1)
    return _Damage(-1, {4: msw, 5: lsw})


BLEND_FAULTS: dict[str, tuple[_Damage, ...]] = {
    "PRF-04": tuple(_Damage(0, {2: number}) for number in (1, 0, 17, -1)),
    "PRF-07": (_Damage(0, {5: 0}),),
    "BLD-13": (_Damage(0, {5: 2001}), _Damage(0, {5: signed_word(0x8064)})),
    "BLD-21": (_Damage(-1, {2: -1, 3: 0}), _Damage(-1, {2: 0, 3: -1})),
    "BLD-22": (_Damage(-1, {2: 0, 3: 0}), _Damage(-1, {3: 1000})),
    "PRF-02": (_Damage(-1, {4: 0, 5: 0}), _Damage(-1, {4: 1000, 5: 1}), _Damage(-1, {4: 1, 5: -1})),
    "BLD-18": tuple(_Damage(-1, {6: rate}) for rate in (0, 2001, -1)),
    "BLD-19": (_Damage(1, {2: 8388, 3: 607}),),
    "PRF-05": (_Damage(-1, {2: 0, 3: 1, 4: 300, 5: 0}),),
    "PRF-06": (),
    "CMD-05": (),
}
"""Ways to break each blend programming rule; two rules depend on the speeds."""


def faulty_blends(
    starting_speed: int, rules: Sequence[str] = (), *, most: int = 4
) -> st.SearchStrategy[FaultyBlend]:
    """Return a strategy of blocks with exactly one fault, which may be a missing last block.

    Args:
        starting_speed: starting speed of the configuration, 2 to 100,000 steps/s.
        rules: ids in `BLEND_FAULTS` of the rules to break; by default, any rule or missing blocks.
        most: maximum number of segments.

    Raises:
        ValueError: the starting speed or a rule is unsuitable.
    """
    require("starting_speed", starting_speed, 2, START_MAX)
    unknown_rules = [rule for rule in rules if rule not in BLEND_FAULTS]
    if unknown_rules:
        raise ValueError(f"rule {unknown_rules[0]!r} is unknown: choose from {', '.join(BLEND_FAULTS)}")
    rule_choices = st.sampled_from(tuple(rules) or (*BLEND_FAULTS, ""))
    return st.tuples(blend_profiles(starting_speed, most=most), rule_choices).flatmap(
        lambda drawn: _with_fault(drawn[0].blocks(), drawn[1], starting_speed)
    )


def _with_fault(blocks: list[Image], rule: str, starting_speed: int) -> st.SearchStrategy[FaultyBlend]:
    """Return a strategy of the blocks with a fault that breaks a rule; for "", without the last block."""
    if not rule:
        return st.just(FaultyBlend(blocks[:-1], rule))
    if rule == "PRF-06":
        return st.just(FaultyBlend(_damaged(blocks, _same_speed(blocks)), rule))
    if rule == "CMD-05":
        return st.just(FaultyBlend(_damaged(blocks, _too_slow(starting_speed)), rule))
    return _DAMAGES[rule].map(lambda damage: FaultyBlend(_damaged(blocks, damage), rule))


_DAMAGES = {rule: st.sampled_from(damages) for rule, damages in BLEND_FAULTS.items() if damages}


def _damaged(blocks: Sequence[Image], damage: _Damage) -> list[Image]:
    """Return copies of the blocks, with replaced words in one of them."""
    copies = [block.copy() for block in blocks]
    for index, word in damage.words.items():
        copies[damage.block][index] = word
    return copies
