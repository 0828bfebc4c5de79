"""The page in Firefox, as in Chromium: it opens, pauses, steps, shows a tag and the past, and is narrow."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest

PEER = Path(__file__).parents[1] / "peers" / "firefox_page.cjs"
FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox")


def test_firefox_shows_the_page_as_chromium_does(feeder):
    node = shutil.which("node")
    if node is None or FIREFOX is None:
        pytest.skip("node or Firefox is not installed (Debian: nodejs, firefox-esr)")
    if subprocess.run(
        [node, "-e", "require.resolve('puppeteer-core')"], check=False, capture_output=True
    ).returncode:
        pytest.skip("the npm package puppeteer-core is not installed where node finds it (NODE_PATH)")
    done = subprocess.run(
        [node, str(PEER), FIREFOX, feeder.link],
        capture_output=True,
        text=True,
        timeout=180,
        check=False,
        encoding="utf-8",
    )
    assert (done.returncode, done.stderr) == (0, "")
    seen = json.loads(done.stdout)
    assert seen["errors"] == []
    assert seen["tag"] == "Homing"
    reach, width = seen["wide"]
    assert reach <= width == 400
