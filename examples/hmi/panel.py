"""A panel in the browser for the feeder, over OPC UA.

    scanrack run examples/hmi/feeder.toml --realtime --server opc-ua
    python examples/hmi/panel.py

Then open http://127.0.0.1:8090. Another server is `panel.py opc.tcp://HOST:PORT/scanrack`.
"""

from __future__ import annotations

import argparse
import asyncio
import json
from collections.abc import Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from asyncua import Client, ua

SHOWN = ("Running", "Trouble", "Position", "Strokes.ACC", "HmiLength")
WRITTEN: Mapping[str, ua.VariantType] = {
    "HmiStart": ua.VariantType.Boolean,
    "HmiStop": ua.VariantType.Boolean,
    "HmiLength": ua.VariantType.Int32,
}
PAGE = Path(__file__).with_name("panel.html")


class Feeder:
    """The feeder's tags: values that a subscription brings, and writes."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self.values: dict[str, Any] = {}

    def node(self, tag: str) -> Any:
        """Return the node of a tag."""
        return self._client.get_node(f"ns=2;s={tag}")

    async def follow(self) -> None:
        """Keep `values` as they are in the rack."""
        subscription = await self._client.create_subscription(200, self)
        await subscription.subscribe_data_change([self.node(tag) for tag in SHOWN])

    def datachange_notification(self, node: Any, value: Any, _data: Any) -> None:
        """Take a value; asyncua calls this."""
        self.values[node.nodeid.Identifier] = value

    async def write(self, tag: str, value: Any) -> None:
        """Write a tag."""
        await self.node(tag).write_value(ua.Variant(value, WRITTEN[tag]))


def handler(feeder: Feeder, loop: asyncio.AbstractEventLoop) -> type[BaseHTTPRequestHandler]:
    """Return what answers the browser."""

    class Panel(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            if self.path == "/":
                self._answer(200, "text/html; charset=utf-8", PAGE.read_bytes())
            elif self.path == "/tags":
                self._answer(200, "application/json", json.dumps(feeder.values).encode())
            else:
                self._answer(404)

        def do_POST(self) -> None:
            tag = self.path.removeprefix("/write/")
            if tag not in WRITTEN or self.headers["X-Panel"] != "1":  # no other page can send this header
                return self._answer(404)
            try:
                value = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
                asyncio.run_coroutine_threadsafe(feeder.write(tag, value), loop).result(10)
            except (ValueError, ua.UaError) as error:
                return self._answer(400, "text/plain", str(error).encode())
            return self._answer(204)

        def _answer(self, status: int, kind: str = "text/plain", body: bytes = b"") -> None:
            self.send_response(status)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_words: Any) -> None:
            """Print nothing: the page asks every 200 ms."""

    return Panel


async def main(server: str, port: int) -> None:
    """Serve the panel until Ctrl-C."""
    async with Client(server) as client:
        feeder = Feeder(client)
        await feeder.follow()
        panel = ThreadingHTTPServer(("127.0.0.1", port), handler(feeder, asyncio.get_running_loop()))
        print(f"http://127.0.0.1:{panel.server_port}", flush=True)
        await asyncio.to_thread(panel.serve_forever)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("server", nargs="?", default="opc.tcp://127.0.0.1:4840/scanrack")
    parser.add_argument("--port", type=int, default=8090)
    given = parser.parse_args()
    asyncio.run(main(given.server, given.port))
