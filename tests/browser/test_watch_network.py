"""The network between page and rack is cut: no old picture is shown as live, and the page comes back."""

from __future__ import annotations

import pytest
from cut_network import network
from watched_page import until


def test_a_page_that_was_cut_off_is_live_again(page, feeder):
    port = int(feeder.base.rpartition(":")[2])
    try:
        with network(port) as cable:
            page.open(feeder.link.replace("127.0.0.1", "[::1]"))
            cable.cut()
            page.until_handle("state", "lost")
            assert "lost" in page.run("return document.getElementById('notice').textContent")
            last = int(page.handle("scan"))
            cable.begin()
            page.until_handle("state", "live")
            until(lambda: int(page.handle("scan")) > last)
            cable.frozen = True  # no end of the connection tells it
            page.until_handle("state", "lost")
            cable.frozen = False
            page.until_handle("state", "live")
            last = int(page.handle("scan"))
            until(lambda: int(page.handle("scan")) > last)
    except OSError as error:
        pytest.skip(f"there is no IPv6 loopback here: {error}")


UNSENT = """
const send = WebSocket.prototype.send, now = performance.now.bind(performance);
window.sent = [];
WebSocket.prototype.send = function (text) {
  const { do: what } = JSON.parse(text);
  sent.push(what);
  if (what !== "share") send.call(this, text);
};
performance.now = () => now() + (window.later ?? 0);
"""


def test_an_answer_that_takes_long_in_a_pause_does_not_look_like_a_cut_network(page, feeder):
    """Broken on purpose: nothing is requested while an answer is awaited, so that 10 s later all is lost."""
    page.open(feeder.link)
    page.until_handle("state", "live")
    page.press("Pause")
    page.until_handle("state", "paused")
    page.run(UNSENT)
    page.press("Write a page to share")
    for _ in range(4):  # 12 s
        page.run("window.sent = []; window.later = (window.later ?? 0) + 3000")
        until(lambda: "here" in page.run("return sent"))
    assert page.handle("state") == "paused"
    assert "is being written" in page.run("return document.getElementById('notice').textContent")
