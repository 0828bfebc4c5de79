"""Runs `python -m scanrack` and the `scanrack` command; neither imports anything from the current folder."""

import gc
import sys

if __name__ == "__main__" and not sys.flags.safe_path:  # with -m, the current folder comes first
    del sys.path[0]  # noqa: TID251 - before any import that a file there could replace

import signal

ENDING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)]
"""Signals that end every command like Ctrl-C."""


def main() -> None:
    """Run the `scanrack` command, see `commands.main`.

    A signal during the import, which takes a tenth of a second, ends it with the same message as a later
    signal. A signal after its end does not change the status: a terminal that is closed sends SIGHUP twice.
    """
    gc.set_threshold(20_000)  # by default, startup runs garbage collection 80 times over thousands of objects
    ending = [each for each in ENDING if signal.getsignal(each) is not signal.SIG_IGN]  # not under nohup
    for number in ending:
        signal.signal(number, _stop)
    try:
        from scanrack.commands import main as command

        command()
    except KeyboardInterrupt as stop:
        sys.stderr.write(f"scanrack: stopped by {stop.args[0] if stop.args else 'Ctrl-C'}\n")
        sys.exit(130)
    finally:
        for number in ending:  # at exit, Python resets handlers but leaves ignored signals
            signal.signal(number, signal.SIG_IGN)


def _stop(number: int, _frame: object) -> None:
    for each in ENDING:  # further signals ask for nothing more, and are ignored
        signal.signal(each, signal.SIG_IGN)
    raise KeyboardInterrupt(signal.Signals(number).name)


if __name__ == "__main__":
    main()
