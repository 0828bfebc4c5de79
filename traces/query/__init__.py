"""Asking a trace: in which scans something held, and how long it took. The language: docs/query.md."""

from .answer import Answer, Occurrence
from .ask import query
from .language import QueryError

__all__ = ["Answer", "Occurrence", "QueryError", "query"]
