"""Each example records the same in 5 s of machine time on every system and every version of Python.

After a change of what the examples do: `python tests/tools/example_digests.py --write`.
"""

from __future__ import annotations

import pytest
from example_digests import digest_of, kept, racks


def test_each_example_has_a_digest() -> None:
    assert list(kept()) == racks()
    assert len(racks()) == 29


@pytest.mark.slow
@pytest.mark.parametrize("rack", racks())
def test_an_example_records_the_same(rack: str) -> None:
    assert digest_of(rack) == kept()[rack]
