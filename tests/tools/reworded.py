"""Give every sentence of refusals and faults other words, and run the tests of the features that need places.

    python tests/tools/reworded.py            all features
    python tests/tools/reworded.py -k l5x     those of a name

Sentences are text for people: a feature that finds a rung, line or key in one breaks as soon as it is worded
better. The script lists the features and exits with 1 if one of them broke. Modules are changed in memory as
they are imported: as a plugin of pytest (`-p reworded`) it adds words before and behind the text of errors,
refusals, reports and rules.
"""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType
from typing import Any, cast

ROOT = Path(__file__).parents[2]
ROOMS = tuple(
    f"{ROOT / room}{os.sep}" for room in ("scanrack", "io_images", "ladder", "rockwell", "runtime", "traces")
)
FEATURES = "tests/unit/tools/test_places.py"
BEFORE, BEHIND = "in other words: ", ", so to speak"
SAYS = re.compile(r"[A-Za-z]{2}[,:']? +[a-z{]")
"""A text of several words, of which a name or a format is none."""

_REFUSING = "at fail report refuse refuse_object refuse_statement skipped refusal lose note"
CALLS = frozenset(("Damage", "Problem", "Refusal", "Violation", *_REFUSING.split()))
"""What takes sentences, beside errors; with or without an underscore before it."""
NAMES = frozenset(("text", "reason", "remedy", "says", "said", "wrong", "hint", "what"))
"""Variables that hold sentences."""
WHOLE = (f"debug{os.sep}why.py", f"jobs{os.sep}why{os.sep}answer.py")
"""Files all of whose sentences are answers."""

COUNTS: list[int] = []
"""Sentences that were changed, for each module."""


def between(text: str) -> str:
    """Return a text with a word between each two.

    >>> between("there is no tag ")
    'there indeed is indeed no indeed tag '
    """
    return re.sub(r"(?<=[a-z]) (?=[a-z])", " indeed ", text)


def other_words(text: str) -> str:
    """Return a sentence with more words before it, in it and behind it."""
    return f"{BEFORE}{between(text)}{BEHIND}"


class Rewording(ast.NodeTransformer):
    """Adds words to the sentences of a module; `whole` takes all but docstrings."""

    def __init__(self, whole: bool = False) -> None:
        self.count = 0
        self._inside = self._whole = whole

    def visit_Raise(self, node: ast.Raise) -> ast.AST:
        return self._changed(node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        takes = name.lstrip("_") in CALLS or name.endswith("Error")
        return self._changed(node) if takes else self.generic_visit(node)

    def visit_Assign(self, node: ast.Assign) -> ast.AST:
        named = any(isinstance(each, ast.Name) and each.id in NAMES for each in node.targets)
        return self._changed(node) if named else self.generic_visit(node)

    def visit_Expr(self, node: ast.Expr) -> ast.AST:
        return node if isinstance(node.value, ast.Constant) else self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if self._inside and isinstance(node.value, str) and SAYS.search(node.value):
            self.count += 1
            return ast.copy_location(ast.Constant(other_words(node.value)), node)
        return node

    def visit_JoinedStr(self, node: ast.JoinedStr) -> ast.AST:
        text = "".join(str(each.value) if isinstance(each, ast.Constant) else "{}" for each in node.values)
        if self._inside and SAYS.search(text):
            self.count += 1
            for each in node.values:
                if isinstance(each, ast.Constant):
                    each.value = between(str(each.value))
            node.values = [ast.Constant(BEFORE), *node.values, ast.Constant(BEHIND)]
        return node

    def _changed(self, node: ast.AST) -> ast.AST:
        before, self._inside = self._inside, True
        try:
            return self.generic_visit(node)
        finally:
            self._inside = before


def reworded(source: str, *, whole: bool = False) -> ast.Module:
    """Return the syntax tree of a module whose sentences have more words."""
    change = Rewording(whole)
    tree = cast(ast.Module, change.visit(ast.parse(source)))
    COUNTS.append(change.count)
    return ast.fix_missing_locations(tree)


def install() -> None:
    """Change our modules from now on, as they are imported."""
    plain = SourceFileLoader.get_code

    def get_code(self: SourceFileLoader, fullname: str) -> CodeType | None:
        path = self.get_filename(fullname)
        if not path.startswith(ROOMS):
            return plain(self, fullname)
        source = self.get_data(path).decode("utf-8")
        return cast(CodeType, compile(reworded(source, whole=path.endswith(WHOLE)), path, "exec"))

    SourceFileLoader.get_code = get_code  # type: ignore[method-assign, assignment]


def pytest_load_initial_conftests() -> None:
    """Change the modules before one is imported, and the text of each rule of the manual."""
    install()
    from scanrack.io_images.amci3601.rules import Rule

    Rule.text = property(lambda rule: other_words(rule.says or rule.event))  # type: ignore[method-assign, assignment]


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Say how many sentences had other words."""
    terminalreporter.write_line(f"{sum(COUNTS)} sentences of {len(COUNTS)} modules had other words")


def main(options: list[str]) -> int:
    """Run the tests of the features with other words; return 1 if one fails."""
    command = [sys.executable, "-m", "pytest", "-p", "reworded", "--processes", "1", FEATURES, "-v", *options]
    paths = os.pathsep.join(filter(None, (str(Path(__file__).parent), os.environ.get("PYTHONPATH"))))
    run = subprocess.run(command, cwd=ROOT, env={**os.environ, "PYTHONPATH": paths})
    return min(run.returncode, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
