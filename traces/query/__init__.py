"""Queries that find when a condition was true in a trace, and for how long. See docs/query.md."""

from .answer import Answer, Occurrence
from .ask import query
from .language import QueryError

__all__ = ["Answer", "Occurrence", "QueryError", "query"]
