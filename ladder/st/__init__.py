"""Structured text: its grammar, and a parser that returns statements of the tree (`ladder.statements`)."""

from .parser import parse_statements

__all__ = ["parse_statements"]
