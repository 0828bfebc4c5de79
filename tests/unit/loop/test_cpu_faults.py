"""What ends a run early, and that everything is closed in order."""

import asyncio
import inspect
import signal
from typing import Any

import pytest
from scanrack.runtime import Cpu, CpuFault, CpuMode, ScanFlag
from scanrack.runtime.loop.events import Event
from scanrack.runtime.loop.faults import Cause
from scanrack.runtime.loop.listeners import ScanListener

MS = 1_000_000


def breaking_at(number):
    def logic(scan):
        scan.slot[1].outputs[0] = 9
        if scan.number == number:
            raise ArithmeticError("the sum is wrong")

    return logic


def line_of(function, text):
    """Return the line of this file on which `text` stands in `function`."""
    lines, start = inspect.getsourcelines(function)
    return start + next(index for index, line in enumerate(lines) if text in line)


def test_logic_that_raises(rack, module, diary):
    cpu = Cpu(rack, breaking_at(2), 2 * MS, listeners=[diary])
    with pytest.raises(CpuFault) as caught:
        cpu.run(10)
    fault = caught.value.fault
    assert cpu.fault is fault
    assert (fault.scan, fault.now_ns, fault.cause) == (2, 4 * MS, Cause.PROGRAM)
    assert fault.text == "ArithmeticError: the sum is wrong"
    assert fault.where == f"{__file__}:{line_of(breaking_at, 'raise')}"
    assert str(caught.value) == (
        f"scan 2 (t = 0.004 s): the program raised ArithmeticError: the sum is wrong [{fault.where}]"
    )
    assert isinstance(caught.value.__cause__, ArithmeticError)


class Odd(BaseException):
    """No Exception."""


ODD = [GeneratorExit, asyncio.CancelledError, KeyboardInterrupt, SystemExit, Odd]


@pytest.mark.parametrize("error", ODD, ids=lambda each: each.__name__)
def test_whatever_logic_raises_faults_the_cpu(rack, module, diary, error):
    """`raise KeyboardInterrupt` is no Ctrl-C. Outputs are zero; the scan is on record."""

    def logic(scan):
        scan.slot[1].outputs[0] = 9
        if scan.number == 2:
            raise error("odd")

    cpu = Cpu(rack, logic, 2 * MS, listeners=[diary])
    with pytest.raises(CpuFault) as caught:
        cpu.run(10)
    assert (caught.value.fault.cause, caught.value.fault.text) == (Cause.PROGRAM, f"{error.__name__}: odd")
    assert diary.scans[-1] == (2, 4 * MS, ScanFlag.RUN | ScanFlag.FAULT)
    assert (diary.word(2), diary.closed) == (0, 1)


def test_a_real_ctrl_c_is_no_fault(rack, diary):
    """The signal arrives while the program runs."""

    def logic(scan):
        signal.raise_signal(signal.SIGINT)

    cpu = Cpu(rack, logic, listeners=[diary])
    with pytest.raises(KeyboardInterrupt):
        cpu.run(10)
    assert cpu.fault is None


def test_what_logic_raises_at_its_end_keeps_nothing_from_being_closed(rack, diary):
    class Logic:
        def __call__(self, scan):
            raise ArithmeticError("first")

        def __attach_logic__(self, slots):
            """Need nothing."""

        def __close_logic__(self):
            raise GeneratorExit("last")

    with pytest.raises(CpuFault) as caught:
        Cpu(rack, Logic(), listeners=[diary]).run(1)
    assert caught.value.__notes__ == ["while stopping: GeneratorExit: last"]
    assert diary.closed == 1


def test_blame_follows_the_phase_that_ran(rack):
    """A listener calls the program anew, which raises then: the phase was that of the listeners."""
    calls = []

    def logic(scan):
        calls.append(scan)
        if len(calls) > 1:
            raise ArithmeticError("called twice")

    class Again(ScanListener):
        def event(self, scan, now_ns, topic, fields):
            """Ignore events."""

        def scan(self, scan, now_ns, flags):
            cpu._phases.logic()

        def close(self):
            """Nothing is held."""

    cpu = Cpu(rack, logic, 2 * MS, listeners=[Again()])
    with pytest.raises(CpuFault) as caught:
        cpu.run(1)
    assert caught.value.fault.cause is Cause.LISTENER


def test_the_order_of_a_fault(rack, module, diary, log):
    with pytest.raises(CpuFault):
        Cpu(rack, breaking_at(1), 2 * MS, listeners=[diary]).run(10)
    at_fault = log[log.index(("update", 2 * MS, 9)) + 1 :]
    assert at_fault == [("plc_run", False), ("event", "/faults"), ("scan", 1), "close"]
    assert diary.scans[-1] == (1, 2 * MS, ScanFlag.RUN | ScanFlag.FAULT)
    assert [diary.word(scan) for scan in range(2)] == [9, 0]
    assert diary.topic("/faults") == [
        (
            1,
            2 * MS,
            {
                "cause": "program",
                "where": f"{__file__}:{line_of(breaking_at, 'raise')}",
                "text": "ArithmeticError: the sum is wrong",
            },
        )
    ]


def test_a_fault_in_the_first_scan_still_tells_the_mode(rack, diary, log):
    with pytest.raises(CpuFault):
        Cpu(rack, breaking_at(0), listeners=[diary]).run(10)
    assert [entry for entry in log if entry[0] == "event"] == [("event", "/cpu"), ("event", "/faults")]


def test_what_modules_say_on_stopping_is_still_told(rack, module, diary):
    def plc_run(running):
        module.events.append(Event(2 * MS, "move", "relative", "The move was cut."))

    module.plc_run = plc_run
    with pytest.raises(CpuFault):
        Cpu(rack, breaking_at(1), 2 * MS, listeners=[diary]).run(10)
    assert [scan for scan, _, _ in diary.topic("/events")] == [1]


def test_in_test_mode_a_module_is_not_told_twice(rack, module, diary):
    with pytest.raises(CpuFault):
        Cpu(rack, breaking_at(1), mode=CpuMode.TEST, listeners=[diary]).run(10)
    assert module.log.count(("plc_run", False)) == 1


def test_a_faulted_cpu_stays_down(rack):
    cpu = Cpu(rack, breaking_at(0))
    with pytest.raises(CpuFault):
        cpu.run(1)
    with pytest.raises(ValueError, match="the CPU has faulted: scan 0"):
        cpu.run(1)


def test_a_mistake_below_the_program_is_shown_in_the_program(rack):
    def logic(scan):
        scan.slot[1].outputs[0] = 70_000

    with pytest.raises(CpuFault) as caught:
        Cpu(rack, logic).run(1)
    assert caught.value.fault.text == "ValueError: word 70000 is out of range: must be -32768 to 65535"
    assert caught.value.fault.where == f"{__file__}:{line_of(logic, '70_000')}"


def test_a_program_that_is_no_python_function_has_a_place_too(rack):
    with pytest.raises(CpuFault) as caught:
        Cpu(rack, int).run(1)  # type: ignore[arg-type]
    assert caught.value.fault.cause is Cause.PROGRAM
    assert "phases.py:" in caught.value.fault.where


def test_a_module_that_raises(rack, module, diary):
    def script(now_ns):
        if now_ns == 4 * MS:
            raise RuntimeError("the axis is gone")
        return 0

    module.script = script
    with pytest.raises(
        CpuFault, match=r"scan 2 .* a module failed: RuntimeError: the axis is gone"
    ) as caught:
        Cpu(rack, lambda scan: None, 2 * MS, listeners=[diary]).run(10)
    assert caught.value.fault.cause is Cause.MODULE
    assert diary.scans[-1] == (2, 4 * MS, ScanFlag.RUN | ScanFlag.FAULT)
    assert diary.closed == 1


class Full:
    """A listener whose disk is full at scan 3."""

    def __init__(self, log):
        self.log = log

    def event(self, scan, now_ns, topic, fields):
        self.log.append(("full", topic))

    def scan(self, scan, now_ns, flags):
        if scan == 3:
            raise OSError(28, "No space left on device", "run.mcap")

    def close(self):
        self.log.append("full closed")


@pytest.mark.parametrize("place", [0, 1])
def test_a_listener_that_fails_hears_nothing_further_and_the_others_do(rack, module, diary, log, place):
    listeners = [diary]
    listeners.insert(place, Full(log))
    cpu = Cpu(rack, breaking_at(99), 2 * MS, listeners=listeners)
    with pytest.raises(
        CpuFault, match=r"scan 3 \(t = 0.006 s\): a listener failed: OSError: .*run.mcap"
    ) as caught:
        cpu.run(10)
    assert caught.value.fault.cause is Cause.LISTENER
    assert isinstance(caught.value.__cause__, OSError)
    closing = ["full closed", "close"] if place == 0 else ["close", "full closed"]
    assert log[log.index(("plc_run", False)) :] == [("plc_run", False), ("event", "/faults"), *closing]
    assert rack.slots[1].outputs[0] == 0


def test_what_fails_while_stopping_is_noted_and_does_not_hide_the_fault(rack, module, diary):
    plain: Any = type(diary)

    class Stubborn(plain):
        def close(self):
            super().close()
            raise OSError("cannot be closed")

    stubborn = Stubborn(rack.memory)
    with pytest.raises(CpuFault, match="the sum is wrong") as caught:
        Cpu(rack, breaking_at(1), listeners=[stubborn, diary]).run(10)
    assert caught.value.__notes__ == ["while stopping: OSError: cannot be closed"]
    assert (stubborn.closed, diary.closed) == (1, 1)
