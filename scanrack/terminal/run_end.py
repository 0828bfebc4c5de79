"""The end of a run as a message and an exit status."""

from __future__ import annotations

from collections.abc import Callable

from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.faults import Cause, CpuFault
from scanrack.runtime.loop.pace import interrupted_by

from .status import CANNOT_WRITE, DONE, INTERRUPTED, NO, complain, reason


def run_to_end(cpu: Cpu, run: Callable[[], object], stopped: Callable[[], bool]) -> int:
    """Run scans, report the cause of their end, and return the exit status.

    Args:
        stopped: returns whether a signal has ended them.
    """
    try:
        run()
    except CpuFault as error:
        return complain_of_fault(error)
    except OSError as error:
        return complain(f"the trace can't be finished: {reason(error)}", CANNOT_WRITE)
    except KeyboardInterrupt:
        return complain(f"stopped by {interrupted_by()} in scan {cpu.scan}", INTERRUPTED)
    if stopped():
        return complain(f"stopped by {interrupted_by()} after {cpu.scan} scans", INTERRUPTED)
    return DONE


def complain_of_fault(error: CpuFault) -> int:
    """Report the CPU's fault; return the exit status."""
    cause = error.__cause__
    if error.fault.cause is Cause.LISTENER and isinstance(cause, OSError):
        return complain(f"scan {error.fault.scan}: the trace can't be written: {reason(cause)}", CANNOT_WRITE)
    notes = getattr(error, "__notes__", [])
    return complain("\n".join([f"the CPU has faulted in {error}", *notes]), NO)
