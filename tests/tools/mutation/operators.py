"""Which mutants a Python source has: small edits of its text, found in its syntax tree.

    condition       if a:            if not (a):
    operand         a and b          a, b
    connective      a and b          a or b
    comparison      a < b            a <= b           == !=, is is not, in not in
    not             not a            a
    statement       f(x)             pass             calls, changes of attributes, a |= b
    status bit      COMMAND_ERROR    0
    truth           True             False
    number          1                2
    sign            a + b, -a        a - b, a
    row             a row of a table of refusals is taken out
    order           two neighboring rows of a table of refusals change places

Docstrings, annotations, messages, imports, asserts (they are for the type checker) and TYPE_CHECKING blocks
have none.
"""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import unified_diff
from itertools import pairwise

from scanrack.io_images.amci3601 import StatusLsw, StatusMsw

STATUS_BITS = frozenset(
    [str(bit.name) for word in (StatusMsw, StatusLsw) for bit in word]
    + ["RESETTABLE", "CLEARED_BY_A_MOVE", "COMPLETION"]
)
COMPARISONS: dict[type[ast.cmpop], tuple[str, str]] = {
    ast.Lt: ("<", "<="),
    ast.LtE: ("<=", "<"),
    ast.Gt: (">", ">="),
    ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.Is: ("is", "is not"),
    ast.IsNot: ("is not", "is"),
    ast.In: ("in", "not in"),
    ast.NotIn: ("not in", "in"),
}
NEGATED_BY_SWAP = (ast.Eq, ast.NotEq, ast.Is, ast.IsNot, ast.In, ast.NotIn)
LOOSE = (ast.BoolOp, ast.IfExp, ast.Lambda, ast.Compare, ast.NamedExpr)


@dataclass(frozen=True, slots=True)
class Mutant:
    """One edit of one file.

    Attributes:
        path: the file, from the project's root.
        scope: function or table in which it is, dotted; "" at module level.
        first_line: where the statement begins.
        line: where the edit begins.
        last_line: where what is edited ends.
        kind: the operator.
        start: first byte that is replaced.
        end: the byte after the last.
        old: the text there.
        new: the text in its place.
        rules: if not empty, the edit shows only where one of these rules fires.
    """

    path: str
    scope: str
    first_line: int
    line: int
    last_line: int
    kind: str
    start: int
    end: int
    old: str
    new: str
    rules: tuple[str, ...] = ()

    def apply(self, source: str) -> str:
        """Return the source with the edit made."""
        data = source.encode()
        return (data[: self.start] + self.new.encode() + data[self.end :]).decode()

    def diff(self, source: str) -> str:
        """Return the edit as a diff without heads."""
        lines = unified_diff(source.splitlines(), self.apply(source).splitlines(), lineterm="", n=0)
        return "\n".join(line for line in lines if not line.startswith(("---", "+++", "@@")))

    def __str__(self) -> str:
        return f"{self.path}:{self.line} {self.scope}: {self.kind}"


class Editor:
    """Makes mutants of one source.

    Args:
        path: the file, from the project's root.
        source: its text.
    """

    def __init__(self, path: str, source: str) -> None:
        self.path = path
        self.data = source.encode()
        self._line_starts = [0]
        for line in self.data.splitlines(keepends=True):
            self._line_starts.append(self._line_starts[-1] + len(line))

    def span(self, node: ast.expr | ast.stmt) -> tuple[int, int]:
        """Return first byte and the byte after the last."""
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return (
            self._line_starts[node.lineno - 1] + node.col_offset,
            self._line_starts[node.end_lineno - 1] + node.end_col_offset,
        )

    def text(self, node: ast.expr | ast.stmt) -> str:
        """Return the source of a node."""
        start, end = self.span(node)
        return self.data[start:end].decode()

    def line_of(self, position: int) -> int:
        """Return the number of the line of a byte."""
        return sum(1 for start in self._line_starts if start <= position)

    def edit(
        self,
        kind: str,
        span: tuple[int, int],
        new: str,
        *,
        scope: str = "",
        first_line: int | None = None,
        rules: tuple[str, ...] = (),
    ) -> Mutant:
        """Return the mutant that has `new` in place of a span."""
        line = self.line_of(span[0])
        return Mutant(
            self.path,
            scope,
            line if first_line is None else first_line,
            line,
            self.line_of(span[1] - 1),
            kind,
            *span,
            self.data[slice(*span)].decode(),
            new,
            rules,
        )


def mutants_of(path: str, source: str) -> list[Mutant]:
    """Return all mutants of a source, in its order, each once."""
    finder = _Finder(Editor(path, source))
    finder.visit(ast.parse(source))
    unique = {(mutant.start, mutant.end, mutant.new): mutant for mutant in reversed(finder.found)}
    return sorted(unique.values(), key=lambda mutant: (mutant.start, mutant.end, mutant.new))


class _Finder(ast.NodeVisitor):
    def __init__(self, editor: Editor) -> None:
        self.editor = editor
        self.found: list[Mutant] = []
        self._scope: list[str] = []
        self._tables: dict[str, tuple[str, ...]] = {}
        self._first_line = 1
        self._returns_bool = False

    def _add(self, kind: str, node: ast.expr | ast.stmt, new: str) -> None:
        self._add_span(kind, self.editor.span(node), new)

    def _add_span(self, kind: str, span: tuple[int, int], new: str, rules: tuple[str, ...] = ()) -> None:
        scope = ".".join(self._scope)
        self.found.append(
            self.editor.edit(kind, span, new, scope=scope, first_line=self._first_line, rules=rules)
        )

    def _text(self, node: ast.expr) -> str:
        """Source of an operand: in brackets where it would fall apart without them."""
        text = self.editor.text(node)
        return f"({text})" if isinstance(node, LOOSE) else text

    def visit(self, node: ast.AST) -> None:
        if isinstance(node, ast.stmt):
            self._first_line = node.lineno
        super().visit(node)

    # -- what has none

    def visit_Import(self, node: ast.Import) -> None: ...

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None: ...

    def visit_Assert(self, node: ast.Assert) -> None: ...

    def visit_Raise(self, node: ast.Raise) -> None: ...

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None: ...

    # -- scopes

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        outer = self._returns_bool
        self._returns_bool = isinstance(node.returns, ast.Name) and node.returns.id == "bool"
        self._inside(node.name, node.body)
        self._returns_bool = outer

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        self._inside(node.name, node.body)

    def _inside(self, name: str, body: Sequence[ast.stmt]) -> None:
        self._scope.append(name)
        for statement in body:
            self.visit(statement)
        self._scope.pop()

    # -- statements

    def visit_Expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Call):
            self._add("statement", node, "pass")
            self.visit(node.value)

    def visit_Assign(self, node: ast.Assign) -> None:
        attribute = any(isinstance(target, ast.Attribute) for target in node.targets)
        if attribute and self._scope[-1] != "__init__":
            self._add("statement", node, "pass")
        if isinstance(node.targets[0], ast.Name):
            self._tables[node.targets[0].id] = self._rules_of(node.value)
        self.visit(node.value)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        self._add("statement", node, "pass")
        self.visit(node.value)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is None:
            return
        if isinstance(node.annotation, ast.Name) and node.annotation.id == "Refusals":
            assert isinstance(node.target, ast.Name)
            assert isinstance(node.value, ast.Tuple)
            self._scope.append(node.target.id)
            self._rows(node.target.id, node.value)
            self.visit(node.value)
            self._scope.pop()
        else:
            self.visit(node.value)

    def _rows(self, name: str, table: ast.Tuple) -> None:
        """A row decides only where its rule fires: nothing changes without it if it is not broken."""
        spans = [self.editor.span(row) for row in table.elts]
        rules = [self._rules_of(row) for row in table.elts]
        self._tables[name] = tuple(rule for row in rules for rule in row)
        if len(spans) == 1:
            self._add_span("row", self.editor.span(table), "()", rules[0])
            return
        left_over = [f"({self.editor.text(row)},)" for row in reversed(table.elts)]  # of a table of two
        for index, ((start, end), (after, last)) in enumerate(pairwise(spans)):
            if len(spans) == 2:
                self._add_span("row", self.editor.span(table), left_over[0], rules[0])
            else:
                self._add_span("row", (start, after), "", rules[index])
            first, between, second = (
                self.editor.data[slice(*part)].decode()
                for part in ((start, end), (end, after), (after, last))
            )
            self._add_span(
                "order", (start, last), f"{second}{between}{first}", rules[index] + rules[index + 1]
            )
        if len(spans) == 2:
            self._add_span("row", self.editor.span(table), left_over[1], rules[1])
        else:
            self._add_span("row", (spans[-2][1], spans[-1][1]), "", rules[-1])

    def _rules_of(self, row: ast.expr) -> tuple[str, ...]:
        """Return the rules of a row, or of the table that is inserted here; nothing if that is unknown."""
        if isinstance(row, ast.Starred):
            return self._rules_of(row.value)
        if isinstance(row, ast.Name):
            return self._tables.get(row.id, ())
        first = row.args[0] if isinstance(row, ast.Call) and row.args else None
        return (str(first.value),) if isinstance(first, ast.Constant) else ()

    def visit_Return(self, node: ast.Return) -> None:
        if node.value is not None:
            if self._returns_bool and not isinstance(node.value, ast.Constant):
                self._condition(node.value)
            self.visit(node.value)

    def visit_If(self, node: ast.If) -> None:
        if isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            return
        self._condition(node.test)
        self.generic_visit(node)

    def visit_While(self, node: ast.While) -> None:
        self._condition(node.test)
        self.generic_visit(node)

    # -- expressions

    def visit_IfExp(self, node: ast.IfExp) -> None:
        self._condition(node.test)
        self.generic_visit(node)

    def visit_comprehension(self, node: ast.comprehension) -> None:
        for test in node.ifs:
            self._condition(test)
        self.generic_visit(node)

    def _condition(self, test: ast.expr) -> None:
        """Negate it, unless another operator has the same effect."""
        swapped = isinstance(test, ast.Compare) and isinstance(test.ops[0], NEGATED_BY_SWAP)
        negated = isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not)
        if not (swapped or negated):
            self._add("condition", test, f"not ({self.editor.text(test)})")

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        word, other = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
        texts = [self._text(value) for value in node.values]
        self._add("connective", node, f"({f' {other} '.join(texts)})")
        for dropped in range(len(texts)):
            rest = texts[:dropped] + texts[dropped + 1 :]
            self._add("operand", node, f"({f' {word} '.join(rest)})" if len(rest) > 1 else rest[0])
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        for swapped in range(len(node.ops)):
            text = self._text(node.left)
            for index, (op, right) in enumerate(zip(node.ops, node.comparators, strict=True)):
                text += f" {COMPARISONS[type(op)][index == swapped]} {self._text(right)}"
            self._add("comparison", node, text)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if isinstance(node.op, ast.Not):
            self._add("not", node, self._text(node.operand))
        elif isinstance(node.op, ast.USub):
            self._add("sign", node, self._text(node.operand))
            if isinstance(node.operand, ast.Constant):
                return  # a number of its own
        self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if isinstance(node.op, ast.Add | ast.Sub):
            sign = "-" if isinstance(node.op, ast.Add) else "+"
            end = self.editor.span(node.left)[1]
            start = self.editor.span(node.right)[0]
            between = self.editor.data[end:start].decode()
            self._add_span("sign", (end, start), between.translate({ord("+"): sign, ord("-"): sign}))
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        if isinstance(node.value, bool):
            self._add("truth", node, str(not node.value))
        elif isinstance(node.value, int):
            self._add("number", node, str(node.value + 1))

    def visit_Name(self, node: ast.Name) -> None:
        if node.id in STATUS_BITS and isinstance(node.ctx, ast.Load):
            self._add("status bit", node, "0")
