"""The checks of axe-core (Deque Systems) in a page; a test is skipped where the npm package is missing."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from watched_page import Look

RUN = """
const done = arguments[0];
axe.run(document, { resultTypes: ["violations"] }).then(({ violations }) =>
  done(violations.flatMap(({ id, nodes }) => nodes.map(node => `${id}: ${node.target.join(" ")}`))));
"""


def axe_findings(look: Look) -> list[str]:
    """Return what axe finds in the page that is open: the rule and the element."""
    folders = filter(None, os.environ.get("NODE_PATH", "").split(os.pathsep))
    scripts = [script for each in folders if (script := Path(each, "axe-core", "axe.min.js")).exists()]
    if not scripts:
        pytest.skip("the npm package axe-core is not installed where node finds it (NODE_PATH)")
    look.browser.execute_script(scripts[0].read_text(encoding="utf-8"))
    found: list[str] = look.browser.execute_async_script(RUN)
    return found
