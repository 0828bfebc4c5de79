"""How scanrack is installed today; all messages and pages take it from here.

No package of that name is published yet. When it is, set `SOURCE` to "scanrack";
`python -m tests.tools.generate` then updates the pages.
"""

from __future__ import annotations

SOURCE: str = "."
"""The argument of `pip install`: "." is the folder of a checkout."""


def install_line(extra: str = "", tool: str = "pip") -> str:
    """Return the command by which a tool installs scanrack, with an extra if one is given.

    It uses double quotes, which all shells have, including that of Windows.

    >>> install_line(), install_line("plot")
    ('pip install .', 'pip install ".[plot]"')
    """
    return f'{tool} install "{SOURCE}[{extra}]"' if extra else f"{tool} install {SOURCE}"


def how_to_install(extra: str = "") -> str:
    """Return the command, and where to run it, for a message.

    >>> how_to_install("plot")
    'pip install ".[plot]" in a checkout of scanrack'
    """
    return install_line(extra) + (" in a checkout of scanrack" if SOURCE == "." else "")
