"""Options of a command as the fields of a dataclass."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, Field, fields
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import Any, get_type_hints


def grouped(
    command: Callable[..., None], declared: Mapping[str, Any] = {}, /, **groups: type[Any]
) -> Callable[..., None]:
    """Return a command that takes the fields of dataclasses as its arguments and options.

    Args:
        command: its function, with a parameter for each group.
        declared: annotations of fields by name, for a dataclass that has none for typer.
        groups: dataclasses by the name of that parameter. Fields are annotated as typer wants it.

    >>> from dataclasses import dataclass
    >>> @dataclass
    ... class Choice:
    ...     speed: float = 1.0
    >>> command = grouped(lambda file, choice: print(file, choice.speed), choice=Choice)
    >>> list(signature(command).parameters)
    ['file', 'speed']
    >>> command(file="a.toml", speed=2.0)
    a.toml 2.0
    """
    own = signature(command, eval_str=True).parameters.values()
    flat = [
        each
        for one in own
        for each in (_options(groups[one.name], declared) if one.name in groups else [one])
    ]

    @wraps(command)
    def run(**given: Any) -> None:
        made = {
            name: group(**{field.name: given.pop(field.name) for field in fields(group)})
            for name, group in groups.items()
        }
        command(**given, **made)

    del run.__wrapped__  # its signature would be found
    run.__annotations__ = {each.name: each.annotation for each in flat}
    run.__signature__ = Signature(flat)  # type: ignore[attr-defined]  # `inspect` reads it
    return run


def _options(group: type[Any], declared: Mapping[str, Any]) -> Iterator[Parameter]:
    hints = {**get_type_hints(group, include_extras=True), **declared}
    for field in fields(group):
        yield Parameter(
            field.name, Parameter.POSITIONAL_OR_KEYWORD, default=_default(field), annotation=hints[field.name]
        )


def _default(field: Field[Any]) -> Any:
    return Parameter.empty if field.default is MISSING else field.default
