"""The language server over pygls: documents come in, diagnostics and responses go out."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Iterable, Sequence
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

from lsprotocol import types
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path
from scanrack.io_images.versions import distribution_version
from scanrack.jobs.check.texts import CHECKED, RACK, LineRemark
from scanrack.ladder.files.suffixes import STRUCTURED_SUFFIX, SUFFIX

from . import racks, rungs
from .findings import findings

REST_S = 0.2
"""Time without typing before a text is checked, s."""

LEVELS = {
    "error": types.DiagnosticSeverity.Error,
    "warning": types.DiagnosticSeverity.Warning,
    "note": types.DiagnosticSeverity.Information,
}
KINDS = {
    "instruction": types.CompletionItemKind.Function,
    "tag": types.CompletionItemKind.Variable,
    "member": types.CompletionItemKind.Field,
    "routine": types.CompletionItemKind.Module,
    "key": types.CompletionItemKind.Property,
    "value": types.CompletionItemKind.Value,
}


class RackServer(LanguageServer):
    """The server, with its published findings for each document.

    Attributes:
        trusted: whether the editor trusts its folder, so that Python modules may be run.
    """

    def __init__(self) -> None:
        super().__init__("scanrack", distribution_version("scanrack"))
        self.trusted = False
        self._pending: dict[str, asyncio.Task[None]] = {}  # scheduled checks, by document
        self._other_files: dict[
            str, set[str]
        ] = {}  # other files with findings of the last check, by document

    def schedule_check(self, uri: str, *, rest_s: float = REST_S) -> None:
        """Schedule a check of a document after `rest_s` seconds; it replaces a pending check."""
        self._cancel(uri)
        if _path(uri).suffix in CHECKED:
            self._pending[uri] = asyncio.get_running_loop().create_task(self._check(uri, rest_s))

    def forget(self, uri: str) -> None:
        """Clear the findings of a closed document."""
        self._cancel(uri)
        for file in {uri, *self._other_files.pop(uri, set())}:
            self._publish(file, [])

    def _cancel(self, uri: str) -> None:
        check = self._pending.pop(uri, None)
        if check is not None:
            check.cancel()

    async def _check(self, uri: str, rest_s: float) -> None:
        """Wait, check a document together with all open texts, and publish the findings.

        The findings of its previous check in other files are cleared.
        """
        await asyncio.sleep(rest_s)
        document = self.workspace.get_text_document(uri)
        documents = self.workspace.text_documents
        texts = {_path(opened): text_document.source for opened, text_document in documents.items()}
        version = document.version
        remarks = await asyncio.to_thread(findings, _path(uri), texts, trusted=self.trusted)
        by_file: dict[str, list[LineRemark]] = {uri: []}
        for remark in remarks:
            by_file.setdefault(from_fs_path(remark.file) or uri, []).append(remark)
        self._publish(uri, by_file.pop(uri), version)
        for file in self._other_files.get(uri, set()) - by_file.keys():
            self._publish(file, [])
        self._other_files[uri] = set(by_file)
        for file in by_file.keys() - self.workspace.text_documents.keys():  # open documents have checks
            self._publish(file, by_file[file])

    def _publish(self, uri: str, remarks: Iterable[LineRemark], version: int | None = None) -> None:
        lines: Sequence[str] = self.workspace.get_text_document(uri).lines if remarks else ()
        diagnostics = [_diagnostic(remark, lines) for remark in remarks]
        self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, diagnostics, version))


def _path(uri: str) -> Path:
    return Path(to_fs_path(uri) or "")


def _diagnostic(remark: LineRemark, lines: Sequence[str]) -> types.Diagnostic:
    """Return a remark as a protocol object with a range to the end of its line."""
    line_number = min(remark.line, max(len(lines), 1)) - 1
    line = lines[line_number].rstrip() if line_number < len(lines) else ""
    start = len(line) - len(line.lstrip()) if remark.column is None else min(remark.column - 1, len(line))
    span = types.Range(
        types.Position(line_number, _units(line[:start])), types.Position(line_number, _units(line))
    )
    level = LEVELS[remark.level]
    return types.Diagnostic(span, remark.text, severity=level, source="scanrack", code=remark.rule)


def _units(text: str) -> int:
    """Return the length of a text in UTF-16 code units, the unit of the protocol."""
    return len(text.encode("utf-16-le")) // 2


def _column(line: str, units: int) -> int:
    """Return the index in a line for a number of UTF-16 code units."""
    return len(line.encode("utf-16-le")[: 2 * units].decode("utf-16-le", "ignore"))


def _position(server: RackServer, params: Any) -> tuple[Path, str, str, int, int]:
    """Return the file of a request, its text, the line, and the position: line and column from 0."""
    document = server.workspace.get_text_document(params.text_document.uri)
    line_number = params.position.line
    line = document.lines[line_number].rstrip("\r\n") if line_number < len(document.lines) else ""
    return _path(document.uri), document.source, line, line_number, _column(line, params.position.character)


def _hover(server: RackServer, params: types.HoverParams) -> types.Hover | None:
    """Return the description of the key or word at a position; None if there is none."""
    path, text, line, line_number, column = _position(server, params)
    meaning = ""
    if path.suffix == RACK:
        meaning = racks.meaning(text, line_number, column)
    elif path.suffix in (SUFFIX, STRUCTURED_SUFFIX):
        meaning = rungs.meaning(text, line, column)
    return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, meaning)) if meaning else None


def _complete(server: RackServer, params: types.CompletionParams) -> types.CompletionList:
    """Return the keys, values, instructions and names that are allowed at a position."""
    path, text, line, line_number, column = _position(server, params)
    offers: list[rungs.Offer] = []
    if path.suffix == RACK:
        offers = racks.offers(text, line_number, column)
    elif path.suffix in (SUFFIX, STRUCTURED_SUFFIX):
        offers = rungs.offers(text, line[:column], structured=path.suffix == STRUCTURED_SUFFIX)
    items = [
        types.CompletionItem(
            offer.name,
            kind=KINDS[offer.kind],
            detail=offer.detail or None,
            documentation=types.MarkupContent(types.MarkupKind.Markdown, offer.text) if offer.text else None,
        )
        for offer in offers
    ]
    return types.CompletionList(is_incomplete=False, items=items)


def _define(server: RackServer, params: types.DefinitionParams) -> types.Location | None:
    """Return the place in the same text that declares the word at a position; None if there is none."""
    path, text, line, _, column = _position(server, params)
    word = rungs.word_at(line, column) if path.suffix in (SUFFIX, STRUCTURED_SUFFIX) else ""
    declaration = rungs.declared_at(text, word) if word else None
    if declaration is None:
        return None
    line = text.splitlines()[declaration.line]
    start = _units(line[: line.index(declaration.name)])
    end = start + _units(declaration.name)
    span = types.Range(types.Position(declaration.line, start), types.Position(declaration.line, end))
    return types.Location(params.text_document.uri, span)


def make_server() -> RackServer:
    """Return the server with its handlers."""
    server = RackServer()

    def begin(params: types.InitializeParams) -> None:
        options = params.initialization_options
        server.trusted = isinstance(options, dict) and options.get("trusted") is True

    def opened(params: types.DidOpenTextDocumentParams) -> None:
        server.schedule_check(params.text_document.uri, rest_s=0)

    def changed(params: types.DidChangeTextDocumentParams) -> None:
        server.schedule_check(params.text_document.uri)

    def saved(_params: types.DidSaveTextDocumentParams) -> None:
        for uri in list(server.workspace.text_documents):  # a rack file is checked with its program
            server.schedule_check(uri, rest_s=0)

    def closed(params: types.DidCloseTextDocumentParams) -> None:
        server.forget(params.text_document.uri)

    server.feature(types.INITIALIZE)(begin)
    server.feature(types.TEXT_DOCUMENT_DID_OPEN)(opened)
    server.feature(types.TEXT_DOCUMENT_DID_CHANGE)(changed)
    server.feature(types.TEXT_DOCUMENT_DID_SAVE)(saved)
    server.feature(types.TEXT_DOCUMENT_DID_CLOSE)(closed)
    server.feature(types.TEXT_DOCUMENT_HOVER)(lambda params: _hover(server, params))
    server.feature(types.TEXT_DOCUMENT_DEFINITION)(lambda params: _define(server, params))
    triggers = types.CompletionOptions(trigger_characters=["(", ",", ".", '"'])
    server.feature(types.TEXT_DOCUMENT_COMPLETION, triggers)(lambda params: _complete(server, params))
    return server


def serve() -> None:
    """Serve on standard input and output until the editor ends it; other output goes to standard error."""
    stdin_fd, stdout_fd = os.dup(0), os.dup(1)
    with (
        os.fdopen(stdin_fd, "rb") as requests,
        os.fdopen(stdout_fd, "wb") as responses,
        redirect_stdout(sys.stderr),
    ):
        make_server().start_io(requests, responses)
