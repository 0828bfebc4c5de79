"""What `--realtime` asks of the system, what it says of it, and that it takes it back."""

from __future__ import annotations

import ctypes
import errno
import gc
import os
import re
import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from types import SimpleNamespace

import pytest
from scanrack.commands import build
from scanrack.commands.programs.summary import summary
from scanrack.jobs.run.result import RunResult
from scanrack.runtime import FreeRun
from scanrack.runtime.loop import realtime
from scanrack.runtime.loop.pace import RealTime
from scanrack.runtime.loop.realtime import REQUESTS, Outcome, SystemRequest, frozen_collector, real_time
from typer.testing import CliRunner

LINUX_ONLY = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="Linux's scheduler and mlockall")


class Scheduler:
    """Stands in for the scheduling calls of `os`; as under a system that refuses, if `refuses`."""

    SCHED_OTHER, SCHED_FIFO, SCHED_RR = 0, 1, 2

    def __init__(self, policy: int = SCHED_OTHER, priority: int = 0, *, refuses: bool = False) -> None:
        self.now = (policy, priority)
        self.refuses = refuses

    sched_param = staticmethod(lambda priority: priority)
    strerror = staticmethod(os.strerror)

    def sched_getscheduler(self, _pid: int) -> int:
        return self.now[0]

    def sched_getparam(self, _pid: int) -> int:
        return self.now[1]

    def sched_setscheduler(self, _pid: int, policy: int, parameter: int) -> None:
        if self.refuses:
            raise PermissionError(errno.EPERM, "Operation not permitted")
        self.now = (policy, parameter)


def test_the_scans_run_under_sched_fifo_and_afterwards_as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    scheduler = Scheduler()
    monkeypatch.setattr(realtime, "os", scheduler)
    with real_time(REQUESTS[:1]) as outcomes:
        assert scheduler.now == (Scheduler.SCHED_FIFO, 40)
        assert outcomes == [Outcome("SCHED_FIFO")]
    assert scheduler.now == (Scheduler.SCHED_OTHER, 0)


@pytest.mark.parametrize("policy", [Scheduler.SCHED_FIFO, Scheduler.SCHED_RR])
def test_a_priority_that_the_user_has_chosen_stays(monkeypatch: pytest.MonkeyPatch, policy: int) -> None:
    scheduler = Scheduler(policy, 80)
    monkeypatch.setattr(realtime, "os", scheduler)
    with real_time(REQUESTS[:1]):
        assert scheduler.now == (policy, 80)
    assert scheduler.now == (policy, 80)


def test_a_refusal_says_why_and_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    scheduler = Scheduler(refuses=True)
    monkeypatch.setattr(realtime, "os", scheduler)
    with real_time(REQUESTS[:1]) as (outcome,):
        assert scheduler.now == (Scheduler.SCHED_OTHER, 0)
    assert str(outcome) == (
        'real time without SCHED_FIFO (Operation not permitted): give the user "rtprio 40" in '
        "/etc/security/limits.conf and log in again, or give a container the capability SYS_NICE"
    )


def test_a_system_that_has_no_such_thing_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(realtime, "os", SimpleNamespace())
    monkeypatch.setattr(realtime, "LIMITS", Path("nowhere"))
    with real_time() as outcomes:
        assert list(map(str, outcomes)) == [
            f"real time without {name} (this system has none): other programs delay scans: close them, "
            "or run on Linux, which has it"
            for name in ("SCHED_FIFO", "locked memory")
        ]


class LibC:
    """Stands in for the C library."""

    def __init__(self, error: int = 0) -> None:
        self.error, self.calls = error, list[tuple[str, int]]()

    def mlockall(self, flags: int) -> int:
        self.calls.append(("mlockall", flags))
        ctypes.set_errno(self.error)
        return -1 if self.error else 0

    def munlockall(self) -> int:
        self.calls.append(("munlockall", 0))
        return 0


@pytest.fixture
def locked(monkeypatch: pytest.MonkeyPatch) -> Callable[..., LibC]:
    def with_library(error: int = 0, *, unlimited: bool = True) -> LibC:
        library = LibC(error)
        monkeypatch.setattr(realtime.ctypes, "CDLL", lambda *_, **__: library)
        monkeypatch.setattr(realtime, "_locks_without_limit", lambda: unlimited)
        return library

    return with_library


@LINUX_ONLY
def test_memory_is_locked_and_released(locked: Callable[..., LibC]) -> None:
    """MCL_CURRENT 1, MCL_FUTURE 2, MCL_ONFAULT 4 [mlock(2)]."""
    library = locked()
    with real_time(REQUESTS[1:]) as outcomes:
        assert outcomes == [Outcome("locked memory")]
    assert library.calls == [("mlockall", 7), ("munlockall", 0)]


@LINUX_ONLY
def test_a_lock_that_is_refused_gives_its_reason(locked: Callable[..., LibC]) -> None:
    library = locked(errno.ENOMEM)
    with real_time(REQUESTS[1:]) as (outcome,):
        pass
    assert outcome.refusal == os.strerror(errno.ENOMEM)
    assert "memlock unlimited" in outcome.advice
    assert library.calls == [("mlockall", 7)]


@LINUX_ONLY
def test_behind_a_limit_nothing_is_locked_because_later_allocations_would_fail(
    locked: Callable[..., LibC],
) -> None:
    library = locked(unlimited=False)
    with real_time(REQUESTS[1:]) as (outcome,):
        pass
    assert outcome.refusal == "the memory that may be locked is limited"
    assert library.calls == []


@LINUX_ONLY
@pytest.mark.parametrize(
    ("limit", "capabilities", "unlimited"),
    [
        ("unlimited", "0000000000000000", True),
        ("8388608", "0000000000004000", True),
        ("8388608", "00000000a80425fb", False),
    ],
    ids=["no limit", "CAP_IPC_LOCK is bit 14", "a container's usual capabilities"],
)
def test_a_limit_counts_without_the_capability(
    monkeypatch: pytest.MonkeyPatch, limit: str, capabilities: str, unlimited: bool
) -> None:
    texts = {
        "limits": f"Max processes  95000  95000  processes\nMax locked memory  {limit}  unlimited  bytes\n",
        "status": f"Name:\tpython\nCapEff:\t{capabilities}\nSeccomp:\t0\n",
    }
    monkeypatch.setattr(Path, "read_text", lambda path, _encoding: texts[path.name])
    assert realtime._locks_without_limit() is unlimited


def test_what_was_granted_is_taken_back_when_the_next_request_breaks() -> None:
    undone: list[str] = []

    def broken() -> Callable[[], object]:
        raise RuntimeError("a mistake of ours")

    requests = (
        SystemRequest("first", lambda: lambda: undone.append("first"), ""),
        SystemRequest("second", broken, ""),
    )
    with pytest.raises(RuntimeError, match="a mistake of ours"), ExitStack() as stack:
        stack.enter_context(real_time(requests))
    assert undone == ["first"]


@pytest.mark.slow
def test_the_collector_is_frozen_and_thawed() -> None:
    before = gc.get_freeze_count()
    with frozen_collector():
        assert gc.get_freeze_count() > before
    assert gc.get_freeze_count() == 0


# -- on the command line -----------------------------------------------------------------------------

RACK = 'program = "logic.py"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'


@pytest.fixture
def rack(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "logic.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    return "rack.toml"


def run(*arguments: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(build(), ["run", *arguments, "--no-record"])
    return result.exit_code, result.stdout, result.stderr


@pytest.mark.slow
def test_a_run_says_first_what_it_got(rack: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(realtime, "os", Scheduler(refuses=True))
    monkeypatch.setattr(realtime, "_locks_without_limit", lambda: False)
    code, out, err = run(rack, "--realtime", "--scans", "3")
    assert code == 0
    assert re.findall(r"^scanrack: real time without (\S+ ?\w*) \(", err, re.MULTILINE) == [
        "SCHED_FIFO",
        "locked memory",
    ]
    assert re.search(r"^late scans    (none|\d)", out, re.MULTILINE)


@pytest.mark.slow
def test_a_quiet_run_and_one_in_virtual_time_say_nothing_of_it(rack: str) -> None:
    for arguments in (("--realtime", "--scans", "3", "-q"), ("--scans", "3")):
        code, out, err = run(rack, *arguments)
        assert code == 0
        assert "real time" not in err
        assert "late scans" not in out


@pytest.mark.slow
def test_the_collector_is_frozen_while_scans_run(rack: str, tmp_path: Path) -> None:
    program = "import gc\n\ndef logic(scan):\n    assert (gc.get_freeze_count() > 1000) is {frozen}\n"
    for options, frozen in ((("--realtime",), True), ((), False)):
        (tmp_path / "logic.py").write_text(program.format(frozen=frozen), encoding="utf-8")
        assert run(rack, "--scans", "3", *options)[0] == 0


def test_spin_without_realtime_is_refused(rack: str) -> None:
    code, _, err = run(rack, "--spin", "--scans", "3")
    assert (code, err) == (2, "scanrack: --spin needs --realtime: virtual time does not wait\n")


@pytest.mark.slow
def test_spin_begins_scans_on_time(rack: str) -> None:
    assert run(rack, "--realtime", "--spin", "--scans", "3")[0] == 0


NOTHING_RAN = RunResult(0, 0, [], [], [], [], None)


def test_the_summary_counts_late_scans_by_size() -> None:
    """8 scans: 3 on time, 2 late by 0.1 to 0.3 ms, 1 by 30 to 100 ms, 2 by more; 5 of 8 are 62.5 %."""
    pacer = RealTime()
    pacer.late = [3, 2, 0, 0, 0, 0, 1, 2]
    lines = summary(NOTHING_RAN, 16_000_000, pacer).splitlines()
    at = lines.index("late scans    5 of 8 (62.50%)")
    assert lines[at + 1 : at + 4] == [
        "                2 by 0.1 ms to 0.3 ms",
        "                1 by 30 ms to 100 ms",
        "                2 by 100 ms or more",
    ]


def test_a_run_in_virtual_time_has_no_late_scans() -> None:
    assert "late scans" not in summary(NOTHING_RAN, 16_000_000, FreeRun())
