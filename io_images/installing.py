"""The commands that install scanrack, for use in all messages and pages.

The package is not published yet. When it is, set `SOURCE` to "scanrack"; `python -m tests.tools.generate`
then updates the pages.
"""

from __future__ import annotations

SOURCE: str = "."
"""The argument of `pip install`: "." is the folder of a checkout."""


def install_line(extra: str = "", tool: str = "pip") -> str:
    """Return the command that installs scanrack, with an extra if given.

    It uses double quotes, which all shells understand, including Windows shells.

    >>> install_line(), install_line("plot")
    ('pip install .', 'pip install ".[plot]"')
    """
    return f'{tool} install "{SOURCE}[{extra}]"' if extra else f"{tool} install {SOURCE}"


def how_to_install(extra: str = "") -> str:
    """Return the command that installs scanrack and the folder to run it in, for messages.

    >>> how_to_install("plot")
    'pip install ".[plot]" in a checkout of scanrack'
    """
    return install_line(extra) + (" in a checkout of scanrack" if SOURCE == "." else "")
