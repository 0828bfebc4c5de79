"""Dataclasses whose methods are compiled later, beside those of the standard library."""

import copy
import dataclasses
import inspect
import pickle
from dataclasses import FrozenInstanceError, InitVar, dataclass, field, fields
from typing import Any, ClassVar

import pytest
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st
from scanrack.io_images import dataclass as ours
from scanrack.io_images.dataclass import CompiledOnUse, of_libraries_too

OPTIONS = ("frozen", "slots", "kw_only", "order", "unsafe_hash", "eq", "repr", "init")
NAMES = ("at", "name", "kind", "size")


def kinds_of_field() -> st.SearchStrategy[dict[str, Any]]:
    """Return arguments of `field`."""
    flags = {each: st.booleans() for each in ("repr", "compare", "kw_only")}
    default = st.sampled_from([{}, {"default": 7}, {"default_factory": list}])
    beyond = st.sampled_from([{}, {}, {"hash": True}, {"hash": False}, {"init": False}])
    return st.builds(
        lambda *each: {k: v for one in each for k, v in one.items()},
        st.fixed_dictionaries(flags),
        default,
        beyond,
    )


def made(decorator: Any, options: dict[str, bool], described: list[dict[str, Any]], post: bool) -> Any:
    """Return a class, or the type of the error that it is refused with."""
    body: dict[str, Any] = {
        "__annotations__": {},
        "__module__": __name__,
        "__qualname__": "Made",
        "__doc__": "Made.",
    }
    for name, words in zip(NAMES, described, strict=False):
        body["__annotations__"][name] = int
        body[name] = field(**words)
    if post:
        body["__post_init__"] = lambda self: object.__setattr__(self, NAMES[0], 99)
    try:
        return decorator(**options)(type("Made", (), body))
    except (TypeError, ValueError) as error:
        return type(error)


def outcome(action: Any, *words: Any, **named: Any) -> Any:
    """Return what an action returns, or the error that it raises."""
    try:
        return action(*words, **named)
    except Exception as error:
        return type(error), str(error)


@settings(max_examples=amount(4))
@given(
    st.fixed_dictionaries({each: st.booleans() for each in OPTIONS}),
    st.lists(kinds_of_field(), min_size=1, max_size=4),
    st.booleans(),
)
def test_they_do_what_those_of_the_standard_library_do(
    options: dict[str, bool], described: list[dict[str, Any]], post: bool
) -> None:
    theirs = made(dataclass, options, described, post)
    own = made(ours.dataclass, options, described, post)
    if not hasattr(theirs, "__dataclass_fields__"):
        return  # refused at once there; here at the first use, by Python's compiler, if at all
    assert inspect.signature(own).parameters.keys() == inspect.signature(theirs).parameters.keys()
    assert own.__match_args__ == theirs.__match_args__
    assert [each.name for each in fields(own)] == [each.name for each in fields(theirs)]
    assert repr(own.__dataclass_params__) == repr(theirs.__dataclass_params__)
    assert (own.__hash__ is None) == (theirs.__hash__ is None)
    needed = {each.name: at for at, each in enumerate(fields(theirs)) if each.init}
    pairs = [
        [outcome(cls, **words) for words in (needed, {**needed, "at": 5}, {}, {"none": 1})]
        for cls in (own, theirs)
    ]
    for one, other in zip(*pairs, strict=True):
        assert isinstance(one, own) == isinstance(other, theirs)
        if not isinstance(one, own):
            assert one == other
            continue
        for action in (
            lambda it: [getattr(it, each.name, None) for each in fields(it)],
            lambda it: setattr(it, NAMES[0], 3),
            lambda it: delattr(it, NAMES[0]),
            lambda it: it == copy.copy(it),
            lambda it: it != 5,
            lambda it: it < it,
            lambda it: it >= it,
            lambda it: hash(it) if type(it).__hash__ is not object.__hash__ else 0,
            lambda it: repr(it) if type(it).__repr__ is not object.__repr__ else "",
            lambda it: sorted(vars(it)) if hasattr(it, "__dict__") else (),
        ):
            assert outcome(action, one) == outcome(action, other)


@ours.dataclass(frozen=True, slots=True)
class Spot:
    """A spot."""

    at: int
    names: list[str] = field(default_factory=list)
    count: ClassVar[int] = 3


def test_a_method_is_compiled_when_it_is_looked_up() -> None:
    @ours.dataclass
    class Late:
        at: int

    assert isinstance(vars(Late)["__init__"], CompiledOnUse)
    assert Late(1).at == 1
    assert inspect.isfunction(vars(Late)["__init__"])
    assert isinstance(vars(Late)["__eq__"], CompiledOnUse)


def test_frozen_ones_with_slots_are_pickled_and_copied() -> None:
    spot = Spot(3, ["a"])
    assert pickle.loads(pickle.dumps(spot)) == copy.deepcopy(spot) == spot == dataclasses.replace(spot)
    assert not hasattr(spot, "__dict__")
    with pytest.raises(FrozenInstanceError, match="cannot assign to field 'at'"):
        spot.at = 4  # type: ignore[misc]


def test_annotations_are_those_of_the_fields() -> None:
    assert inspect.get_annotations(Spot.__init__) == {"at": int, "names": list[str], "return": None}


def test_a_class_that_inherits_fields_is_the_standard_librarys() -> None:
    @ours.dataclass(frozen=True)
    class Wide(Spot):
        width: int = 0

    assert Wide(3, width=2) == Wide(3, [], 2)
    assert repr(Wide(3)).endswith("Wide(at=3, names=[], width=0)")
    with pytest.raises(TypeError, match="cannot inherit"):

        @ours.dataclass
        class Open(Spot):  # type: ignore[misc]
            width: int = 0


def test_a_parameter_that_is_no_field_is_the_standard_librarys() -> None:
    @ours.dataclass
    class Shifted:
        at: int
        by: InitVar[int]

        def __post_init__(self, by: int) -> None:
            self.at += by

    assert Shifted(3, 4).at == 7


def test_methods_of_the_author_stay() -> None:
    @ours.dataclass(frozen=True)
    class Own:
        at: int

        def __repr__(self) -> str:
            return "own"

        def __hash__(self) -> int:
            return 5

        def __eq__(self, other: object) -> bool:
            return True

    assert (repr(Own(1)), hash(Own(1)), Own(1) == Own(2)) == ("own", 5, True)


def test_libraries_get_theirs_back() -> None:
    before = dataclasses.dataclass
    with of_libraries_too():
        assert dataclasses.dataclass is not before
    assert dataclasses.dataclass is before
