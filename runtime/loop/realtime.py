"""Requests to the operating system, so that scans begin on time.

    scheduling   SCHED_FIFO    no ordinary process delays a scan
    memory       mlockall      no page is swapped out
    collector    gc.freeze     garbage collection skips objects that exist at the start

The system can refuse the first two. After a refusal, the run continues and reports the refusal with a remedy.
"""

from __future__ import annotations

import ctypes
import errno
import gc
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

PRIORITY = 40
"""Priority above all ordinary processes, and below the interrupt threads of real-time Linux, which have 50.
"""

MCL_CURRENT, MCL_FUTURE, MCL_ONFAULT = 1, 2, 4
"""Flags of mlockall: current pages, later pages, and each page once it is in memory [mlock(2)]."""


LIMITS = Path("/proc/self/limits")
"""Linux's table of this process's limits: current limit, then maximum [proc_pid_limits(5)]."""

CAP_IPC_LOCK = 14
"""Number of the capability that allows locking memory without a limit [capabilities(7)]."""


ELSEWHERE = "other programs delay scans: close them, or run on Linux, which has it"
"""The remedy on a system that lacks the requested function."""


@dataclass(frozen=True)
class Outcome:
    """The result of a request to the system."""

    name: str
    refusal: str = ""  # the reason of a refusal; empty = granted
    advice: str = ""  # the remedy of the refusal

    def __str__(self) -> str:
        if not self.refusal:
            return f"real time with {self.name}"
        return f"real time without {self.name} ({self.refusal}): {self.advice}"


Undo = Callable[[], object]
"""Function that undoes a granted request."""


@dataclass(frozen=True)
class SystemRequest:
    """A request to the system.

    Attributes:
        make: function that makes the request, and returns a function that undoes it. It raises OSError if the
            system refuses, and NotImplementedError on a system without the requested function.
        advice: the remedy for a refusal.
    """

    name: str
    make: Callable[[], Undo]
    advice: str

    def carry_out(self, undo: ExitStack) -> Outcome:
        """Make the request, and add its undo function to `undo`; return the outcome."""
        try:
            undo.callback(self.make())
        except NotImplementedError:
            return Outcome(self.name, "this system has none", ELSEWHERE)
        except OSError as error:
            return Outcome(self.name, error.strerror or str(error), self.advice)
        return Outcome(self.name)


def ask_for_fifo() -> Undo:
    """Run this thread, and all threads that it starts later, under SCHED_FIFO.

    Raises:
        OSError: the system refuses.
        NotImplementedError: the system has no SCHED_FIFO.
    """
    system = _scheduling()
    policy, parameter = system.sched_getscheduler(0), system.sched_getparam(0)
    if policy not in (system.SCHED_FIFO, system.SCHED_RR):  # the user may have chosen these with chrt
        system.sched_setscheduler(0, system.SCHED_FIFO, system.sched_param(PRIORITY))
    return lambda: system.sched_setscheduler(0, policy, parameter)


def give_up_priority() -> None:
    """Give this process ordinary scheduling, since it may have inherited SCHED_FIFO."""
    with suppress(NotImplementedError):
        system = _scheduling()
        system.sched_setscheduler(0, system.SCHED_OTHER, system.sched_param(0))


def _scheduling() -> Any:
    """Return `os` as Any, since type checkers recognize its scheduling functions only on Linux."""
    if not hasattr(os, "sched_setscheduler"):
        raise NotImplementedError
    return os


def ask_for_locked_memory() -> Undo:
    """Lock every page of the process in memory once the page is loaded.

    Raises:
        OSError: the system refuses, or limits locked memory.
        NotImplementedError: the system has no mlockall with Linux's flags.
    """
    if not LIMITS.exists():
        raise NotImplementedError
    if not _locks_without_limit():
        raise PermissionError(errno.EPERM, "the memory that may be locked is limited")
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    return lambda: libc.munlockall()


def _locks_without_limit() -> bool:
    """Return whether locked memory has no limit; with a limit, later allocations would fail [mlock(2)]."""
    if LIMITS.read_text("ascii").partition("Max locked memory")[2].split()[0] == "unlimited":
        return True
    status = Path("/proc/self/status").read_text("utf-8")
    capabilities = int(status.partition("CapEff:")[2].split()[0], 16)
    return bool(capabilities >> CAP_IPC_LOCK & 1)


REQUESTS = (
    SystemRequest(
        "SCHED_FIFO",
        ask_for_fifo,
        f'give the user "rtprio {PRIORITY}" in /etc/security/limits.conf and log in again, '
        "or give a container the capability SYS_NICE",
    ),
    SystemRequest(
        "locked memory",
        ask_for_locked_memory,
        'give the user "memlock unlimited" in /etc/security/limits.conf and log in again, '
        "or give a container the capability IPC_LOCK",
    ),
)


@contextmanager
def real_time(requests: tuple[SystemRequest, ...] = REQUESTS) -> Iterator[list[Outcome]]:
    """Make all requests, yield their outcomes, and undo them at the end.

    The requests also apply to threads that start within the context, so enter the context before a port is
    opened.
    """
    with ExitStack() as undo:
        yield [request.carry_out(undo) for request in requests]


@contextmanager
def frozen_collector() -> Iterator[None]:
    """Collect garbage once, then exclude existing objects from collections within the context."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
