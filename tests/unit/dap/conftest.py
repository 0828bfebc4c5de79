"""A client of the debug adapter, for each test."""

from collections.abc import Iterator

import pytest
from debug_client import DebugClient, connected


@pytest.fixture
def client() -> Iterator[DebugClient]:
    """A client whose adapter has not begun."""
    with connected() as found:
        yield found
