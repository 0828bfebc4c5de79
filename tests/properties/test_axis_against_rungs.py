"""The axis in Python against the function blocks of rungs: the same words in every scan of any script.

The blocks are an oracle of another make: ladder text, compiled. They judge the inputs after the blocks, so an
axis that does so too (`late`) has to be equal in every image and result. The axis as it is used judges before
the sequences: its images are equal until a command meets a state that the blocks see one scan later; only the
handshake of a blend is faster, by a scan for each phase. Whatever happens, no command is busy on either side
while the axis rests for a second and the link is good.
"""

import pytest
from amounts import amount
from axis_lockstep import ASKS, OTHERS, READY, PythonSide, RungSide, ask_of, legal
from drive_bench import BINARY_LOW
from hypothesis import given, settings
from hypothesis import strategies as st

pauses = st.integers(1, 5) | st.integers(1, 40) | st.integers(1, 400)
"""A command one to five scans after another meets the axis in each of its steps."""

LAST = 600
"""Scans behind the last deed: more than the second that a command may rest."""

commands = st.sampled_from([*ASKS, *ASKS, *OTHERS])
with_blends = st.sampled_from([*ASKS, *OTHERS, *["blend"] * 6])


def scripts(deeds):
    return st.lists(st.tuples(deeds, pauses), min_size=1, max_size=12)


@pytest.mark.slow
@pytest.mark.parametrize("rpi_ms", [None, 5])
@settings(max_examples=amount(6))
@given(script=scripts(with_blends))
def test_late_judging_is_equal_in_every_image_and_result(rpi_ms, script):
    deeds = dict(legal([*READY, *script, ("found", 1)]))
    rungs, python = RungSide(rpi_ms=rpi_ms), PythonSide(late=True, rpi_ms=rpi_ms)
    for scan in range(max(deeds) + LAST):
        deed = deeds.get(scan)
        assert python.scan(deed) == rungs.scan(deed), (scan, deed)
    assert {block: python.outcome(block) for block in rungs.results} == rungs.results


@pytest.mark.slow
@pytest.mark.parametrize(("model", "format"), [("smd23e2", 0), ("sd17060e2", BINARY_LOW), ("anf2", 0)])
@settings(max_examples=amount(4))
@given(script=scripts(with_blends))
def test_late_judging_is_equal_on_networked_drives(model, format, script):
    """Rungs and Python translate the words of a 3601 apart: the drive's ten words are equal, too."""
    deeds = dict(legal([*READY, *script, ("found", 1)]))
    rungs, python = RungSide(model=model, format=format), PythonSide(late=True, model=model, format=format)
    for scan in range(max(deeds) + LAST):
        deed = deeds.get(scan)
        assert python.scan(deed) == rungs.scan(deed), (scan, deed)


@pytest.mark.slow
@settings(max_examples=amount(6))
@given(script=scripts(commands))
def test_early_judging_is_equal_until_a_command_meets_another_state(script):
    deeds = dict(legal([*READY, *script]))
    rungs, python = RungSide(), PythonSide(late=False)
    for scan in range(max(deeds) + 200):
        deed = deeds.get(scan)
        words, expected = python.scan(deed), rungs.scan(deed)
        if refusal(python, deed) != refusal(rungs, deed):
            return
        assert words == expected, (scan, deed)


def refusal(side, deed):
    """Return why a command was refused at once: bits 6 to 8 of its ErrorID."""
    ask = ask_of(deed)
    return None if ask is None else side.outcome(ask.block)[1] & 0x1C0


@pytest.mark.slow
@pytest.mark.parametrize("scan_ms", [1, 2, 10, 20])
def test_a_blend_is_the_same_path_sooner(scan_ms):
    """Programming and path: the same words in the same order; early judging takes no phase longer."""
    sides = RungSide(scan_ms=scan_ms), PythonSide(late=False, scan_ms=scan_ms)
    runs = [distinct(side, [*READY, ("blend", 150), ("run blend", 2_000)]) for side in sides]
    assert [words for words, _ in runs[0]] == [words for words, _ in runs[1]]
    assert all(early <= late for (_, late), (_, early) in zip(*runs, strict=True))


def distinct(side, script):
    """Return each new output image, and how many scans the one before it stood."""
    deeds = dict(legal(script))
    images: list[tuple[list[int], int]] = []
    for scan in range(max(deeds) + 500):
        words = side.scan(deeds.get(scan))
        if not images or images[-1][0] != words:
            images.append((words, scan))
    return images
