"""Queries on a trace: the scans in which a condition was true, and for how long. See docs/query.md."""

from .answer import Answer, Occurrence
from .ask import query
from .language import QueryError

__all__ = ["Answer", "Occurrence", "QueryError", "query"]
