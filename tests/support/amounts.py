"""How many examples a property test gets that asks for fewer or more than its profile gives."""

from __future__ import annotations

from hypothesis import settings

EXAMPLES = 25
"""Examples of a property test in the CI profile; a long run plays 120 times as many (tests/conftest.py)."""


def amount(examples: int) -> int:
    """Return so many in the CI profile, and in proportion with --long; see tests/conftest.py."""
    return max(1, examples * settings().max_examples // EXAMPLES)
