"""libplctag, a library in C that many HMIs use, against a rack's tags.

PyPI and npm do not have it. `LIBPLCTAG` names one built from its source, if the system does not find it.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from listed_layouts import CONTROLLERS, listed, of_libplctag, rack_at, rack_id
from peers import PEERS_FOLDER, TIMEOUT_S, plctag
from served_tags import served, write_rack

pytestmark = pytest.mark.peer("libplctag")


def asked(port: int, plc: str, *names: str) -> dict[str, Any]:
    """Return what the library makes of names, in a process of its own: its threads never end."""
    library = plctag()
    if library is None:
        pytest.skip("libplctag is not installed")
    words = [sys.executable, "-P", str(PEERS_FOLDER / "plctag_client.py"), library, str(port), plc, *names]
    done = subprocess.run(words, capture_output=True, encoding="utf-8", timeout=TIMEOUT_S)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_values_bits_and_long_arrays_of_a_controller(tmp_path: Path) -> None:
    with served(write_rack(tmp_path)) as (rack, port):
        rack.debugger.tags["anInt"] = 4  # bit 2
        found = asked(
            port, "controllogix", "aDint=-77", "anInt.2", "anInt.3", "Dints{3000}=9",
            "Program:Main.Step.Time=42", "Grid[1,2]", "Locked=5", "Missing",
        )  # fmt: skip
        assert found == {
            "aDint=-77": [-77, 4],
            "anInt.2": True,
            "anInt.3": False,
            "Dints{3000}=9": [9, 12_000],
            "Program:Main.Step.Time=42": [42, 4],
            "Grid[1,2]": [7, 2],
            "Locked=5": "PLCTAG_ERR_NOT_ALLOWED",
            "Missing": "PLCTAG_ERR_NOT_FOUND",
        }
        tags = rack.debugger.tags
        assert [tags[each] for each in ("aDint", "Dints[2999]", "Locked")] == [-77, 9, 7]


@pytest.mark.parametrize("rack_file", CONTROLLERS, ids=rack_id)
def test_it_lists_all_tags_and_templates(rack_file: str, tmp_path: Path) -> None:
    with served(rack_at(rack_file, tmp_path)) as (rack, port):
        told = of_libplctag(lambda *names: asked(port, "controllogix", *names))
        assert told == listed(rack.setup.database)


def test_data_files_of_an_slc_program(tmp_path: Path) -> None:
    """Presets too, which pycomm3 can't write."""
    with served(write_rack(tmp_path, files=True)) as (rack, port):
        found = asked(
            port, "micrologix", "N7:4=-321", "T4:0.PRE=321", "C5:0.PRE=7", "R6:0.LEN=5", "S2:7=3", "L10:0",
            "B3:1", "N7:999",
        )  # fmt: skip
        assert found == {
            "N7:4=-321": [-321, 2],
            "T4:0.PRE=321": [321, 2],
            "C5:0.PRE=7": [7, 2],
            "R6:0.LEN=5": [5, 2],
            "S2:7=3": [3, 2],
            "L10:0": [100_000, 4],
            "B3:1": [5, 2],
            "N7:999": "PLCTAG_ERR_REMOTE_ERR",
        }
        tags = rack.debugger.tags
        assert [tags[each] for each in ("T4:0.PRE", "C5:0.PRE", "R6:0.LEN", "S:7")] == [321, 7, 5, 3]
