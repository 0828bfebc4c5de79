"""The process of a monitor beside a rack that runs."""

from __future__ import annotations

import asyncio
import os
import pickle
import signal
import socket
from multiprocessing.connection import Connection

from ..runtime.live.ring import Ring
from .gate import Gate
from .monitors.session_monitor import SessionMonitor, Setup
from .recorded_session import open_beside
from .server import Server


def main(orders: str, listening: str, ring: str) -> None:
    """Run a monitor until the scan process ends: the main function of its process, see `keeper`.

    Args:
        orders: file descriptor of the pipe to the scan process.
    """
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # signals are for the scan process, which ends this one
    if hasattr(os, "sched_setscheduler"):  # the scans may have priority, their monitor has none
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    pipe = Connection(int(orders))
    setup: Setup = pickle.loads(pipe.recv_bytes())
    monitor = SessionMonitor(setup, Ring.opened(setup.shape, int(ring)), pipe)
    monitor.opener = open_beside
    gate = Gate(setup.host, setup.port, setup.key)
    asyncio.run(Server(monitor, gate, pipe).run(socket.socket(fileno=int(listening))))
