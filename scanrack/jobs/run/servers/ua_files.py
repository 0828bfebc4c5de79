"""Manages the files of an encrypted OPC UA server, in the folder `opcua` beside the rack file.

    opcua/server-key.pem    the private key, mode 0600, created once
    opcua/server.der        its certificate, created with it
    opcua/trusted/          certificates of clients; the owner creates this folder

No file is ever overwritten, so the owner may put a key and a certificate from an authority there.
"""

from __future__ import annotations

import ipaddress
import os
import socket
from datetime import UTC, datetime
from hashlib import sha1
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scanrack.runtime.tag_servers.ua_security import UaSecurity, application_uri, uris_of, users_of

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

FOLDER, KEY, CERTIFICATE, TRUSTED = "opcua", "server-key.pem", "server.der", "trusted"

DAYS = 3653
"""Validity of a new certificate, days."""

KEY_BITS = range(2048, 4097)
"""RSA key lengths that Basic256Sha256 allows, bits [OPC UA part 7]."""

FILE_MOST = 1 << 16
"""Largest size of a key, certificate or users file, bytes."""

SUFFIXES = {".der", ".pem", ".crt", ".cer"}
"""Suffixes of certificates; other files in `trusted` are not read."""


def ua_security(folder: Path, host: str, users: Path | None) -> UaSecurity:
    """Read the files of a server; create its key and certificate if there are none.

    Args:
        folder: folder of the rack file.
        host: host on which it listens; a new certificate names it.
        users: file of user names and passwords.

    Raises:
        ValueError: a file can't be used or created, others may read a secret, or the certificate has expired.
    """
    names = {} if users is None else _read_users(users)
    ua_folder = folder / FOLDER
    key, certificate = ua_folder / KEY, ua_folder / CERTIFICATE
    if not key.exists() and not certificate.exists():
        _create_key_and_certificate(key, certificate, host)
    for file, other in ((key, certificate), (certificate, key)):
        if not file.exists():
            raise ValueError(f"{file} is missing: restore it, or delete {other.name} to create both")
    pem, der = _read_secret(key), _read(certificate)
    uri = _checked_uri(pem, der, key, certificate)
    return UaSecurity(der, uri, pem, names, _read_trusted(ua_folder / TRUSTED))


def thumbprint(certificate: bytes) -> str:
    """Return the SHA-1 of a certificate, as OPC UA clients show it."""
    return sha1(certificate).hexdigest().upper()


def _read_users(path: Path) -> dict[str, bytes]:
    """Return the passwords in a file by user name; raise ValueError, with the path, for an invalid file."""
    try:
        return users_of(_read_secret(path).decode("utf-8-sig"))  # Windows editors may add a byte order mark
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: must be UTF-8") from error
    except ValueError as error:
        text = str(error)
        raise ValueError(text if text.startswith(str(path)) else f"{path}: {text}") from error


def _read_secret(path: Path) -> bytes:
    """Return the content of a file that no one else may read."""
    content = _read(path)
    if os.name == "posix" and path.stat().st_mode & 0o077:
        raise ValueError(f"{path}: other users may read or change it: chmod 600 {path}")
    return content


def _read(path: Path) -> bytes:
    """Return the content of a regular file of at most `FILE_MOST` bytes; raise ValueError for any other."""
    try:
        if not path.is_file():
            raise ValueError(f"{path}: {'must be a regular file' if path.exists() else 'no such file'}")
        with path.open("rb") as file:
            content = file.read(FILE_MOST + 1)
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from error
    if len(content) > FILE_MOST:
        raise ValueError(f"{path}: more than {FILE_MOST:,} bytes")
    return content


def _read_trusted(folder: Path) -> frozenset[bytes] | None:
    """Return the certificates in a folder; None (trust any certificate) if the folder does not exist."""
    if not os.path.lexists(folder):
        return None
    if not folder.is_dir():
        raise ValueError(f"{folder}: must be a folder")
    from cryptography.hazmat.primitives.serialization import Encoding
    from cryptography.x509 import load_pem_x509_certificates

    trusted: set[bytes] = set()
    try:
        paths = sorted(file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES)
    except OSError as error:
        raise ValueError(f"{folder}: {error.strerror}") from error
    for path in paths:
        content = _read(path)
        try:
            is_text = b"-----BEGIN" in content
            certificates = load_pem_x509_certificates(content) if is_text else [_certificate_of(content)]
        except ValueError as error:
            raise ValueError(f"{path}: not a certificate") from error
        trusted.update(certificate.public_bytes(Encoding.DER) for certificate in certificates)
    return frozenset(trusted)


def _certificate_of(der: bytes) -> Certificate:
    from cryptography.x509 import load_der_x509_certificate

    return load_der_x509_certificate(der)


def _checked_uri(pem: bytes, der: bytes, key_path: Path, path: Path) -> str:
    """Return the URI that a certificate names; raise ValueError if it can't be used with the key."""
    from cryptography.hazmat.primitives.asymmetric.rsa import RSAPrivateKey
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    try:
        key = load_pem_private_key(pem, None)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{key_path}: must be a private key in PEM without a password") from error
    if not isinstance(key, RSAPrivateKey) or key.key_size not in KEY_BITS:
        raise ValueError(f"{key_path}: must be an RSA key of {KEY_BITS[0]} to {KEY_BITS[-1]} bits")
    uris = uris_of(der)
    if not uris:
        raise ValueError(f"{path}: must be a certificate in DER that names the URI of an application")
    certificate = _certificate_of(der)
    if certificate.public_key() != key.public_key():
        raise ValueError(f"{path}: {key_path.name} is the key of another certificate")
    if not certificate.not_valid_before_utc <= datetime.now(UTC) <= certificate.not_valid_after_utc:
        end = f"{certificate.not_valid_after_utc:%Y-%m-%d}"
        raise ValueError(f"{path}: valid until {end}: delete {KEY} and {path.name} to create both again")
    return uris[0]


def _create_key_and_certificate(key: Path, certificate: Path, host: str) -> None:
    """Create a private key and its self-signed certificate."""
    from cryptography.hazmat.primitives.asymmetric import rsa
    from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

    private_key = rsa.generate_private_key(public_exponent=65537, key_size=KEY_BITS[0])
    der = _self_signed(private_key, host).public_bytes(Encoding.DER)
    try:
        key.parent.mkdir(exist_ok=True)
        _write_new(key, private_key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()), 0o600)
        _write_new(certificate, der, 0o644)
        if not (ignored := key.parent / ".gitignore").exists():
            _write_new(ignored, f"{KEY}\n".encode(), 0o644)
    except OSError as error:
        raise ValueError(f"{error.filename or key.parent}: {error.strerror}") from error


def _write_new(path: Path, content: bytes, mode: int) -> None:
    binary: int = getattr(os, "O_BINARY", 0)
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | binary, mode), "wb") as file:
        file.write(content)


def _self_signed(key: Any, host: str) -> Certificate:
    """Return a self-signed application certificate for this machine and host [OPC UA part 6, 6.2.2]."""
    from asyncua.crypto.cert_gen import generate_self_signed_app_certificate
    from cryptography.x509 import DNSName, GeneralName, IPAddress, UniformResourceIdentifier
    from cryptography.x509.oid import ExtendedKeyUsageOID

    machine = socket.gethostname() or "localhost"
    names: list[GeneralName] = [UniformResourceIdentifier(application_uri()), DNSName(machine)]
    try:
        address = ipaddress.ip_address(host)
        if not address.is_unspecified:
            names.append(IPAddress(address))
    except ValueError:  # the host is a name
        if host != machine:
            names.append(DNSName(host))
    uses = [ExtendedKeyUsageOID.SERVER_AUTH]
    return generate_self_signed_app_certificate(key, "scanrack", {}, names, uses, DAYS)
