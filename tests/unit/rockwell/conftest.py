"""Imports documents that a test has put together."""

import pytest
from scanrack.rockwell.l5x import import_l5x
from scanrack.rockwell.l5x.trial import run_trial


@pytest.fixture
def imported(tmp_path):
    """Imports a text and runs its trial."""

    def read(text, *, trial=True, encoding="utf-8"):
        path = tmp_path / "machine.L5X"
        path.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
        found = import_l5x(path, trial=trial)
        if trial:
            run_trial(found)
        return found

    return read
