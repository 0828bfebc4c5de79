"""Parts of asyncua (2.1) that several modules of the OPC UA server use; asyncua is an optional dependency."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class _Lazy:
    """A module that is imported when one of its names is first used."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, name: str) -> Any:
        member = getattr(import_module(self._name), name)
        setattr(self, name, member)
        return member


ua: Any = _Lazy("asyncua.ua")
utils: Any = _Lazy("asyncua.common.utils")
binary: Any = _Lazy("asyncua.ua.ua_binary")


def status(code: str) -> Any:
    """Return the status for the name of its code."""
    return ua.StatusCode(getattr(ua.StatusCodes, code))


def service_error(code: str) -> Exception:
    """Return the error that refuses a whole request, given the name of its status code."""
    error: Exception = utils.ServiceError(getattr(ua.StatusCodes, code))
    return error
