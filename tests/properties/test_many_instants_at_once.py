"""What is computed by numpy for many instants is what the plain functions return for each of them."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scanrack.io_images.thousands import split_reported, split_reported_all
from scanrack.runtime.kinematics import Profile, Shape, move, series
from scanrack.runtime.kinematics.series import steps_at_all
from scanrack.runtime.machine import EncoderSpec
from scanrack.runtime.machine.encoder import ShaftEncoder

RATES = st.sampled_from([1, 20, 1000]) | st.integers(1, 5000)
PROFILES = st.builds(
    Profile,
    start_sps=st.integers(1, 5000),
    speed_sps=st.sampled_from([5000, 1000]) | st.integers(1, 500_000),
    acceleration_spmss=RATES,
    deceleration_spmss=RATES,
    shape=st.sampled_from(Shape),
)
PERIODS = st.sampled_from([1, 333_333, 250_000, 2_000_000, 10_000_000])
WHOLE = st.integers(-(10**9), 10**9) | st.sampled_from([0, 999, 1000, -999, -1000, 32_768_000, -65_536_000])


def instants(segment, every_ns, place):
    """The instants of up to 50 scans within a segment, from a place in it on."""
    first_ns = segment.start_ns + (segment.until_ns - 1 - segment.start_ns) * place // 100
    return range(first_ns, segment.until_ns, every_ns)[:50]


@given(PROFILES, st.integers(1, 8_000_000), PERIODS, st.integers(0, 100))
def test_steps(profile, distance, every_ns, place):
    for segment in move(123_456_789, 0, distance, profile).segments:
        found = instants(segment, every_ns, place)
        steps = steps_at_all(segment, found[0], every_ns, len(found))
        assert steps.tolist() == [segment.steps_at(at) for at in found]


def test_steps_that_fall_on_instants_are_asked_of_the_segment(monkeypatch):
    """From 100 steps/s at 30 steps/ms/s: 0.2 k + 0.06 k * k steps at scan k of 2 ms, just 60 at k = 30."""
    profile = Profile(100, 5000, 30, 30, Shape.CONSTANT)
    ramp = move(0, 0, 100_000, profile).segments[0]
    exact = [ramp.steps_at(2_000_000 * scan) for scan in range(80)]
    assert exact[30] == 60
    assert steps_at_all(ramp, 0, 2_000_000, 80).tolist() == exact
    monkeypatch.setattr(series, "_ROUNDINGS", 0)  # every float is trusted
    assert steps_at_all(ramp, 0, 2_000_000, 80)[30] == 59


@given(st.lists(WHOLE, min_size=1, max_size=20))
def test_thousands(values):
    msw, lsw = split_reported_all(np.array(values))
    found = zip(msw.astype(np.int16).tolist(), lsw.tolist(), strict=True)
    assert list(found) == [split_reported(value) for value in values]


@pytest.mark.parametrize("ratio", ["4", "5/2", "1/3", "12345678901234/10000000000001"])
@pytest.mark.parametrize("direction", [1, -1])
def test_counts(ratio, direction):
    encoder = ShaftEncoder(EncoderSpec(Fraction(ratio), direction))
    shafts = [-1_000_000, -3, -1, 0, 1, 2, 7, 999_999_999]
    assert encoder.counts_all(np.array(shafts)).tolist() == [encoder.counts(shaft) for shaft in shafts]
