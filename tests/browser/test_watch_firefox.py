"""The page in Firefox, as in Chromium: it shows the rack and its past, is narrow, and keys alone do all.

Broken on purpose: a disabled button loses the focus, `/` keeps what was typed, no answer of a question: red.
"""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from watched_page import watching

PEER = Path(__file__).parents[1] / "peers" / "firefox_page.cjs"
FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox")


def in_firefox(link: str, task: str) -> Any:
    """Return what a task in Firefox saw."""
    node = shutil.which("node")
    if node is None or FIREFOX is None:
        pytest.skip("node or Firefox is not installed (Debian: nodejs, firefox-esr)")
    if subprocess.run(
        [node, "-e", "require.resolve('puppeteer-core')"], check=False, capture_output=True
    ).returncode:
        pytest.skip("the npm package puppeteer-core is not installed where node finds it (NODE_PATH)")
    done = subprocess.run(
        [node, str(PEER), FIREFOX, link, task],
        capture_output=True,
        text=True,
        timeout=180,
        check=False,
        encoding="utf-8",
    )
    assert (done.returncode, done.stderr) == (0, "")
    seen = json.loads(done.stdout)
    assert seen["errors"] == []
    return seen


def test_firefox_shows_the_page_as_chromium_does(feeder):
    seen = in_firefox(feeder.link, "look")
    assert seen["tag"] == "Homing"
    reach, width = seen["wide"]
    assert reach <= width == 400


def test_keys_alone_cancel_an_edit_remove_a_force_and_run_an_answer_in_firefox(running_rack):
    with watching(running_rack, "--paused", "--time-scale", "max") as session:
        seen = in_firefox(session.link, "work")
    assert seen["drafts"] == 0
    assert "For Feeding 1 after scan 1,601:" in seen["answer"]
    assert "Open estop (slot 1)" in seen["answer"]
    assert seen["feeding"] == "1"
