"""What users annotate is read on each Python, names for type checkers only included."""

import inspect
import sys
import types

import pytest
from scanrack.io_images.annotations import declared, signature_of

BODY = """\
speed: float = 0


class Axis:
    last: int
    moves = 0

    def move(self, to: int) -> None: ...
"""

LATE = """\
class Axis:
    last: Unknown
    rest: int

    def move(self, to: Unknown) -> None: ...
"""


@pytest.fixture(params=["", "from __future__ import annotations\n"], ids=["plain", "future"])
def module(request):
    made = types.ModuleType("made")
    exec(compile(request.param + BODY, "made.py", "exec", dont_inherit=True), vars(made))
    return made


def test_names_of_a_class_and_of_a_module(module):
    assert list(declared(vars(module))) == ["speed"]
    assert list(declared(vars(module.Axis))) == ["last"]
    assert declared(vars(type("Bare", (module.Axis,), {}))) == {}
    assert list(signature_of(module.Axis.move).parameters) == ["self", "to"]


@pytest.mark.skipif(sys.version_info < (3, 14), reason="before 3.14 such a class is an error where it stands")
def test_names_for_type_checkers_only():
    names: dict[str, object] = {}
    exec(compile(LATE, "late.py", "exec", dont_inherit=True), names)
    kind = names["Axis"]
    assert isinstance(kind, type)
    with pytest.raises(NameError):
        inspect.signature(vars(kind)["move"])
    assert list(declared(vars(kind))) == ["last", "rest"]
    assert list(signature_of(vars(kind)["move"]).parameters) == ["self", "to"]
