"""A listening port has places for its clients; a silent one gives way."""

from __future__ import annotations

import socket
from contextlib import suppress

import pytest
from scanrack.runtime.line.ports import places
from scanrack.runtime.line.ports.modbustcp import ModbusTcpPort
from scanrack.runtime.line.ports.places import make_place


def test_the_client_that_is_silent_for_longest_gives_way() -> None:
    here = [socket.socket() for _ in range(places.CLIENTS_MAX)]
    heard = {each: at for at, each in enumerate(here, 1)}
    assert make_place(dict(list(heard.items())[1:]), 0) == (None, True)
    assert make_place(heard, places.SILENT_NS) == (None, False)  # 1 ns too early
    assert make_place(heard, places.SILENT_NS + 1) == (here[0], True)
    for each in here:
        each.close()


@pytest.mark.parametrize("silent", [False, True])
def test_a_port_with_all_places_taken(monkeypatch: pytest.MonkeyPatch, silent: bool) -> None:
    monkeypatch.setattr(places, "CLIENTS_MAX", 1)
    monkeypatch.setattr(places, "SILENT_NS", 0 if silent else 10**15)
    port = ModbusTcpPort("127.0.0.1", 0)
    at = port.name.rpartition(":")
    first = socket.create_connection(("127.0.0.1", int(at[2])))
    while not port.connections:
        port.serve(1, lambda _unit, pdu: pdu)
    first.sendall(b"\0\1\0\0\0")  # half a frame
    second = socket.create_connection(("127.0.0.1", int(at[2])))
    second.sendall(b"\0\2\0\0\0\2\1\7")
    gone, stays = (first, second) if silent else (second, first)
    gone.setblocking(False)
    ended = False
    while not ended:
        port.serve(0.01, lambda _unit, pdu: pdu)
        try:
            ended = not gone.recv(1)
        except BlockingIOError:
            continue
        except ConnectionError:
            ended = True
    reply = b""
    while silent and not reply:
        port.serve(0.01, lambda _unit, pdu: pdu)
        stays.setblocking(False)
        with suppress(BlockingIOError):
            reply = stays.recv(8)
    assert reply == (b"\0\2\0\0\0\2\1\7" if silent else b"")
    assert port.connections == 1
    port.close()
    first.close()
    second.close()
