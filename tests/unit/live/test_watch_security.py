"""Who may look, and what a page can do to the scans: nothing.

Broken on purpose: Host not compared, Origin not compared, any key taken, orders taken by a read-only session,
an unchecked order: each turns a test red.
"""

import asyncio
import json
import random
from types import SimpleNamespace
from typing import Any

import pytest
from scanrack.commands import build
from scanrack.traces import open_trace
from scanrack.watch.monitors.page import Page
from scanrack.watch.server import OUTBOX_MOST, Server
from typer.testing import CliRunner
from watching import page_of, watched
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed


@pytest.fixture(scope="module")
def session():
    with watched("--time-scale", "1") as running:
        yield running


def get(session, path="/", host=None, more=""):
    return session.raw(f"GET {path} HTTP/1.1\nHost: {host or session.host}\n{more}Connection: close\n\n")


UPGRADE = (
    "Upgrade: websocket\nConnection: Upgrade\nSec-WebSocket-Version: 13\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\n"
)


def upgrade(session, origin=None, host=None):
    more = UPGRADE + ("" if origin is None else f"Origin: {origin}\n")
    return session.raw(f"GET /socket HTTP/1.1\nHost: {host or session.host}\n{more}\n")[0]


def test_the_page_comes_with_its_headers(session):
    status, answer = get(session)
    head = answer.partition("\r\n\r\n")[0]
    assert status == 200
    assert "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'" in head
    assert "unsafe" not in head
    assert "X-Content-Type-Options: nosniff" in head
    assert "Referrer-Policy: no-referrer" in head
    assert "frame-ancestors 'none'" in head
    assert "X-Frame-Options: DENY" in head


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1", "localhost:1", "127.0.0.1.evil.example:80", ""]
)
def test_a_foreign_host_is_misdirected(session, host):
    assert session.raw(f"GET / HTTP/1.1\nHost: {host}\nConnection: close\n\n")[0] == 421


def test_two_hosts_or_none_are_misdirected(session):
    assert session.raw("GET / HTTP/1.1\nConnection: close\n\n")[0] == 421
    assert session.raw(f"GET / HTTP/1.1\nHost: {session.host}\nHost: evil\n\n")[0] == 421


@pytest.mark.parametrize("origin", ["null", "http://evil.example", "https://127.0.0.1", "http://localhost:1"])
def test_a_foreign_origin_is_forbidden(session, origin):
    assert upgrade(session, origin) == 403


def test_our_own_origins_and_none_are_let_in(session):
    assert upgrade(session) == 101
    assert upgrade(session, f"http://{session.host}") == 101
    localhost = f"localhost:{session.port}"
    assert upgrade(session, f"http://{localhost}", host=localhost) == 101


@pytest.mark.parametrize(
    "path", ["/nothing", "/../pyproject.toml", "/%2e%2e/x", "/web/", "//index.html", "/__pycache__"]
)
def test_nothing_but_the_files_of_the_page_is_served(session, path):
    assert get(session, path)[0] == 404


def closing(session, first):
    """Return why the socket of a page that begins like that is closed."""

    async def begin():
        async with connect(f"ws://{session.host}/socket") as opened:
            await opened.send(first)
            with pytest.raises(ConnectionClosed) as closed:
                await asyncio.wait_for(opened.recv(), 10)
            return closed.value.rcvd and closed.value.rcvd.code

    return asyncio.run(begin())


@pytest.mark.parametrize(
    "first", ["{}", "nonsense", "[]", '{"key": 5}', '{"key": "0"}', '{"key": "\\ud800"}', b"\xff\xfe"]
)
def test_without_the_key_the_socket_is_closed(session, first):
    assert closing(session, first) == 1008


async def closed_with(page):
    """Return why the socket of a page is closed."""
    try:
        while True:
            await page.hear()
    except ConnectionClosed as closed:
        return closed.rcvd and closed.rcvd.code


def test_a_message_of_more_than_64_kib_closes_the_socket_and_nothing_else(session):
    async def send():
        async with page_of(session) as page:
            await page.socket.send("x" * ((1 << 16) + 1))
            assert await closed_with(page) == 1009  # message too big [RFC 6455, section 7.4.1]
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frames > 2)

    asyncio.run(send())


@pytest.mark.slow
def test_the_ninth_page_is_sent_away(session):
    async def open_nine():
        pages = [page_of(session) for _ in range(8)]
        opened = [await page.__aenter__() for page in pages]
        for page in opened:
            await page.hear()
        async with page_of(session) as ninth:
            assert await closed_with(ninth) == 1013  # try again later
        for page in pages:
            await page.__aexit__(None, None, None)

    asyncio.run(open_nine())


def test_more_than_100_messages_a_second_are_refused(session):
    async def flood():
        async with page_of(session) as page:
            for number in range(150):
                await page.socket.send(json.dumps({"id": number, "do": "watch", "tags": []}))
            refused = 0
            for _ in range(400):
                message = await page.hear()
                refused += "100 messages a second" in message.get("answer", {}).get("refused", "")
                if refused == 50:
                    return True
        return False

    assert asyncio.run(flood())


ANSWERED = {
    "a list to do": '{"id": 1, "do": []}',
    "an object to do": '{"id": 1, "do": {}}',
    "a factor that no float holds": '{"id": 1, "do": "speed", "factor": 1' + "0" * 400 + "}",
    "a factor beyond all": '{"id": 1, "do": "speed", "factor": 1e999}',
    "half a surrogate pair as id": '{"id": "\\ud800", "do": "pause"}',
    "half a surrogate pair as tag": '{"id": 1, "do": "xref", "tag": "\\ud800"}',
    **{
        f"{depth} levels": '{"id": 1, "do": "write", "tag": "T", "value": ' + "[" * depth + "]" * depth + "}"
        for depth in (20, 900, 975, 980, 985, 1000, 30_000)
    },
}
"""Most of them closed the socket, or had no answer: nesting did so near 980 levels only."""


def test_each_message_that_can_not_be_used_has_an_answer_of_its_own(session):
    async def ask(message):
        async with page_of(session) as page:
            await page.socket.send(message)
            while True:
                heard = await page.hear()
                if "answer" in heard:
                    return heard["answer"]

    for name, message in ANSWERED.items():
        assert asyncio.run(ask(message)).get("refused"), name


def test_a_page_that_reads_no_answers_does_not_fill_the_memory():
    """Also a refusal takes memory."""
    page = Page()
    server: Any = Server.__new__(Server)
    server._monitor = SimpleNamespace(ask=lambda page, said: page.send({"answer": said}))
    for _ in range(OUTBOX_MOST + 100):
        server._take(page, '{"id": 1}')
    assert len(page.outbox) == OUTBOX_MOST


@pytest.mark.slow
def test_a_read_only_session_takes_no_order():
    async def order(session):
        async with page_of(session) as page:
            answer = await page.ask("pause")
            assert answer["refused"] == "this session is read-only: it accepts no actions"
            assert page.hello["read_only"]
            assert (await page.ask("show", routine="Main"))["ok"]

    with watched("--read-only") as running:
        asyncio.run(order(running))


def nonsense(dice):
    """Return a message that may mean anything."""
    words = [
        "mode",
        "press",
        "write",
        "force",
        "step",
        "speed",
        "incident",
        "breakpoint",
        "look",
        "show",
        "why",
    ]
    keys = ["id", "do", "tag", "value", "slot", "name", "on", "mode", "scan", "scans", "at", "kind", "factor"]
    values: list[object] = [None, True, 0, -1, 1 << 80, 0.5, "", "Main", "Homing", "\x00", "<b>", "all"]
    values += [[], {}, [1], "max"]
    kind = dice.randrange(4)
    if kind == 0:
        return bytes(dice.randrange(256) for _ in range(dice.randrange(40)))
    if kind == 1:
        return json.dumps(dice.choice(values))
    message = {key: dice.choice(values) for key in dice.sample(keys, dice.randrange(6))}
    message["do"] = dice.choice(words)
    return json.dumps(message)


@pytest.mark.slow
def test_ten_thousand_nonsense_messages_leave_the_trace_whole(tmp_path):
    """They come at once: most of them are refused for their number, the first 100 of each page are not."""
    path = tmp_path / "session.mcap"
    dice = random.Random(7)

    async def send(session):
        for _ in range(10):
            async with page_of(session) as page:
                await page.hear()

                async def hear(page=page):
                    while True:
                        await page.hear()

                hearing = asyncio.create_task(hear())
                for _ in range(1000):
                    await page.socket.send(nonsense(dice))
                hearing.cancel()
        async with page_of(session) as page:
            await page.ask("unforce", tag="all")
            await page.ask("unbreak", at="all")
            await page.ask("mode", mode="run")
            await page.ask("go")
            await page.until(lambda seen: seen.frame.get("state") == "live")
            begun = page.frame["scan"]
            await page.until(lambda seen: seen.frame["scan"] > max(begun + 20, 100))
            assert page.frame["mode"] == "run"

    with watched("--record", path) as session:
        asyncio.run(send(session))
        assert session.end() == 130
    with open_trace(path) as trace:
        assert trace.notes == []
        assert sum(1 for _ in trace.scans()) > 100
    done = CliRunner().invoke(build(), ["replay", "--into", "session", str(path)])
    assert done.exit_code == 0, done.output
