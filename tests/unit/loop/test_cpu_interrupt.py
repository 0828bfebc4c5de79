"""Ctrl-C, sent for real: to this process once, to another one twice."""

import signal
import subprocess
import sys
import textwrap
import threading
from typing import Any

import pytest
from scanrack.runtime import Cpu


def test_ctrl_c_stops_between_scans_and_the_handler_comes_back(rack, diary):
    def logic(scan):
        if scan.number == 5:
            signal.raise_signal(signal.SIGINT)

    handler = signal.getsignal(signal.SIGINT)
    with Cpu(rack, logic, listeners=[diary]) as cpu, cpu.stopping_on_ctrl_c():
        cpu.run()
    assert cpu.stop_requested
    assert diary.scans[-1][0] == 5
    assert diary.closed == 1
    assert signal.getsignal(signal.SIGINT) is handler


def test_a_second_ctrl_c_breaks_out_of_the_logic():
    script = """
        import os, signal, sys
        from scanrack.runtime.loop.cpu import Cpu
        from scanrack.runtime.loop.pace import Watchdog
        from scanrack.runtime.loop.rack import Rack

        class Told:
            def event(self, scan, now_ns, topic, fields): pass
            def scan(self, scan, now_ns, flags): print("scan", scan)
            def close(self): print("closed")

        def logic(scan):
            signal.raise_signal(signal.SIGINT)
            while True:
                signal.raise_signal(signal.SIGINT)

        try:
            with Cpu(Rack([]), logic, listeners=[Told()], watchdog=Watchdog(0)) as cpu:
                with cpu.stopping_on_ctrl_c():
                    cpu.run()
        except KeyboardInterrupt:
            print("interrupted", cpu.stop_requested)
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
        encoding="utf-8",
    )
    assert done.stdout.split("\n") == ["closed", "interrupted True", ""]


def test_a_second_ctrl_c_outside_the_logic_lets_the_scan_be_finished(rack, diary):
    plain: Any = type(diary)

    class Impatient(plain):
        """Somebody presses Ctrl-C while it writes: twice in scan 3, which is enough."""

        def scan(self, scan, now_ns, flags):
            if scan == 3:
                signal.raise_signal(signal.SIGINT)
                signal.raise_signal(signal.SIGINT)
            super().scan(scan, now_ns, flags)

    impatient = Impatient(rack.memory)
    with Cpu(rack, lambda scan: None, listeners=[impatient]) as cpu, cpu.stopping_on_ctrl_c():
        cpu.run()
    assert [scan for scan, _, _ in impatient.scans] == [0, 1, 2, 3]


def test_a_third_ctrl_c_raises_anywhere(rack, module):
    def script(now_ns):
        for _ in range(3):
            signal.raise_signal(signal.SIGINT)

    module.script = script
    cpu = Cpu(rack, lambda scan: None)
    with pytest.raises(KeyboardInterrupt), cpu.stopping_on_ctrl_c():
        cpu.run()
    assert cpu.stop_requested


def test_elsewhere_than_in_the_main_thread_nothing_changes(rack):
    handler = signal.getsignal(signal.SIGINT)
    seen = []

    def elsewhere():
        with Cpu(rack, lambda scan: None).stopping_on_ctrl_c():
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert seen == [handler]
