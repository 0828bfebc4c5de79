"""Import every module of the installed package, and what each extra that is named adds.

Run without the checkout on the path (`python -P`): what is imported is what was installed.
"""

import importlib
import pkgutil
import re
import sys
from importlib.metadata import requires

import scanrack

MODULE_OF = {
    "mcap-ros2-support": "mcap_ros2",
    "myst-parser": "myst_parser",
    "z3-solver": "z3",
}
"""Modules that are not called like their distribution."""

NEEDS_EXTRA = {
    "scanrack.lsp.server": "editor",
    "scanrack.pytest_plugin": "test",
    "scanrack.testing.routines": "test",
    "scanrack.testing.rung_coverage": "test",
}
"""Modules of ours that are imported only with an extra, and where it is installed."""


def added_by(extra: str) -> list[str]:
    """Return the modules that an extra adds."""
    lines = [line for line in requires("scanrack") or () if f"extra == '{extra}'" in line.replace('"', "'")]
    if not lines:
        raise SystemExit(f"scanrack has no extra {extra!r}")
    names = [re.split(r"[^\w.-]", line)[0] for line in lines]
    return [MODULE_OF.get(name, name) for name in names]


def main() -> None:
    """Import, and print how many modules of scanrack there are."""
    ours = [each.name for each in pkgutil.walk_packages(scanrack.__path__, "scanrack.")]
    others = [name for extra in sys.argv[1:] for name in added_by(extra)]
    ours = [name for name in ours if NEEDS_EXTRA.get(name) in (None, *sys.argv[1:])]
    for name in ours + others:
        importlib.import_module(name)
    print(f"{len(ours)} modules imported, and {', '.join(others) or 'no extra'}")


main()
