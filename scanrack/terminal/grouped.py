"""Options of a command as the fields of a dataclass."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import MISSING, Field, fields
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import Any, get_type_hints

from . import as_json, shared_options


def grouped(command: Callable[..., None], /, **groups: type[Any]) -> Callable[..., None]:
    """Return a command whose arguments and options are the fields of dataclasses.

    Args:
        command: the function of the command, with a parameter for each dataclass.
        groups: the dataclasses by the name of their parameter; their fields are annotated for typer.

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
    parameters = [
        parameter
        for written in signature(command, eval_str=True).parameters.values()
        for parameter in (_options(groups[written.name]) if written.name in groups else [written])
    ]

    @wraps(command)
    def run(**arguments: Any) -> None:
        # moves the options of each group from `arguments` into its dataclass
        options = {
            name: group(**{field.name: arguments.pop(field.name) for field in fields(group)})
            for name, group in groups.items()
        }
        command(**arguments, **options)

    del run.__wrapped__  # typer would read its signature
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    run.__signature__ = Signature(parameters)  # type: ignore[attr-defined]  # `inspect` reads it
    return run


def _options(group: type[Any]) -> Iterator[Parameter]:
    """Yield the fields of a dataclass as parameters; its module need not import typer."""
    names = {**vars(as_json), **vars(shared_options), **vars(sys.modules[group.__module__])}
    hints = get_type_hints(group, names, include_extras=True)
    for field in fields(group):
        yield Parameter(
            field.name, Parameter.POSITIONAL_OR_KEYWORD, default=_default(field), annotation=hints[field.name]
        )


def _default(field: Field[Any]) -> Any:
    return Parameter.empty if field.default is MISSING else field.default
