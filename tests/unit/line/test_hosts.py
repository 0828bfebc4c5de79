"""Hosts and ports in text, and IPv6 from end to end."""

from __future__ import annotations

import pytest
from scanrack.runtime.line.clients.link import LinkError, TcpLink
from scanrack.runtime.line.hosts import join_address, split_address
from scanrack.runtime.line.ports.sockets import Listener


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("502", ("", 502)),
        (":502", ("", 502)),
        ("plc:0", ("plc", 0)),
        ("10.0.0.1:65535", ("10.0.0.1", 65_535)),
        ("[::1]:502", ("::1", 502)),
        ("[fe80::1%eth0]:502", ("fe80::1%eth0", 502)),
    ],
)
def test_addresses(text: str, address: tuple[str, int]) -> None:
    assert split_address(text) == address
    assert split_address(text.replace("[", "").replace("]", "")) == address
    assert not address[0] or join_address(*address) == text


@pytest.mark.parametrize("text", ["", "plc", "plc:", "plc:65536", "[::1]502", "[::1]", "plc:x", "p c:1"])
def test_what_is_no_address(text: str) -> None:
    with pytest.raises(ValueError, match=r"must be HOST:PORT or PORT.*\[::1\]:502"):
        split_address(text)


def test_a_client_reaches_a_server_over_ipv6() -> None:
    try:
        listener = Listener("::1", 0)
    except OSError:
        pytest.skip("this machine has no IPv6 loopback address")
    assert listener.name.startswith("[::1]:")
    link = TcpLink(*split_address(listener.name))
    link.send(b"?")
    heard: list[bytes] = []
    while not heard:
        heard = [data for _, data in listener.wait(1.0)]
    assert heard == [b"?"]
    listener.close()
    with pytest.raises(LinkError, match=r"\[::1\]:\d+ has closed the connection"):
        link.receive(1, 1.0)
    link.close()
