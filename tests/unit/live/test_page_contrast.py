"""The colors of the page: text has a contrast of 4.5 to its ground, what carries meaning of 3 [WCAG 2.2].

Broken on purpose: `line` as light as `edge`, power as light as before (1.03 to a wire without): red.
"""

import re
from pathlib import Path

import pytest
from contrast import contrast

CSS = (Path(__file__).parents[3] / "scanrack" / "watch" / "web" / "watch.css").read_text("utf-8")
LIGHT, DARK = (
    dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6})", block))
    for block in re.findall(r":root \{(.*?)\}", CSS, re.DOTALL)
)
TEXT, MEANING = 4.5, 3.0
RULES = [
    *[(MEANING, "line", ground) for ground in ("panel", "quiet", "page", "fault-soft")],
    *[(MEANING, name, "line") for name in ("power",)],
    *[(MEANING, name, "panel") for name in ("curve", "bit", "mark")],
    *[
        (TEXT, "ink", ground)
        for ground in ("panel", "quiet", "page", "power-soft", "warn-soft", "fault-soft")
    ],
    *[(TEXT, "soft", ground) for ground in ("panel", "quiet", "page")],
    *[
        (TEXT, name, ground)
        for name in ("accent", "power", "warn", "fault", "string")
        for ground in ("panel", "quiet")
    ],
    *[(TEXT, name, f"{name}-soft") for name in ("power", "warn", "fault")],
    (TEXT, "accent-ink", "accent"),
]


@pytest.mark.parametrize("scheme", [LIGHT, DARK], ids=["light", "dark"])
@pytest.mark.parametrize(("least", "front", "back"), RULES)
def test_two_colors_can_be_told_apart(scheme, least, front, back):
    assert contrast(scheme[front], scheme[back]) >= least


@pytest.mark.parametrize(
    ("selector", "declaration"),
    [
        ("button, select, input", "border: 1px solid var(--line)"),
        (":is(button, select, input):disabled", "color: var(--line)"),
        (":is(button, select, input):disabled", "opacity: 1"),
        (".rung .wire, .rung .sign", "stroke: var(--line)"),
        (
            '[data-power="1"] > .wire, [data-power="1"] > .sign, [data-power="1"] > .box',
            "stroke: var(--power)",
        ),
    ],
)
def test_what_carries_meaning_has_its_color(selector, declaration):
    (block,) = re.findall(rf"(?m)^{re.escape(selector)} \{{\s([^}}]*)\s\}}", CSS)
    assert declaration in block
