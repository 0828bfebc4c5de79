"""How scanrack is installed today: the one place that every message and page takes it from.

Nothing of that name is published. When it is, `SOURCE` becomes "scanrack", and
`python -m tests.tools.generate` puts that on the pages.
"""

from __future__ import annotations

SOURCE: str = "."
"""What pip installs: "." is the folder of a checkout."""


def install_line(extra: str = "", tool: str = "pip") -> str:
    """Return the command with which a tool installs scanrack, with an extra of it if one is given.

    Double quotes are those of every shell, that of Windows included.

    >>> install_line(), install_line("plot")
    ('pip install .', 'pip install ".[plot]"')
    """
    return f'{tool} install "{SOURCE}[{extra}]"' if extra else f"{tool} install {SOURCE}"


def how_to_install(extra: str = "") -> str:
    """Return the command and where it is given, for a message.

    >>> how_to_install("plot")
    'pip install ".[plot]" in a checkout of scanrack'
    """
    return install_line(extra) + (" in a checkout of scanrack" if SOURCE == "." else "")
