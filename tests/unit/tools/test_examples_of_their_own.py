"""The examples of a property test are the same whatever modules are loaded."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

ODD = 86_028_121_771


def drawn() -> list[int]:
    """Return the numbers that a test is given."""
    seen: list[int] = []

    @settings(max_examples=300, database=None)
    @given(st.integers(0, 1 << 40))
    def test(number: int) -> None:
        seen.append(number)

    test()
    return seen


@pytest.mark.slow
def test_constants_of_modules_are_not_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    if request.config.getoption("--long"):
        pytest.skip("fresh examples are wanted")
    before = drawn()
    (tmp_path / "module_of_odd_constants.py").write_text(
        "\n".join(f"C{number} = {ODD + number}" for number in range(200)), encoding="utf-8"
    )
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "module_of_odd_constants", raising=False)
    __import__("module_of_odd_constants")
    assert drawn() == before
    monkeypatch.delitem(sys.modules, "module_of_odd_constants")
