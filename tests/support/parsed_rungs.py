"""Rungs from text: the parser's place stands here once for the tests of imports and edits."""

from scanrack.ladder.lowering.text import parse_rung

__all__ = ["parse_rung"]
