"""The snippets of docs/strategies.md do what the page says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from amounts import amount
from hypothesis import settings
from scanrack.io_images import strategies as images

TEXT = (Path(__file__).parents[3] / "docs" / "strategies.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page():
    names: dict[str, Any] = {}
    for block in re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL):
        exec(compile(block, "docs/strategies.md", "exec"), names)
    return names


@pytest.mark.parametrize(
    "name",
    [
        "test_words_survive_the_gateway",
        "test_a_check_of_the_starting_speed",
        "test_my_program_never_faults",
        "test_a_display_of_machines",
    ],
)
def test_examples_of_the_page_hold(page, name):
    page[name]()


def test_the_broken_gateway_of_the_page_is_found_out(page):
    with pytest.raises(AssertionError) as caught:
        settings(max_examples=amount(100))(page["test_the_gateway"])()
    notes = "".join(caught.value.__notes__)
    found = re.search(r"Image\(\[(.*?)\]\)", notes)
    assert found is not None
    shown = [int(word) for word in found[1].split(", ")]
    assert shown[2] < 0
    assert all(word >= 0 for index, word in enumerate(shown) if index not in (2, 3))  # one number takes two


def test_every_public_strategy_is_on_the_page():
    made = {name for name in images.__all__ if name.islower()} - {"parameter_words", "plain_speeds"}
    assert {name for name in made if f"`{name}" not in TEXT} == set()


def test_nobody_needs_hypothesis_who_does_not_ask_for_it():
    code = (
        "import sys, scanrack.io_images, scanrack.io_images.amci3601; assert 'hypothesis' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
