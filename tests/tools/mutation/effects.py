"""Mutants of the rule table: a row that the command layer fires loses a bit, or one that fires with it.

Which rows it fires, and whether with the row's own bits and partners, is read off the layer's sources:
`fire(now_ns, "CMD-03")` and `Refusal("CMD-03", busy)` use both, `bits=` replaces the bits and `alone=True`
leaves the partners out; an id anywhere else (in a list of faults, say) is taken to use both.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from scanrack.io_images.amci3601 import bit_names
from scanrack.io_images.amci3601.rules import Rule

from .operators import Editor, Mutant

WORD_0 = 0xFFFF
"""The layer takes over a rule's bits of status word 0."""


@dataclass(slots=True)
class Fired:
    """Ids of rules that are fired with their own bits, and with their partners."""

    own_bits: set[str] = field(default_factory=set)
    partners: set[str] = field(default_factory=set)


def fired(sources: Iterable[str], rules: Mapping[str, Rule]) -> Fired:
    """Return which effects of the rule table the sources use."""
    found = Fired()
    for source in sources:
        tree = ast.parse(source)
        spoken_for: set[ast.AST] = set()
        for call in ast.walk(tree):
            if isinstance(call, ast.Call):
                keywords = {keyword.arg: keyword.value for keyword in call.keywords}
                for argument in call.args:
                    if _is_id(argument, rules):
                        spoken_for.add(argument)
                        _note(found, argument, bits="bits" in keywords, alone="alone" in keywords)
            elif isinstance(call, ast.Tuple) and len(call.elts) == 2 and _is_id(call.elts[0], rules):
                spoken_for.add(call.elts[0])
                own = isinstance(call.elts[1], ast.Constant) and call.elts[1].value is None
                _note(found, call.elts[0], bits=not own, alone=False)
        for node in ast.walk(tree):
            if node not in spoken_for and _is_id(node, rules):
                _note(found, node, bits=False, alone=False)
    found.own_bits |= {other for rule_id in found.partners for other in rules[rule_id].together_with}
    return found


def _is_id(node: ast.AST, rules: Mapping[str, Rule]) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in rules


def _note(found: Fired, node: ast.AST, *, bits: bool, alone: bool) -> None:
    assert isinstance(node, ast.Constant)
    assert isinstance(node.value, str)
    if not bits:
        found.own_bits.add(node.value)
        if not alone:
            found.partners.add(node.value)


def effects_of(path: str, source: str, rules: Mapping[str, Rule], used: Fired) -> list[Mutant]:
    """Return the mutants of the rows in one file of the rule table."""
    editor = Editor(path, source)
    mutants = []
    for call in ast.walk(ast.parse(source)):
        if isinstance(call, ast.Call) and call.args and _is_id(call.args[0], rules):
            assert isinstance(call.args[0], ast.Constant)
            rule = rules[str(call.args[0].value)]
            keywords = {keyword.arg: keyword.value for keyword in call.keywords}
            if rule.id in used.own_bits and len(call.args) > 3:
                mutants += _bits_of(editor, call.args[3], rule, rules)
            if rule.id in used.partners and "together_with" in keywords:
                mutants += _partners_of(editor, keywords["together_with"], rule)
    return mutants


def _bits_of(editor: Editor, node: ast.expr, rule: Rule, rules: Mapping[str, Rule]) -> list[Mutant]:
    masks = [1 << place for place in range(16) if rule.sets & WORD_0 & 1 << place]
    return [
        editor.edit(
            f"effect {bit_names(mask)[0]}",
            editor.span(node),
            f"({editor.text(node)}) & ~{mask:#06x}",
            scope=rule.id,
            rules=tuple(row.id for row in rules.values() if rule.id in (row.id, *row.together_with)),
        )
        for mask in masks
    ]


def _partners_of(editor: Editor, node: ast.expr, rule: Rule) -> list[Mutant]:
    return [
        editor.edit(
            f"partner {dropped}",
            editor.span(node),
            repr(tuple(other for other in rule.together_with if other != dropped)),
            scope=rule.id,
            rules=(rule.id,),
        )
        for dropped in rule.together_with
    ]
