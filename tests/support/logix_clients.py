"""A client of another's making, as the tests use it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    pylogix = pytest.importorskip("pylogix", reason="pylogix is not installed")


@contextmanager
def pylogix_client(port: int) -> Iterator[Any]:
    """A pylogix client of a port of this machine, which leaves no socket open."""
    with pylogix.PLC("127.0.0.1", port=port) as plc:
        plc.conn.msg_socket.close()  # it makes one to listen with, and never closes it
        yield plc
