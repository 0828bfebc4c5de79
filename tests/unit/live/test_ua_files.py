"""Files of an encrypted OPC UA server: made once, never overwritten, refused if others may read a secret."""

from __future__ import annotations

import os
from base64 import encodebytes
from collections.abc import Callable
from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.jobs.run.servers import ua_files
from scanrack.jobs.run.servers.kinds import ServerAddress, addresses
from scanrack.jobs.run.servers.ua_files import thumbprint, ua_security
from scanrack.runtime.tag_servers.ua_security import UaSecurity, users_of
from served_tags import write_rack
from typer.testing import CliRunner

LOCAL = "127.0.0.1"
FIRST = next((Path(__file__).parents[3] / "examples" / "first").glob("*.toml"))
needs_asyncua = pytest.mark.extra("opcua")


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("ann", "line 1: must be name:password"),
        ("# users\n\n:secret", "line 3: must be name:password"),
        ("ann:", "must be name:password"),
        ("ann:1\nann:2", "line 2: 'ann' appears above; list each user once"),
        ("# nobody", "1 to 64 users"),
        ("\n".join(f"u{n}:x" for n in range(65)), "1 to 64 users"),
        (f"ann:{'é' * 65}", "at most 128 bytes"),
        ("an\x1bn:1", r"line 1: 'an\\x1bn' has characters that can't be printed"),
    ],
)
def test_a_file_of_users_that_can_not_be_used_is_refused(text: str, part: str) -> None:
    with pytest.raises(ValueError, match=part):
        users_of(text)


def test_a_user_logs_in_with_the_whole_password_only() -> None:
    security = UaSecurity(b"", "", b"", users_of("ann: a b:c \nbob:x"))
    assert security.accepts("ann", " a b:c ")
    for name, password in [
        ("ann", "a b:c"),
        ("ann", "x"),
        ("", ""),
        (None, None),
        ("eve", ""),
        ("bob", "\ud800"),
    ]:
        assert not security.accepts(name, password)
    assert "a b" not in repr(security)


@needs_asyncua
@pytest.mark.parametrize(
    ("server", "security", "users", "encrypted"),
    [
        ("opc-ua", None, None, False),
        ("opc-ua", "encrypted", None, True),
        ("opc-ua", None, Path("users"), True),
        ("opc-ua:0.0.0.0:4840", None, None, True),
        ("opc-ua:0.0.0.0:4840", "none", None, False),
    ],
)
def test_it_is_open_on_this_machine_and_encrypted_elsewhere(
    server: str, security: str | None, users: Path | None, encrypted: bool
) -> None:
    first, second = addresses(["ethernet-ip", server], security, users)
    assert first == ServerAddress.parse("ethernet-ip")
    assert (second.encrypted, second.users) == (encrypted, users)


@needs_asyncua
@pytest.mark.parametrize(
    ("servers", "security", "users", "part"),
    [
        ([], "encrypted", None, "--opc-ua-security needs --server opc-ua"),
        (["ethernet-ip"], None, Path("users"), "--opc-ua-users needs --server opc-ua"),
        (["opc-ua"], "none", Path("users"), "--opc-ua-users needs encryption"),
    ],
)
def test_options_that_secure_nothing_are_refused(
    servers: list[str], security: str | None, users: Path | None, part: str
) -> None:
    with pytest.raises(ValueError, match=part):
        addresses(servers, security, users)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a key and a certificate."""
    folder = tmp_path_factory.mktemp("made")
    ua_security(folder, LOCAL, None)
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    """Return a copy of it."""
    (tmp_path / "opcua").mkdir()
    for each in (made / "opcua").iterdir():
        copy = tmp_path / "opcua" / each.name
        copy.write_bytes(each.read_bytes())
        copy.chmod(each.stat().st_mode)
    return tmp_path


@needs_asyncua
def test_key_and_certificate_are_made_once(made: Path) -> None:
    place = made / "opcua"
    before = {each.name: each.read_bytes() for each in place.iterdir()}
    assert set(before) == {"server-key.pem", "server.der", ".gitignore"}
    assert os.name != "posix" or (place / "server-key.pem").stat().st_mode & 0o777 == 0o600
    security = ua_security(made, "0.0.0.0", None)
    assert {each.name: each.read_bytes() for each in place.iterdir()} == before
    assert (security.certificate, security.key) == (before["server.der"], before["server-key.pem"])
    assert security.uri.startswith("urn:")
    assert security.uri.encode() in security.certificate
    assert bytes([127, 0, 0, 1]) in security.certificate  # the address of the first start
    assert security.trusted is None
    assert len(thumbprint(security.certificate)) == 40


def other_key(place: Path) -> None:
    from cryptography.hazmat.primitives.asymmetric import rsa
    from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

    key = rsa.generate_private_key(public_exponent=65537, key_size=2048)
    (place / "server-key.pem").write_bytes(
        key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    )


def expired(place: Path) -> None:
    from cryptography.hazmat.primitives.serialization import Encoding, load_pem_private_key

    key = load_pem_private_key((place / "server-key.pem").read_bytes(), None)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(ua_files, "DAYS", 0)
        (place / "server.der").write_bytes(ua_files._self_signed(key, LOCAL).public_bytes(Encoding.DER))


def strange_file(place: Path) -> None:
    (place / "trusted").mkdir()
    (place / "trusted" / "notes.der").write_text("hello", encoding="utf-8")


def dangling_link(place: Path) -> None:
    try:
        (place / "trusted").symlink_to(place / "missing", target_is_directory=True)
    except OSError:
        pytest.skip("this user may not make symbolic links")


@needs_asyncua
@pytest.mark.parametrize(
    ("spoil", "part"),
    [
        (lambda place: (place / "server.der").unlink(), "server.der is missing"),
        (lambda place: (place / "server-key.pem").unlink(), "server-key.pem is missing"),
        (lambda place: (place / "server-key.pem").chmod(0o640), "other users may read"),
        (lambda place: (place / "server-key.pem").write_bytes(b"no key"), "must be a private key in PEM"),
        (lambda place: (place / "server.der").write_bytes(b"nothing"), "must be a certificate in DER"),
        (lambda place: (place / "server.der").write_bytes(bytes(1 << 17)), "more than 65,536 bytes"),
        (other_key, "server-key.pem is the key of another certificate"),
        (expired, "server.der: valid until "),
        (strange_file, "notes.der: not a certificate"),
        (dangling_link, "trusted: must be a folder"),  # not: trust everybody
        (lambda place: (place / "trusted").write_bytes(b""), "trusted: must be a folder"),
    ],
)
def test_files_that_can_not_be_used_are_refused_and_left(
    folder: Path, spoil: Callable[[Path], object], part: str
) -> None:
    spoil(folder / "opcua")
    before = {each: each.read_bytes() for each in (folder / "opcua").iterdir() if each.is_file()}
    with pytest.raises(ValueError, match=part):
        ua_security(folder, LOCAL, None)
    assert {each: each.read_bytes() for each in (folder / "opcua").iterdir() if each.is_file()} == before


def pem_of(der: bytes) -> str:
    return f"-----BEGIN CERTIFICATE-----\n{encodebytes(der).decode()}-----END CERTIFICATE-----\n"


@needs_asyncua
def test_trusted_certificates_are_in_der_or_pem(folder: Path) -> None:
    trusted = folder / "opcua" / "trusted"
    trusted.mkdir()
    (trusted / ".gitkeep").touch()
    (trusted / ".DS_Store").write_bytes(b"Bud1")
    (trusted / "notes.txt").write_text("hello", "utf-8")
    (trusted / "old").mkdir()
    assert ua_security(folder, LOCAL, None).trusted == frozenset()  # nobody, not anybody
    first = (folder / "opcua" / "server.der").read_bytes()
    expired(folder / "opcua")
    second = (folder / "opcua" / "server.der").read_bytes()
    (folder / "opcua" / "server.der").write_bytes(first)
    (trusted / "a.DER").write_bytes(first)
    assert ua_security(folder, LOCAL, None).trusted == {first}
    (trusted / "b.pem").write_text(f"two of them\n{pem_of(first)}{pem_of(second)}", "utf-8")
    assert ua_security(folder, LOCAL, None).trusted == {first, second}


@needs_asyncua
@pytest.mark.parametrize("name", ["a.der", "a.pem", "a.crt", "a.cer"])
def test_each_usual_suffix_is_read(folder: Path, name: str) -> None:
    der = (folder / "opcua" / "server.der").read_bytes()
    (folder / "opcua" / "trusted").mkdir()
    (folder / "opcua" / "trusted" / name).write_text(pem_of(der), "utf-8")
    assert ua_security(folder, LOCAL, None).trusted == {der}


@needs_asyncua
def test_others_may_not_read_the_passwords(folder: Path) -> None:
    users = folder / "users"
    users.write_text("ann:secret\n", "utf-8")
    users.chmod(0o644)
    with pytest.raises(ValueError, match="chmod 600"):
        ua_security(folder, LOCAL, users)
    users.chmod(0o600)
    assert ua_security(folder, LOCAL, users).accepts("ann", "secret")
    users.write_text("ann:secret\n", "utf-8-sig")  # as Notepad of Windows writes it
    assert ua_security(folder, LOCAL, users).accepts("ann", "secret")
    users.write_text("ann\n", "utf-8")
    with pytest.raises(ValueError, match="users: line 1"):
        ua_security(folder, LOCAL, users)
    with pytest.raises(ValueError, match="missing: no such file"):
        ua_security(folder, LOCAL, folder / "missing")


@pytest.mark.parametrize("command", ["run", "watch"])
@pytest.mark.parametrize("option", [["--opc-ua-security", "encrypted"], ["--opc-ua-users", "users"]])
def test_commands_refuse_security_without_a_server(command: str, option: list[str], tmp_path: Path) -> None:
    words = [command, str(FIRST), "--scans", "1", "--record", str(tmp_path / "a.mcap"), *option]
    done = CliRunner().invoke(build(), words)
    assert done.exit_code == 2
    assert f"{option[0]} needs --server opc-ua" in done.stderr


@needs_asyncua
@pytest.mark.slow
def test_the_first_lines_say_how_the_server_is_guarded(tmp_path: Path) -> None:
    rack, users = write_rack(tmp_path), tmp_path / "users"
    users.write_text("ann:secret\n", "utf-8")
    users.chmod(0o600)
    words = [
        "run",
        str(rack),
        "--scans",
        "1",
        "--no-record",
        "--server",
        "opc-ua:0",
        "--opc-ua-users",
        str(users),
    ]
    done = CliRunner().invoke(build(), words)
    said = [line for line in done.stderr.splitlines() if "Basic256Sha256" in line]
    (line,) = said
    der = (tmp_path / "opcua" / "server.der").read_bytes()
    assert thumbprint(der) in line
    assert "user ann; clients with any certificate: make opcua/trusted" in line
    assert "secret" not in done.stderr
    assert "asks for no password" not in done.stderr
