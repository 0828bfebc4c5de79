"""`python -m scanrack`, and the `scanrack` command; neither imports anything from the current folder."""

import gc
import sys

if __name__ == "__main__" and not sys.flags.safe_path:  # with -m the current folder is first
    del sys.path[0]  # noqa: TID251 - before anything is imported that a file could be

import signal

ENDING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)]
"""Signals that end every command as Ctrl-C does."""


def main() -> None:
    """Run the `scanrack` command, see `commands.main`.

    A signal during its import, which takes a tenth of a second, ends it with the same message as later. One
    that comes after its end changes no status: a terminal that is closed sends SIGHUP twice.
    """
    gc.set_threshold(20_000)  # by default a start searches thousands of modules' objects for garbage 80 times
    ending = [each for each in ENDING if signal.getsignal(each) is not signal.SIG_IGN]  # as under nohup
    for number in ending:
        signal.signal(number, _stop)
    try:
        from scanrack.commands import main as command

        command()
    except KeyboardInterrupt as stop:
        sys.stderr.write(f"scanrack: stopped by {stop.args[0] if stop.args else 'Ctrl-C'}\n")
        sys.exit(130)
    finally:
        for number in ending:  # the end of Python resets handlers, but leaves what is ignored
            signal.signal(number, signal.SIG_IGN)


def _stop(number: int, _frame: object) -> None:
    for each in ENDING:  # whoever sends a second one wants no more
        signal.signal(each, signal.SIG_IGN)
    raise KeyboardInterrupt(signal.Signals(number).name)


if __name__ == "__main__":
    main()
