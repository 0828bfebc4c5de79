"""The folders of the product, as setup.py names them."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]


def _beside() -> tuple[str, ...]:
    tree = ast.parse((ROOT / "setup.py").read_text(encoding="utf-8"))
    for node in tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "BESIDE":
            return tuple(ast.literal_eval(node.value))
    raise LookupError("setup.py has no BESIDE")


BESIDE = _beside()
"""Folders that are installed in `scanrack`."""

ROOMS = ("scanrack", *(name for name in BESIDE if name != "examples"))
"""Folders with the product's own code."""
