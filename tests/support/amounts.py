"""How many examples a property test gets that asks for fewer or more than its profile gives."""

from __future__ import annotations

from hypothesis import settings

EXAMPLES = 25
"""Examples of a property test in the CI profile; a long run plays 120 times as many (tests/conftest.py)."""

FEW_EXAMPLES = 5
"""Examples in a run of the whole suite without -m; `.ci/run` plays these tests, marked `sampled`, in full."""


def amount(examples: int, few: int | None = None) -> int:
    """Return so many in the CI profile, and in proportion in the others; see tests/conftest.py.

    A test that plays them without Hypothesis carries the mark `sampled`.

    Args:
        few: in a run of the whole suite, where examples are slow and so many show what a change breaks.
    """
    if few is not None and settings().max_examples == FEW_EXAMPLES:
        return few
    return max(1, examples * settings().max_examples // EXAMPLES)
