"""Queries on a trace: the scans in which a condition held, and its duration. The language: docs/query.md."""

from .answer import Answer, Occurrence
from .ask import query
from .language import QueryError

__all__ = ["Answer", "Occurrence", "QueryError", "query"]
