"""A `dataclass` decorator like the standard library's that compiles methods on first use.

The standard library compiles six methods when a class is defined. Most of them are never called, and
compiling them took a tenth of the run time of a short `scanrack run`. The standard library still determines
the
fields and slots, and it still builds classes that inherit fields or have an `InitVar`.

>>> @dataclass(frozen=True, slots=True)
... class Spot:
...     at: int
...     name: str = ""
>>> Spot(3), Spot(3) == Spot(3, ""), {Spot(4): "four"}[Spot(4)]
(Spot(at=3, name=''), True, 'four')
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, Field, FrozenInstanceError, fields
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any

Method = Callable[..., Any]
_standard: Any = dataclasses.dataclass

DEFAULTS = {"init": True, "repr": True, "eq": True, "order": False, "unsafe_hash": False, "frozen": False}
"""Options that determine the methods, with their defaults."""

COMPARISONS = {"__lt__": "<", "__le__": "<=", "__gt__": ">", "__ge__": ">="}


class CompiledOnUse:
    """Placeholder for a method: looking it up compiles the method, which then replaces the placeholder.

    Args:
        cls: the class.
        name: name of the method.
        compiler: returns the compiled method.
    """

    def __init__(self, cls: type[Any], name: str, compiler: Callable[[type[Any], str], Method]) -> None:
        self._cls, self._name, self._compiler = cls, name, compiler

    def __get__(self, instance: object, owner: type[Any]) -> Any:
        method = self._compiler(self._cls, self._name)
        method.__qualname__ = f"{self._cls.__qualname__}.{self._name}"
        setattr(self._cls, self._name, method)
        return method.__get__(instance, owner)


def _dataclass(cls: type[Any] | None = None, /, **options: bool) -> Any:
    """Turn a class into a dataclass.

    Args:
        options: as in the standard library.
    """
    return (lambda cls: _lazy_class(cls, options)) if cls is None else _lazy_class(cls, options)


def _lazy_class(cls: type[Any], options: Mapping[str, bool]) -> type[Any]:
    """Return a dataclass with placeholders for the methods that the class does not define."""
    if _is_special(cls):
        return _standard(**options)(cls)  # type: ignore[no-any-return]
    parameters = {**DEFAULTS, **options}
    attributes = dict(vars(cls))
    if "__eq__" in attributes and attributes["__hash__"] is None:  # set by Python, not by the author
        del attributes["__hash__"]
    cls.__doc__ = cls.__doc__ or cls.__name__  # otherwise `inspect` composes a signature
    new_class: type[Any] = _standard(**{**options, **dict.fromkeys(DEFAULTS, False)})(cls)
    for name in DEFAULTS:
        setattr(new_class.__dataclass_params__, name, parameters[name])
    for name, method in _methods(new_class, parameters):
        if name not in attributes:
            setattr(new_class, name, method)
    return new_class


def _is_special(cls: type[Any]) -> bool:
    """Return whether a class inherits fields, or has parameters that are not fields."""
    base: Any = cls if dataclasses.is_dataclass(cls) else None
    inherits = base is not None and bool(fields(base) or base.__dataclass_params__.frozen)
    return inherits or "InitVar" in str(getattr(cls, "__annotations__", ""))


def _methods(cls: type[Any], options: Mapping[str, bool]) -> Iterator[tuple[str, object]]:
    """Yield the names of the methods that the options select, with the methods or their placeholders."""
    for option, name, compiler in _COMPILERS:
        if options[option]:
            yield name, CompiledOnUse(cls, name, compiler)
    if options["unsafe_hash"] or (options["eq"] and options["frozen"]):
        yield "__hash__", CompiledOnUse(cls, "__hash__", _hash)
    elif options["eq"]:
        yield "__hash__", None
    if options["frozen"]:
        yield "__setattr__", _refusal(cls, "__setattr__", "assign to")
        yield "__delattr__", _refusal(cls, "__delattr__", "delete")
        if "__slots__" in vars(cls):
            yield from (("__getstate__", _getstate), ("__setstate__", _setstate))


def _value_and_default(field: Field[Any], names: dict[str, Any]) -> tuple[str, str]:
    """Return code for a field's value, and for its parameter's default; add the names in the code to `names`.

    A default of "" means that the parameter is required.
    """
    name = field.name
    if field.default is not MISSING:
        names[f"default__{name}"] = field.default
        return name, f"default__{name}"
    if field.default_factory is not MISSING:
        names[f"new__{name}"] = field.default_factory
        return f"new__{name}() if {name} is missing__ else {name}", "missing__"
    return name, ""


def _init(cls: type[Any], name: str) -> Method:
    """Return the compiled `__init__`: it assigns the fields, then calls `__post_init__` if there is one."""
    frozen, slots = cls.__dataclass_params__.frozen, "__slots__" in vars(cls)
    names: dict[str, Any] = {"set__": object.__setattr__, "missing__": MISSING}
    assignment = "set__(self, '{}', {})" if frozen else "self.{} = {}"
    positional, keyword_only = ["self"], ["*"]
    statements = []
    for field in fields(cls):
        value, default = _value_and_default(field, names)
        if field.init:
            parameters = keyword_only if field.kw_only else positional
            parameters.append(f"{field.name}={default}" if default else field.name)
        else:
            value = f"new__{field.name}()" if default == "missing__" else default
        # without slots, a default that is no parameter remains an attribute of the class
        if field.init or default == "missing__" or (default and slots):
            statements.append(assignment.format(field.name, value))
    if hasattr(cls, "__post_init__"):
        statements.append("self.__post_init__()")
    if len(keyword_only) > 1:
        positional += keyword_only
    init = _compiled(cls, name, positional, statements or ["pass"], names)
    init.__annotations__ = {**_types_of_parameters(cls), "return": None}
    return init


def _types_of_parameters(cls: type[Any]) -> dict[str, Any]:
    return {field.name: field.type for field in fields(cls) if field.init}


def _repr(cls: type[Any], name: str) -> Method:
    field_texts = ", ".join(f"{field.name}={{self.{field.name}!r}}" for field in fields(cls) if field.repr)
    return recursive_repr()(
        _compiled(cls, name, ["self"], [f'return f"{{self.__class__.__qualname__}}({field_texts})"'])
    )


def _eq(cls: type[Any], name: str) -> Method:
    return _compared(cls, name, "==")


def _comparison(cls: type[Any], name: str) -> Method:
    return _compared(cls, name, COMPARISONS[name])


def _compared(cls: type[Any], name: str, sign: str) -> Method:
    """Return a method that compares the fields of two objects of one class as tuples."""
    compared_fields = [field for field in fields(cls) if field.compare]
    statements = [
        "if other.__class__ is self.__class__:",
        f" return {_tuple('self', compared_fields)} {sign} {_tuple('other', compared_fields)}",
        "return NotImplemented",
    ]
    return _compiled(cls, name, ["self", "other"], statements)


_COMPILERS = (
    *(("init", "__init__", _init), ("repr", "__repr__", _repr), ("eq", "__eq__", _eq)),
    *(("order", name, _comparison) for name in COMPARISONS),
)
"""Option, name and compiler of each method."""


def _hash(cls: type[Any], name: str) -> Method:
    hashed = [field for field in fields(cls) if (field.compare if field.hash is None else field.hash)]
    return _compiled(cls, name, ["self"], [f"return hash({_tuple('self', hashed)})"])


def _tuple(owner: str, tuple_fields: Iterable[Field[Any]]) -> str:
    """Return code for the tuple of an object's fields."""
    return f"({''.join(f'{owner}.{field.name},' for field in tuple_fields)})"


def _compiled(
    cls: type[Any], name: str, parameters: list[str], body: list[str], names: Mapping[str, object] = {}
) -> Method:
    """Return a method, compiled in the module of its class.

    Args:
        parameters: code of each parameter.
        body: lines of code.
        names: values of other names in the code.
    """
    lines = [
        f"def making({', '.join(names)}):",
        f" def {name}({', '.join(parameters)}):",
        *(f"  {line}" for line in body),
        f" return {name}",
    ]
    compiled: dict[str, Any] = {}
    exec("\n".join(lines), vars(sys.modules[cls.__module__]), compiled)
    return compiled["making"](**names)  # type: ignore[no-any-return]


def _refusal(cls: type[Any], name: str, action: str) -> Method:
    """Return a method that refuses to assign or delete a field of a frozen class."""
    names = frozenset(field.name for field in fields(cls))

    def refuse(self: object, attribute: str, *value: object) -> None:
        if type(self) is cls or attribute in names:
            raise FrozenInstanceError(f"cannot {action} field {attribute!r}")
        getattr(super(cls, self), name)(attribute, *value)

    return refuse


def _getstate(self: Any) -> list[Any]:
    """Return the state that pickle stores for an object with slots: its fields, in order."""
    return [getattr(self, field.name) for field in fields(self)]


def _setstate(self: Any, state: Iterable[Any]) -> None:
    """Set the fields to a state from `_getstate`, even in a frozen object."""
    for field, value in zip(fields(self), state, strict=False):
        object.__setattr__(self, field.name, value)


if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:
    dataclass = _dataclass


@contextmanager
def of_libraries_too() -> Iterator[None]:
    """Use this decorator for libraries imported in a `with` block; pydantic and mcap use 70 dataclasses."""
    dataclasses.dataclass = dataclass
    try:
        yield
    finally:
        dataclasses.dataclass = _standard
