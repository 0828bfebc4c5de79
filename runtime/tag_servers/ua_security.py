"""Security settings of an OPC UA server: certificate, users and trusted clients."""

from __future__ import annotations

import hmac
import socket
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256

USERS_MOST, PASSWORD_MOST = 64, 128
"""Maximum number of users of a server, and of bytes in a name or a password."""


def application_uri() -> str:
    """Return the URI of scanrack on this machine, for open servers and new certificates."""
    return f"urn:{socket.gethostname() or 'localhost'}:scanrack"


def uris_of(certificate: bytes) -> list[str]:
    """Return the application URIs in a DER certificate, or an empty list if it is unreadable."""
    from cryptography.x509 import (
        ExtensionNotFound,
        SubjectAlternativeName,
        UniformResourceIdentifier,
        load_der_x509_certificate,
    )

    try:
        extensions = load_der_x509_certificate(certificate).extensions
        names = extensions.get_extension_for_class(SubjectAlternativeName).value
    except (ValueError, ExtensionNotFound):
        return []
    return list(names.get_values_for_type(UniformResourceIdentifier))


@dataclass(frozen=True, slots=True)
class UaSecurity:
    """The settings of an encrypted server; its process gets only SHA-256 digests of passwords.

    Attributes:
        certificate: certificate of the server, in DER.
        uri: application URI in the certificate.
        key: private key, in PEM.
        users: SHA-256 of passwords, by user; without users, clients are anonymous.
        trusted: certificates of trusted clients, in DER; None trusts any client.
    """

    certificate: bytes
    uri: str
    key: bytes = field(repr=False)
    users: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    trusted: frozenset[bytes] | None = field(default=None, repr=False)

    def accepts(self, user: str | None, password: str | None) -> bool:
        """Return whether a user may log in with a password; for an unknown user, the check takes as long.

        >>> security = UaSecurity(b"", "", b"", users_of("ann:secret:1"))
        >>> security.accepts("ann", "secret:1"), security.accepts("ann", "")
        (True, False)
        >>> security.accepts("bob", "secret:1")
        False
        """
        expected_digest = self.users.get(user or "")
        digest = sha256((password or "").encode("utf-8", "surrogatepass")).digest()
        return hmac.compare_digest(digest, expected_digest or bytes(32)) and expected_digest is not None


def users_of(text: str) -> dict[str, bytes]:
    """Return the users in a file with lines `name:password`; empty lines and `#` lines are skipped.

    Raises:
        ValueError: a line has a different form, a user appears twice, or the file does not name any users.
    """
    users: dict[str, bytes] = {}
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        name, password = _user_in(line, number)
        if name in users:
            raise ValueError(f"line {number}: {name!r} appears above; list each user once")
        users[name] = sha256(password.encode()).digest()
    if not 0 < len(users) <= USERS_MOST:
        raise ValueError(f"it must name 1 to {USERS_MOST} users, each as name:password")
    return users


def _user_in(line: str, number: int) -> tuple[str, str]:
    """Return the name and password in a line; raise ValueError, with the line number, for any other line."""
    name, _, password = line.partition(":")
    if not (name and password):
        raise ValueError(f"line {number}: must be name:password")
    if not name.isprintable():
        raise ValueError(f"line {number}: {name!r} has characters that can't be printed")
    if max(len(name.encode()), len(password.encode())) > PASSWORD_MOST:
        raise ValueError(f"line {number}: a name and a password have at most {PASSWORD_MOST} bytes")
    return name, password
