"""Clients of others' making, as the tests use them: patient with a busy machine."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    pylogix = pytest.importorskip("pylogix", reason="pylogix is not installed")


PATIENCE_S = 120


@contextmanager
def pylogix_client(port: int) -> Iterator[Any]:
    """A pylogix client of a port of this machine, which leaves no socket open."""
    with pylogix.PLC("127.0.0.1", timeout=PATIENCE_S, port=port) as plc:
        plc.conn.msg_socket.close()  # it makes one to listen with, and never closes it
        yield plc


@contextmanager
def pycomm3_client(driver: Any, port: int, **options: Any) -> Iterator[Any]:
    """A driver of pycomm3 that is connected to a port of this machine."""
    plc = driver(f"127.0.0.1:{port}/0", **options)
    plc.socket_timeout = PATIENCE_S
    with plc:
        yield plc
