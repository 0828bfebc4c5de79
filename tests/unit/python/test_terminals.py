"""An input or output of a card at which there is no terminal is refused before the first scan."""

import pytest
from scanrack.jobs import build_cpu, build_rack
from scanrack.ladder.python.sequences import Input, Logic, Output
from scanrack.runtime import RackSpec, SlotSpec

CARDS = (
    SlotSpec(number=1, module="1762-IQ8"),
    SlotSpec(number=2, module="1769-OW8"),
    SlotSpec(number=3, module="1769-IQ32"),
)
SPEC = RackSpec(program=print, slot=CARDS)


def attached(declared):
    """Attach a class with one part to the rack."""
    build_cpu(SPEC, type("Line", (Logic,), {"part": declared})(), build_rack(SPEC)).run(1)


@pytest.mark.parametrize(
    ("part", "says"),
    [
        (Input("Local:1:I.Data.8"), "slot 1 has inputs 0 to 7"),
        (Input("I:1.0/9"), "slot 1 has inputs 0 to 7"),
        (Output("Local:1:O.Data.1"), "slot 1 has no outputs"),
        (Output("Local:2:O.Data.8"), "slot 2 has outputs 0 to 7"),
    ],
)
def test_what_is_not_there_is_refused(part, says):
    with pytest.raises(ValueError, match=says):
        attached(part)


@pytest.mark.parametrize(
    "part",
    [
        Input("Local:1:I.Data.7"),
        Output("Local:2:O.Data.7"),
        Input("Local:2:I.Data.7"),  # a 1769 output card repeats its outputs
        Input("Local:3:I.Data.31"),
    ],
)
def test_the_last_terminal_is_there(part):
    attached(part)
