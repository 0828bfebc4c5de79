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
