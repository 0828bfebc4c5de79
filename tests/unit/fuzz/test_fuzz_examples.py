"""The five programs of `examples/sequences` get through a few runs of the search with what must hold of them.

docs/sequences.md tells of campaigns of 2,000 runs. Here the command takes each program on its 3601, and the
one with two axes on adapters, too.
"""

import re
from pathlib import Path

import pytest
from scanrack.commands import build
from typer.testing import CliRunner

EXAMPLES = Path(__file__).parents[3] / "examples" / "sequences"
INVARIANTS = {"shared_zone": "zone_must_hold.py", "shared_zone_pmc006": "zone_must_hold.py"}
RACKS = ["stations", "labeller", "blend_path", "jog_panel", *INVARIANTS]


@pytest.mark.slow
@pytest.mark.parametrize("rack", RACKS)
def test_the_search_takes_the_program(rack, tmp_path):
    must_hold = EXAMPLES / INVARIANTS.get(rack, "must_hold.py")
    words = ["fuzz", str(EXAMPLES / f"{rack}.toml"), "-i", str(must_hold)]
    words += ["--runs", "3", "-j", "1", "--for", "2 s", "--out", str(tmp_path / "found")]
    result = CliRunner().invoke(build(), words)
    assert (result.exit_code, result.stderr) == (0, ""), result.output
    assert re.search(r"^runs +3 ", result.stdout, re.MULTILINE)
    held = re.search(r"^held +(.+)", result.stdout, re.MULTILINE)
    assert held is not None
    wanted = re.findall(r"^def (\w+)", must_hold.read_text(encoding="utf-8"), re.MULTILINE)
    assert set(wanted) <= {each.partition(" ")[0] for each in held[1].split(", ")}
