"""Who may use an encrypted OPC UA server, with the clients of asyncua and node-opcua; what others learn."""

from __future__ import annotations

import asyncio
import random
import re
import socket
import struct
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from peers import node
from ua_bench import Bench, channel, named, served, status_of

pytestmark = [pytest.mark.extra("opcua"), pytest.mark.slow]

USER, PASSWORD = "ann", "a pass:word"
CLIENT = "read_ua.cjs"


def users_file(folder: Path) -> Path:
    path = folder / "users"
    path.write_text(f"{USER}:{PASSWORD}\n", encoding="utf-8")
    path.chmod(0o600)
    return path


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    folder = tmp_path_factory.mktemp("secured")
    with served(folder, users=users_file(folder)) as bench:
        yield bench


APPLICATION = "urn:peer:client"


async def client_with_certificate(bench: Bench, folder: Path, application: str = APPLICATION) -> Any:
    """Return a client that encrypts with a certificate of its own, and is nobody yet.

    Args:
        application: its URI, which the certificate names unless it is another one.
    """
    from asyncua import ua
    from asyncua.crypto.cert_gen import setup_self_signed_certificate
    from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256
    from cryptography.x509.oid import ExtendedKeyUsageOID

    client = bench.connection()
    client.application_uri = application
    key, certificate = folder / "client.pem", folder / "client.der"
    uses = [ExtendedKeyUsageOID.CLIENT_AUTH]
    await setup_self_signed_certificate(key, certificate, APPLICATION, "peer", uses, {})
    mode = ua.MessageSecurityMode.SignAndEncrypt
    await client.set_security(SecurityPolicyBasic256Sha256, certificate, key, mode=mode)
    return client


async def connected_as(bench: Bench, folder: Path, user: str = "", password: str = "") -> Any:
    client = await client_with_certificate(bench, folder)
    if user:
        client.set_user(user)
        client.set_password(password)
    await client.connect()
    return client


@pytest.mark.peer("asyncua")
def test_a_user_reads_and_writes_and_others_do_not(bench: Bench, tmp_path: Path) -> None:
    async def work() -> None:
        from asyncua import ua

        client = await connected_as(bench, tmp_path, USER, PASSWORD)
        (node,) = named(client, "aDint")
        await node.write_value(ua.Variant(-4711, ua.VariantType.Int32))
        assert await node.read_value() == bench.tags["aDint"] == -4711
        ((_, order),) = bench.orders.given
        assert re.search(r"'text': 'ann \(127\.0\.0\.1:\d+\) writes aDint\.'", order)
        await client.disconnect()
        begun = time.monotonic()
        assert await status_of(connected_as(bench, tmp_path, USER, "a pass")) == "BadUserAccessDenied"
        assert time.monotonic() - begun >= 1.0  # guessing takes time
        assert await status_of(connected_as(bench, tmp_path, "bob", PASSWORD)) == "BadUserAccessDenied"
        assert await status_of(connected_as(bench, tmp_path)) == "BadIdentityTokenRejected"

    asyncio.run(work())


@pytest.mark.peer("asyncua")
def test_a_client_is_the_application_that_its_certificate_names(bench: Bench, tmp_path: Path) -> None:
    """And so is the server: its endpoint, its certificate and its arrays have one URI."""

    async def work() -> None:
        from cryptography.x509 import (
            SubjectAlternativeName,
            UniformResourceIdentifier,
            load_der_x509_certificate,
        )

        async with channel(await client_with_certificate(bench, tmp_path, "urn:another:client")) as client:
            assert await status_of(client.create_session()) == "BadCertificateUriInvalid"
        client = await connected_as(bench, tmp_path, USER, PASSWORD)
        (endpoint,) = await client.get_endpoints()
        certificate = load_der_x509_certificate(endpoint.ServerCertificate)
        names = certificate.extensions.get_extension_for_class(SubjectAlternativeName).value
        (uri,) = names.get_values_for_type(UniformResourceIdentifier)
        assert endpoint.Server.ApplicationUri == uri
        assert (await client.get_namespace_array())[1] == uri
        assert await client.get_node("i=2254").read_value() == [uri]
        await client.disconnect()

    asyncio.run(work())


def test_without_encryption_a_client_learns_how_to_connect_and_nothing_else(bench: Bench) -> None:
    async def work() -> None:
        from asyncua import ua

        async with channel(bench.connection()) as client:
            (endpoint,) = await client.get_endpoints()
            assert endpoint.SecurityPolicyUri.endswith("#Basic256Sha256")
            assert endpoint.SecurityMode == ua.MessageSecurityMode.SignAndEncrypt
            assert [each.TokenType for each in endpoint.UserIdentityTokens] == [ua.UserTokenType.UserName]
            (node,) = named(client, "aDint")
            closed = "BadSecurityModeInsufficient"
            assert await status_of(node.read_value()) == closed
            assert await status_of(node.get_children()) == closed
            assert await status_of(client.create_session()) == closed
            assert await status_of(client.activate_session(USER, PASSWORD)) == closed
            registering = client.uaclient.register_server(
                ua.RegisteredServer(ServerNames=[ua.LocalizedText("x")])
            )
            assert await status_of(registering) == "BadServiceUnsupported"
            shown = [each.ApplicationName.Text for each in await client.find_servers()]
            assert shown == ["scanrack bench"]  # itself
        unsecured = bench.connection()
        unsecured.set_user(USER)
        unsecured.set_password(PASSWORD)
        assert await status_of(unsecured.connect()) == closed

    asyncio.run(work())


def test_the_session_of_another_client_is_of_no_use(bench: Bench, tmp_path: Path) -> None:
    """Tokens of asyncua's sessions are easily guessed: a connection that knows one does not get in."""

    async def work() -> None:
        owner = await connected_as(bench, tmp_path, USER, PASSWORD)
        token = owner.uaclient.protocol.authentication_token
        async with channel(await client_with_certificate(bench, tmp_path)) as thief:
            thief.uaclient.protocol.authentication_token = token
            thief._server_nonce = b"0" * 32
            refusals = [
                await status_of(thief.activate_session()),
                await status_of(named(thief, "aDint")[0].read_value()),
            ]
        assert refusals == ["BadSessionIdInvalid", "BadUserAccessDenied"]
        await owner.disconnect()

    asyncio.run(work())


def test_only_trusted_certificates_get_in_once_there_are_such(tmp_path: Path) -> None:
    """A stranger may show a trusted certificate in its request: what counts is that of its channel."""
    known, strange, rack = (tmp_path / each for each in ("known", "strange", "rack"))
    for each in (known, strange, rack / "opcua" / "trusted"):
        each.mkdir(parents=True)

    async def work(bench: Bench) -> None:
        client = await connected_as(bench, known)
        assert await named(client, "aDint")[0].read_value() == 123456
        await client.disconnect()
        assert await status_of(connected_as(bench, strange)) == "BadCertificateUntrusted"
        async with channel(await client_with_certificate(bench, strange)) as stranger:
            stranger.security_policy.host_certificate = client.security_policy.host_certificate
            assert await status_of(stranger.create_session()) == "BadCertificateUntrusted"

    async def made() -> None:
        from asyncua.crypto.cert_gen import setup_self_signed_certificate
        from cryptography.x509.oid import ExtendedKeyUsageOID

        key, certificate = known / "client.pem", rack / "opcua" / "trusted" / "known.der"
        uses = [ExtendedKeyUsageOID.CLIENT_AUTH]
        await setup_self_signed_certificate(key, certificate, "urn:peer:client", "peer", uses, {})
        (known / "client.der").write_bytes(certificate.read_bytes())

    asyncio.run(made())
    with served(rack, "encrypted") as bench:
        asyncio.run(work(bench))


def test_certificates_of_strangers_end_their_own_connection(
    bench: Bench, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Random bytes, and the beginning of a good one, in the request that opens a channel."""
    rng, pid = random.Random(5), bench.service.pid
    good = (bench.folder / "opcua" / "server.der").read_bytes()
    policy = b"http://opcfoundation.org/UA/SecurityPolicy#Basic256Sha256"
    for number in range(50):
        strange = good[: rng.randrange(len(good))] if number % 2 else rng.randbytes(rng.randrange(900))
        texts = b"".join(struct.pack("<i", len(each)) + each for each in (policy, strange, rng.randbytes(20)))
        body = bytes(4) + texts + rng.randbytes(256)
        url = b"opc.tcp://x"
        hello = struct.pack("<5Ii", 0, 1 << 16, 1 << 16, 0, 0, len(url)) + url
        with socket.create_connection(("127.0.0.1", bench.service.port), 5) as client:
            client.sendall(b"HELF" + struct.pack("<I", 8 + len(hello)) + hello)
            assert client.recv(28)[:4] == b"ACKF"
            client.sendall(b"OPNF" + struct.pack("<I", 8 + len(body)) + body)
            with suppress(ConnectionResetError):
                assert client.recv(1 << 12) == b""

    async def work() -> None:
        client = await connected_as(bench, tmp_path, USER, PASSWORD)
        assert await named(client, "Locked")[0].read_value() == 7
        await client.disconnect()

    asyncio.run(work())
    assert bench.service.pid == pid
    assert capfd.readouterr() == ("", "")


@pytest.mark.peer("node-opcua-client")
def test_node_opcua_connects_encrypted_as_a_user(bench: Bench, tmp_path: Path) -> None:
    bench.orders.given.clear()
    where = f"opc.tcp://127.0.0.1:{bench.service.port}/scanrack"
    home = {name: str(tmp_path) for name in ("HOME", "XDG_CONFIG_HOME", "APPDATA", "LOCALAPPDATA")}
    told = node("node-opcua-client", CLIENT, where, USER, PASSWORD, env=home)
    assert told["encrypted"] == {"wrote": "Good", "aDint": 777, "locked": "BadNotWritable"}
    assert (told["wrong"], bench.tags["aDint"]) == ("BadUserAccessDenied", 777)
    assert "ANONYMOUS" in told["nobody"]
    assert "End point must exist" in told["open"]
    assert len(bench.orders.given) == 1
