"""Names that a package imports on first use.

The package lists them as imports under `if TYPE_CHECKING:`. Type checkers and this module both read these
lines, so each name is written only once.
"""

from __future__ import annotations

import re
from importlib import import_module
from importlib.machinery import ModuleSpec

_IMPORT = re.compile(r"^    from (\S+) import (?:\(([^)]*)\)|(.+))$", re.MULTILINE)


def homes_in(spec: ModuleSpec) -> dict[str, str]:
    """Return the module of each name that a package lists, relative to the package.

    Args:
        spec: the package's `__spec__`.
    """
    # `get_data`, not `get_source`, which pytest's loader of a package with a plugin lacks
    text = spec.loader.get_data(spec.origin).decode("utf-8")  # type: ignore[union-attr]
    modules: dict[str, str] = {}
    for module, in_parentheses, in_line in _IMPORT.findall(text):
        names = map(str.strip, (in_parentheses or in_line).split(","))
        modules |= {name: module for name in names if name.isidentifier()}
    return modules


def listed_in(spec: ModuleSpec, name: str) -> object:
    """Import a name that a package lists; the package's `__getattr__` calls this.

    Args:
        spec: the package's `__spec__`.

    Raises:
        AttributeError: the package does not list the name.
    """
    module_name = homes_in(spec).get(name)
    if module_name is None:
        raise AttributeError(f"module {spec.name!r} has no attribute {name!r}")
    return imported_from(module_name, name, spec.name)


def imported_from(module: str, name: str, package: str) -> object:
    """Return an object from a module, or the module itself if it has that name.

    Raises:
        AttributeError: the module does not exist or does not define the name.
    """
    absent = AttributeError(f"module {package!r} has no attribute {name!r}")
    if name.startswith("_"):
        raise absent
    try:
        home = import_module(module, package)
    except ModuleNotFoundError as error:
        if error.name != f"{package}{module}":
            raise
        raise absent from None
    if module == f".{name}":
        return home
    if name not in vars(home):
        raise absent
    return vars(home)[name]
