"""Imports optional libraries; the error for a missing library names the command that installs it."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from scanrack.io_images.installing import how_to_install


class MissingExtraError(ImportError):
    """A library that an extra provides is not installed."""


def need(module: str, extra: str) -> ModuleType:
    """Import a library that an extra provides.

    >>> need("json", "plot").__name__
    'json'

    Raises:
        MissingExtraError: the library is not installed; the message explains how to install it.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        library = module.partition(".")[0]
        if error.name is None or error.name.partition(".")[0] != library:
            raise  # the library is installed, but a module that it needs is missing
        problem = f"{library} is not installed: {how_to_install(extra)}"
        raise MissingExtraError(problem, name=library) from error
