"""What an edit can change, for every input: by hand from the rungs."""

import pytest
from scanrack.jobs.prove.serving import effects
from scanrack.jobs.prove.serving.effects import effects_of
from scanrack.ladder.files import parse_program

pytestmark = pytest.mark.extra("prove")

PROGRAM = """\
PROGRAM line
ALIAS Start : Local:2:I.Data.0
ALIAS Lamp : Local:3:O.Data.0
ALIAS Horn : Local:3:O.Data.1
TAG Step : DINT
TAG Wait : TIMER
ROUTINE Main
XIC(Start)TON(Wait,100,0);
XIC(Wait.DN)OTE(Lamp);
XIC(Start)OTE(Horn);
END
"""

NONE = ("none",)
WORD = ("Local:3:O.Data[0]",)


@pytest.mark.parametrize(
    ("old", "new", "outputs", "others"),
    [
        ("XIC(Start)OTE(Horn)", "XIC(Start)XIC(Start)OTE(Horn)", NONE, NONE),
        # Wait.DN needs Start in two scans at least, and Horn is that of the scan before.
        ("XIC(Wait.DN)OTE", "XIC(Wait.DN)XIC(Horn)OTE", NONE, NONE),
        ("XIC(Wait.DN)OTE", "XIC(Wait.DN)XIO(Horn)OTE", WORD, NONE),
        ("TON(Wait,100,0)", "TON(Wait,200,0)", WORD, ("Wait.ACC", "Wait.DN", "Wait.TT")),
    ],
    ids=["twice", "implied", "excluded", "longer"],
)
def test_what_an_edit_can_change(old, new, outputs, others):
    assert old in PROGRAM
    found = effects_of(parse_program(PROGRAM), parse_program(PROGRAM.replace(old, new)))
    assert [names for _, names in found] == [outputs, others]


def test_a_program_that_is_too_large_is_not_compared(monkeypatch):
    monkeypatch.setattr(effects, "MOST_INSTRUCTIONS", 5)
    assert effects_of(parse_program(PROGRAM), parse_program(PROGRAM)) == ()
