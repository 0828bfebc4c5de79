"""S:Z and S:N are those of the result, whatever the destination is forced to; both back ends agree."""

import pytest
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program

PROGRAM = """
PROGRAM p
TAG Long : DINT
TAG Word : INT
TAG Block : INT[8]
TAG N : BOOL
TAG Z : BOOL
ROUTINE Main
CPT({target},Long);
XIC(S:N)OTE(N);
XIC(S:Z)OTE(Z);
END
"""


@pytest.mark.parametrize("interpreted", [False, True])
@pytest.mark.parametrize(
    ("target", "forced"),
    [("Word", "Word"), ("Word", "Word.15"), ("Block[2]", "Block[2]"), ("Block[2]", "Block[2].15")],
)
def test_a_result_of_zero_is_zero_though_the_tag_is_forced(target, forced, interpreted):
    debugger = Debugger(parse_program(PROGRAM.format(target=target)))
    debugger.interpreted = interpreted
    debugger.force(forced, 1)
    debugger.scan(2, 1)
    assert debugger.tags[target] != 0
    assert (debugger.tags["N"], debugger.tags["Z"]) == (False, True)
