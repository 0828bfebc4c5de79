"""`python -m scanrack`, and the `scanrack` command; neither imports anything from the current folder."""

import gc
import sys


def main() -> None:
    """Run the `scanrack` command, see `commands.main`.

    Ctrl-C during its import, which takes a tenth of a second, ends it with the same message as later.
    """
    gc.set_threshold(20_000)  # by default a start searches thousands of modules' objects for garbage 80 times
    try:
        from .commands import main as command

        command()
    except KeyboardInterrupt:
        sys.stderr.write("scanrack: stopped by Ctrl-C\n")
        sys.exit(130)


if __name__ == "__main__":
    if not sys.flags.safe_path:  # with -m the current folder is first
        del sys.path[0]  # noqa: TID251 - before anything is imported
    main()
