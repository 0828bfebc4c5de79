"""A headless Chromium, driven over its debugging pipe: no library in between.

Messages of the DevTools protocol are JSON, each ended by a zero byte; the
browser reads them from its file descriptor 3 and answers on 4.
"""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
PATIENCE_S = 120
_OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--window-size=1300,800",
    "--remote-debugging-pipe",
)


class Chromium:
    """A browser with one page.

    Args:
        profile: an empty folder for its files.
    """

    def __init__(self, profile: Path) -> None:
        assert BROWSER is not None
        (reads, self._to), (self._from, writes) = os.pipe(), os.pipe()
        import fcntl  # Windows has none

        ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (reads, writes)]  # out of the way of 3 and 4
        self._process = subprocess.Popen(
            [BROWSER, *_OPTIONS, f"--user-data-dir={profile}"],
            preexec_fn=lambda: _become(ends),  # pass_fds alone would keep their numbers
            pass_fds=(3, 4),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for end in (reads, writes, *ends):
            os.close(end)
        self._rest, self._number = b"", 0
        target = self._call("Target.createTarget", {"url": "about:blank"})["targetId"]
        attached = self._call("Target.attachToTarget", {"targetId": target, "flatten": True})
        self._session = attached["sessionId"]

    _session: str | None = None

    def open(self, address: str) -> None:
        """Open a page and wait until it says that it is ready."""
        self._call("Page.navigate", {"url": "about:blank"})
        self._call("Page.navigate", {"url": address})
        give_up = time.monotonic() + PATIENCE_S
        while self.evaluate("document.body ? document.body.dataset.ready || '' : ''") != "yes":
            assert time.monotonic() < give_up, f"{address} is not ready"
            time.sleep(0.02)

    def evaluate(self, script: str) -> Any:
        """Return what an expression, or the promise of one, becomes."""
        asked = {"expression": script, "awaitPromise": True, "returnByValue": True}
        answer = self._call("Runtime.evaluate", asked)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def mouse(self, kind: str, x: float, y: float, **more: object) -> None:
        """Let the mouse do something: mouseMoved, mousePressed, mouseReleased or mouseWheel."""
        self._call("Input.dispatchMouseEvent", {"type": kind, "x": x, "y": y, **more})
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def look(self, width: int, height: int, scheme: str = "light") -> None:
        """Give the page a size and a scheme of colors, light or dark."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self._call("Emulation.setDeviceMetricsOverride", size)
        wanted = [{"name": "prefers-color-scheme", "value": scheme}]
        self._call("Emulation.setEmulatedMedia", {"features": wanted})

    def picture(self) -> bytes:
        """Return what the page looks like, a PNG."""
        return base64.b64decode(self._call("Page.captureScreenshot", {"format": "png"})["data"])

    def close(self) -> None:
        """End the browser."""
        self._process.terminate()
        self._process.wait(PATIENCE_S)
        os.close(self._to)
        os.close(self._from)

    def _call(self, method: str, given: Mapping[str, object]) -> dict[str, Any]:
        self._number += 1
        message: dict[str, object] = {"id": self._number, "method": method, "params": given}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                result: dict[str, Any] = answer["result"]
                return result

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._from], [], [], PATIENCE_S)
            assert ready, "the browser does not answer"
            piece = os.read(self._from, 65536)
            assert piece, "the browser has ended"
            self._rest += piece
        message, _, self._rest = self._rest.partition(b"\0")
        found: dict[str, Any] = json.loads(message)
        return found


def _become(ends: list[int]) -> None:
    """Let file descriptors be 3 and 4, in the process that is to be the browser."""
    for number, end in enumerate(ends, start=3):
        os.dup2(end, number)
