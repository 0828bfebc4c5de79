"""The monitor process of a running rack."""

from __future__ import annotations

import pickle
import signal
import socket
from multiprocessing.connection import Connection

from scanrack.runtime.live.ring import Ring
from scanrack.runtime.live.shared_memory import SharedMemory
from scanrack.runtime.loop.realtime import give_up_priority

from .gate import Gate
from .monitors.session_monitor import SessionMonitor, Setup
from .recorded_session import open_beside
from .server import Server


def main(actions: socket.socket, listening: socket.socket, memory: SharedMemory) -> None:
    """Run a monitor until the scan process ends.

    Args:
        actions: connection to the scan process, over which actions are sent.
        memory: shared memory of the ring.
    """
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)  # the scan process ends this one
    give_up_priority()
    pipe = Connection(actions.detach())
    setup: Setup = pickle.loads(pipe.recv_bytes())
    monitor = SessionMonitor(setup, Ring.opened(setup.shape, memory), pipe)
    monitor.opener = open_beside
    gate = Gate(setup.host, setup.port, setup.key)
    Server(monitor, gate, pipe).run(listening)
