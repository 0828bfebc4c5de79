"""Refuses OPC UA requests without authentication, or on other clients' sessions and subscriptions.

allowed request                    open server     encrypted server
GetEndpoints, FindServers          yes             yes: needed to connect
RegisterServer                     no              no
TransferSubscriptions              no              no
a second session at a time         no              no
a session of another connection    no              no
a subscription of another session  no              no
a session for another server       no              no
a session of an application that   yes             no
the certificate does not name
everything else                    yes             in an encrypted channel, from a trusted certificate
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from importlib import import_module
from typing import Any

from ..tag_servers.ua_security import UaSecurity, application_uri, uris_of
from .opcua_library import binary, service_error, ua, utils

REFUSAL_S = 1.0
"""Delay after a refused password, s. It also delays the client's next requests."""

NONCE_LEAST = 32
"""Minimum length of a client's nonce, bytes [OPC UA part 4, 5.7.2]."""

PUBLIC = ("GetEndpointsRequest", "FindServersRequest")
REFUSED = ("RegisterServerRequest", "RegisterServer2Request", "TransferSubscriptionsRequest")

OWNED = (
    *("modify_subscription", "delete_subscriptions", "set_publishing_mode"),
    *("delete_monitored_items", "set_monitoring_mode"),
)
"""Subscription services that are checked here; `opcua_subscriptions.py` checks the others."""

NO_SUBSCRIPTION = 0
"""An identifier that no subscription has, so that asyncua answers *BadSubscriptionIdInvalid*."""


class UaGuard:
    """Guards a server's connections.

    Args:
        security: None for a server that every client may use.

    Attributes:
        uri: URI of the application, used in endpoints, in the certificate, and in the namespace and server
            arrays.
    """

    def __init__(self, security: UaSecurity | None) -> None:
        self._rules: Any = import_module("asyncua.crypto.permission_rules")
        self._security = security
        self.uri = application_uri() if security is None else security.uri
        self._public, self._refused = self._ids(PUBLIC), self._ids(REFUSED)
        (self._activates,) = self._ids(("ActivateSessionRequest",))
        (self._creates,) = self._ids(("CreateSessionRequest",))

    def _ids(self, names: tuple[str, ...]) -> set[Any]:
        """Return the identifiers by which messages name these requests."""
        return {ua.NodeId(getattr(ua.ObjectIds, f"{name}_Encoding_DefaultBinary")) for name in names}

    async def set_up(self, server: Any) -> None:
        """Configure the server's security policy and its users, before it listens."""
        inner_server, security = server.iserver, self._security
        server.allow_remote_admin(False)
        inner_server.lookup_external_session = lambda _token: None
        inner_server.register_external_session = lambda _session: None  # only asyncua's look-up would read it
        policies, token = ua.SecurityPolicyType, ua.AnonymousIdentityToken
        if security is None:
            server.set_security_policy([policies.NoSecurity])
        else:
            await server.load_certificate(security.certificate)
            await server.load_private_key(security.key, format="pem")
            server.set_security_policy([policies.Basic256Sha256_SignAndEncrypt])
            if security.users:
                token = ua.UserNameIdentityToken
                inner_server.user_manager, inner_server.decrypt_user_token = self, self._name_and_password
        server.set_identity_tokens([token])

    def get_user(
        self, _server: Any, username: str | None = None, password: str | None = None, certificate: Any = None
    ) -> Any:
        """Return the user who is logging in, or None if the password is wrong. asyncua calls this."""
        if self._security is None or not self._security.accepts(username, password):
            return None
        return self._rules.User(self._rules.UserRole.User, username)

    def _name_and_password(self, _session: Any, token: Any) -> tuple[str, str]:
        """Return a client's user name and password; only the channel may encrypt them.

        Decrypting any client's text with the server's key would leak information about other texts.
        """
        if token.EncryptionAlgorithm:
            raise service_error("BadIdentityTokenInvalid")
        return token.UserName, bytes(token.Password or b"").decode("utf-8")

    def watch(self, connection: Any) -> None:
        """Check each request of a connection; close the connection after an unreadable one.

        asyncua alone would continue, even after it has accepted part of an open-channel request.
        """
        processor, process = connection.processor, connection._process_one_msg
        processor._process_message = self._checked(processor, processor._process_message)
        # no other connection may take over the session
        processor._should_close_session_on_transport_loss = lambda: True

        async def processed(*message: Any) -> bool:
            try:
                return bool(await process(*message))
            except Exception:
                connection.transport.abort()
                return False

        connection._process_one_msg = processed

    def _checked(self, processor: Any, process: Callable[..., Awaitable[Any]]) -> Callable[..., Any]:
        """Wrap the processing of a connection's requests so that forbidden ones are refused.

        A refused user name or password is answered after `REFUSAL_S`.
        """

        async def checked(kind: Any, *rest: Any) -> Any:
            refusal = self._refusal(kind, processor)
            if refusal:
                raise service_error(refusal)
            if kind == self._creates:
                self._check_session(processor._connection.security_policy, rest[-1].copy())
                watchdog = processor._session_watchdog_task
                if watchdog is not None:
                    watchdog.cancel()  # the watchdog of the earlier, closed session would keep running
            try:
                return await process(kind, *rest)
            except utils.ServiceError as error:
                if kind == self._activates and error.code == ua.StatusCodes.BadUserAccessDenied:
                    await asyncio.sleep(REFUSAL_S)
                raise

        return checked

    def _check_session(self, policy: Any, body: Any) -> None:
        """Refuse a wrong server, an application not named in its certificate, or a short nonce."""
        params = binary.struct_from_binary(ua.CreateSessionParameters, body)
        if params.ServerUri not in (None, "", self.uri):
            raise service_error("BadServerUriInvalid")
        if self._security is None:
            return
        if params.ClientDescription.ApplicationUri not in uris_of(policy.peer_certificate):
            raise service_error("BadCertificateUriInvalid")
        if len(params.ClientNonce or b"") < NONCE_LEAST:
            raise service_error("BadNonceInvalid")

    def _refusal(self, kind: Any, processor: Any) -> str:
        """Return the name of the status that refuses a request, or "" if the request is allowed."""
        security, policy, session = self._security, processor._connection.security_policy, processor.session
        if kind in self._refused:
            return "BadServiceUnsupported"
        if security is not None and kind not in self._public:
            if policy.Mode != ua.MessageSecurityMode.SignAndEncrypt:
                return "BadSecurityModeInsufficient"
            if security.trusted is not None and policy.peer_certificate not in security.trusted:
                return "BadCertificateUntrusted"
        is_open = session is not None and session.state.name != "Closed"
        return "BadTooManySessions" if is_open and kind == self._creates else ""


def keep_apart(session: Any, subscriptions: Mapping[int, Any]) -> None:
    """Restrict a session to its own subscriptions, and delete them when it ends.

    Args:
        session: asyncua's session.
        subscriptions: all sessions' subscriptions, by identifier.
    """

    def without_foreign(params: Any) -> Any:
        """Return a request, or its identifiers, with `NO_SUBSCRIPTION` for each foreign subscription."""
        if isinstance(params, int):
            subscription = subscriptions.get(params)
            is_own = subscription is not None and subscription.session_id == session.session_id
            return params if is_own else NO_SUBSCRIPTION
        if isinstance(params, list):
            return list(map(without_foreign, params))
        for name in ("SubscriptionId", "SubscriptionIds"):
            if hasattr(params, name):
                setattr(params, name, without_foreign(getattr(params, name)))
        return params

    def restricted(service: Callable[..., Any]) -> Callable[..., Any]:
        return lambda params=None: service(without_foreign(params))

    for name in OWNED:
        setattr(session, name, restricted(getattr(session, name)))
    close_session = session.close_session
    session.close_session = lambda _delete_subscriptions=True: close_session(True)
