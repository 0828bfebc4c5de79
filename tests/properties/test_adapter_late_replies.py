"""A reply that is older than its question never counts as rest: random delays, and some that did harm."""

from __future__ import annotations

import pytest
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st
from late_replies import COMMANDS, lies

pytestmark = pytest.mark.slow

FOUND = [
    ("PCL601", "relative", {6: 122, 7: 764, 14: 794, 15: 222, 17: 433}),
    ("PCL601", "held and resumed", {3: 226, 38: 529, 52: 773, 68: 412, 82: 219}),
    ("PMC006", "manual", {7: 371, 11: 433}),
    ("PMC006", "held and resumed", {9: 268}),
    ("PMC006", "held and resumed", {4: 630, 11: 151}),
    ("PMC006", "registration", {1: 237, 7: 176}),
]
"""Delays, in ms by the number of the reply, with which an adapter has shown a rest that was none."""


@pytest.mark.parametrize(("controller", "command", "delays_ms"), FOUND)
def test_no_late_reply_counts_as_rest_where_one_did(controller, command, delays_ms):
    assert list(lies(controller, command, delays_ms)) == []


@settings(max_examples=amount(4), deadline=None)
@given(
    controller=st.sampled_from(["PCL601", "PMC006", "drive"]),
    command=st.sampled_from(sorted(COMMANDS)),
    delays_ms=st.dictionaries(st.integers(0, 130), st.integers(51, 900), max_size=20),
)
def test_no_late_reply_counts_as_rest(controller, command, delays_ms):
    assert list(lies(controller, command, delays_ms)) == []
