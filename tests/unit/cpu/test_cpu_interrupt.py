"""Ctrl-C, sent for real: to this process once, to another one twice."""

import os
import signal
import subprocess
import sys
import textwrap
import threading

from scanrack.runtime.cpu import Cpu
from scanrack.runtime.pace import stopping_on_interrupt


def test_ctrl_c_stops_between_scans_and_the_handler_comes_back(rack, diary):
    def logic(scan):
        if scan.number == 5:
            os.kill(os.getpid(), signal.SIGINT)

    handler = signal.getsignal(signal.SIGINT)
    with Cpu(rack, logic, listeners=[diary]) as cpu, stopping_on_interrupt(cpu.stop):
        cpu.run()
    assert cpu.stop_requested
    assert diary.scans[-1][0] == 5
    assert diary.closed == 1
    assert signal.getsignal(signal.SIGINT) is handler


def test_a_second_ctrl_c_breaks_out_of_the_logic():
    script = """
        import os, signal, sys
        from scanrack.runtime.cpu import Cpu
        from scanrack.runtime.pace import Watchdog, stopping_on_interrupt
        from scanrack.runtime.rack import Rack

        class Told:
            def event(self, scan, now_ns, topic, fields): pass
            def scan(self, scan, now_ns, flags): print("scan", scan)
            def close(self): print("closed")

        def logic(scan):
            os.kill(os.getpid(), signal.SIGINT)
            while True:
                os.kill(os.getpid(), signal.SIGINT)

        try:
            with Cpu(Rack([]), logic, listeners=[Told()], watchdog=Watchdog(0)) as cpu:
                with stopping_on_interrupt(cpu.stop):
                    cpu.run()
        except KeyboardInterrupt:
            print("interrupted", cpu.stop_requested)
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert done.stdout.split("\n") == ["closed", "interrupted True", ""]


def test_elsewhere_than_in_the_main_thread_nothing_changes():
    handler = signal.getsignal(signal.SIGINT)
    seen = []

    def elsewhere():
        with stopping_on_interrupt(lambda: None):
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert seen == [handler]
