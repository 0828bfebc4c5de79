"""How the options of adapters are checked."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import fields


def check_names(kind: type, given: Iterable[str], owner: str) -> None:
    """Refuse names that are no fields of a dataclass of options.

    Raises:
        ValueError: an unknown name, with what is allowed.
    """
    names = [field.name for field in fields(kind)]
    for name in given:
        if name not in names:
            near = difflib.get_close_matches(name, names, n=1)
            hint = f"; did you mean {near[0]}?" if near else f"; allowed are {', '.join(names)}"
            raise ValueError(f"option {name}: the {owner} has no such option{hint}")


def check_choices(options: object, choices: Mapping[str, tuple[str | bool, ...]]) -> None:
    """Refuse values that are not among the choices of their option.

    Raises:
        ValueError: such a value, with what is allowed.
    """
    for name, allowed in choices.items():
        value = getattr(options, name)
        if not any(value == each and type(value) is type(each) for each in allowed):
            words = ", ".join(str(each).lower() for each in allowed)
            raise ValueError(f"option {name}: {value!r} is not allowed: {words}")
