"""The motion blocks on networked drives: one program on a 3601, on the adapter amci-drive, and on drives.

A story is what each block does in turn: how it ends, and where the axis stands then. What is different on a
drive is in a table below, with the rule. Starting speed 1,000 steps/s; input 1 is home, input 2 the CW limit.
"""

from functools import cache

import pytest
from blocks3601 import ADAPTER, BlocksBench
from drive_bench import BINARY, BINARY_LOW, CW_LIMIT, HOME

pytestmark = pytest.mark.slow

WORDS_3601 = (0x8414, 0x0014, 1, 0, 0, 0, 0, 0)
"""Home and CW limit, active when on; starting speed 1,000."""

MACHINE = {"home": (6_000, 6_300), "cw_limit": (30_000, None)}
NO_COMMAND = 4096

SEGMENTS = ((3_000, 5_000, 20), (2_200, 2_000, 10))

STORY: tuple[tuple[str, dict[str, int]], ...] = (
    ("SetPosition", {"Position": -1_234}),
    ("Move", {"Position": 2_000}),
    ("Relative", {"Distance": -700}),
    ("Relative", {"Distance": 5, "Velocity": 1_000}),
    ("Move", {"Position": -3_500, "Shape": 1}),
    ("Move", {"Position": 1_305, "Shape": 3}),
    ("Velocity", {"Velocity": 3_000}),
    ("Velocity", {"Velocity": -2_000}),
    ("Halt", {}),
    ("Home", {"Direction": 1, "Velocity": 2_000}),
    ("Move", {"Position": 100, "Velocity": 5}),  # below the starting speed: the module refuses it
    ("Move", {"Position": 100}),  # ErrorStop
    ("Reset", {}),
    ("Move", {"Position": 100}),
    ("Move", {"Position": 9_000_000}),  # out of range: refused by the block
    ("Stop", {}),
    ("Blend", {"Segments": 2, "FinalDeceleration": 10}),
    ("RunBlend", {"Direction": 1}),
    ("RunBlend", {"Direction": -1}),
    ("Minimum", {"Distance": 400}),
    ("Gear", {"RatioNumerator": 1, "RatioDenominator": 1}),
)
"""Blocks in turn with their operands."""

ENDS = ("Done", "CommandAborted", "Error", "InVelocity", "InGear")
"""Outputs that end a chapter of the story."""


@cache
def story(
    model: str, *, format: int = 0, interpreted: bool = False, chapters: int = len(STORY)
) -> list[tuple[str, str, int, int]]:
    """Return block, output, ErrorID and position of each chapter."""
    bench = BlocksBench.configured(
        config=WORDS_3601, format=format, model=model, machine=MACHINE, inputs=(HOME, CW_LIMIT),
        interpreted=interpreted, scan_ms=10,
    )  # fmt: skip
    for number, values in enumerate(SEGMENTS):
        for name, value in zip(("Lengths", "Velocities", "Rates"), values, strict=True):
            bench.tags[f"{name}[{number}]"] = value
    told = []
    for block, operands in STORY[:chapters]:
        bench.drop(block).scan(2).go(block, **{"Shape": 0, **operands})
        output = next(output for _ in range(40_000) for output in ENDS if output in bench.scan().said(block))
        at = 0 if output in ("InVelocity", "InGear") or bench.tags["Axis.Moving"] else bench.position
        told.append((block, output, bench.tags[f"{block}.ErrorID"], at))
        if output not in ("InVelocity", "InGear"):
            bench.drop(block).run(1_000 if model == ADAPTER else 40)
    return told


def differing(model: str, **options: object) -> dict[str, tuple[str, int]]:
    """Return output and ErrorID of the chapters that differ from those of a 3601, by block."""
    expected, found = story(""), story(model, **options)
    return {
        f"{block} {at}": (output, error)
        for at, ((block, *rest), (_, output, error, position)) in enumerate(zip(expected, found, strict=True))
        if rest != [output, error, position]
    }


SMD = {"Move 10": ("Error", 1), "Gear 20": ("Error", NO_COMMAND)}
"""COMMAND_ERROR alone, where a 3601 has INVALID_PROFILE, too (D-22); no input for another encoder (D-12)."""

ANF2 = SMD | dict.fromkeys(
    ("Move 4", "Move 5", "Blend 16", "RunBlend 17", "RunBlend 18", "Minimum 19"), ("Error", NO_COMMAND)
)
"""Neither S-curves (D-17) nor blends (D-08), and registration is not known."""


def test_a_3601_tells_every_chapter():
    """Each block ends as it has to: the oracle of the tests below."""
    assert [(output, error) for _, output, error, _ in story("")] == [
        *[("Done", 0)] * 6, *[("InVelocity", 0)] * 2, *[("Done", 0)] * 2,
        ("Error", 3), ("Error", 64), ("Done", 0), ("Done", 0), ("Error", 128), *[("Done", 0)] * 5,
        ("Error", 1),
    ]  # fmt: skip
    assert [at for *_, at in story("")][:6] == [-1_234, 2_000, 1_300, 1_305, -3_500, 1_305]


@pytest.mark.parametrize(
    ("model", "format", "different"),
    [
        ("smd23e2", 0, SMD),
        ("smd23e2", BINARY, SMD),
        ("smd24e2", BINARY_LOW, SMD),
        ("sd17060e2", 0, SMD),
        ("ang1", 0, SMD),
        ("anf2", 0, ANF2),
    ],
)
def test_the_same_story_on_a_drive(model, format, different):
    assert differing(model, format=format) == different


def test_the_same_story_on_the_adapter():
    """A halt ends where the link lets it."""
    assert set(differing(ADAPTER)) <= {"Halt 8"}


def test_the_interpreter_tells_the_same_story():
    assert story("smd23e2", interpreted=True, chapters=3) == story("smd23e2")[:3]
