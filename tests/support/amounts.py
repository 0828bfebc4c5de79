"""How many examples a property test gets that asks for fewer or more than its profile gives."""

from __future__ import annotations

from hunt3601 import CI_EXAMPLES
from hypothesis import settings


def amount(examples: int) -> int:
    """Return so many in the CI profile, and in proportion with --long; see tests/conftest.py."""
    return max(1, examples * settings().max_examples // CI_EXAMPLES)
