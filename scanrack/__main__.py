"""The `scanrack` command and `python -m scanrack`; neither one imports modules from the current folder."""

import gc
import sys

if __name__ == "__main__" and not sys.flags.safe_path:  # with -m, the current folder comes first
    del sys.path[0]  # noqa: TID251 - before any import that a file there could replace

import signal

ENDING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)]
"""Signals that end every command like Ctrl-C."""


def main() -> None:
    """Run the `scanrack` command; see `commands.main`.

    A signal during the import, which takes 0.1 s, ends the command with the same message as a later signal.
    A signal after the command has ended does not change the status, because a closed terminal sends SIGHUP
    twice.
    """
    gc.set_threshold(20_000)  # by default, the import runs 80 garbage collections over thousands of objects
    handled = [number for number in ENDING if signal.getsignal(number) is not signal.SIG_IGN]  # nohup ignores
    for number in handled:
        signal.signal(number, _stop)
    try:
        from scanrack.commands import main as command

        command()
    except KeyboardInterrupt as stop:
        sys.stderr.write(f"scanrack: stopped by {stop.args[0] if stop.args else 'Ctrl-C'}\n")
        sys.exit(130)
    finally:
        for number in handled:  # at exit, Python resets handlers but leaves ignored signals
            signal.signal(number, signal.SIG_IGN)


def _stop(number: int, _frame: object) -> None:
    for later in ENDING:
        signal.signal(later, signal.SIG_IGN)
    raise KeyboardInterrupt(signal.Signals(number).name)


if __name__ == "__main__":
    main()
