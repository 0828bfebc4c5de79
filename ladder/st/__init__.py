"""Structured text: its grammar, and the parser to statements of the tree (`ladder.statements`)."""

from .parser import parse_statements

__all__ = ["parse_statements"]
