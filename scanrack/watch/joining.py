"""One script from all modules of the page, without comments and with numbered names.

    dom.js     export const at = …            const at$1 = …;
    notice.js  import { at } from "./dom.js"
               at("notice").hidden = true     at$1("notice").hidden = true
    page.js                                   export { at$1, … }
    /dom.js    for scripts of tests           export { at$1 as at } from "./page.js";

A module's name gets the module's number everywhere in the module, even where a local variable has the same
name. Names of properties do not change.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple

PAGE = "page.js"
"""Name of the joined script."""

MAIN = "main.js"

_IMPORT = re.compile(
    r'^import (?:(?P<names>\{[^}]*\}|\* as \w+) from )?"\./(?P<file>[\w.]+)";\n', re.MULTILINE
)
_REEXPORT = re.compile(r'^export \{(?P<names>[^}]*)\} from "\./(?P<file>[\w.]+)";\n', re.MULTILINE)
_DECLARED = re.compile(
    r"^(?P<export>export )?(?:(?:const|let) (?P<all>)|(?:async )?function\*? (?P<function>[\w$]+)"
    r"|class (?P<class>[\w$]+))",
    re.MULTILINE,
)
_NAME = re.compile(r"[A-Za-z_$][\w$]*")
_OPAQUE = re.compile(
    r"""//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*+"|'(?:\\.|[^'\\\n])*+'|[`{}]"""
    r"|(?<=[(,=:!&|?{};\[\n])\s*/(?![*/])(?:\\.|\[(?:\\.|[^\]\\\n])*+\]|[^/\\\n\[])++/[a-z]*",
    re.DOTALL,
)
"""A comment, a text, a regular expression, or a character that begins or ends part of a template."""
_MARGIN = re.compile(r"([,(\[])?\n\s*")
"""A line break and the indentation after it, with the bracket or comma before it."""
_TEXT = re.compile(r"(?:\\.|[^`\\$]|\$(?!\{))*+(?:`|\$\{)", re.DOTALL)
"""Text of a template up to its end or its next value."""
_BLOCK_BEFORE = re.compile(r"(?:[);{}>]|\b(?:else|try|catch|finally|do)|^)\s*$")
"""Code that can precede the brace of a block."""
_CLASS_BEFORE = re.compile(r"\bclass [\w$]+(?: extends [\w$.]+)?\s*$")
"""Code that precedes the brace of a class."""
_KEY_BEFORE = re.compile(r"[{,;}]\s*(?:(?:get|set|static|async) )*+$")
"""Code that can precede an object key or a class member."""


class PageScript(NamedTuple):
    """The joined script."""

    script: str
    facades: Mapping[str, str]  # by module name: a module that re-exports its names from the script


class _Source(NamedTuple):
    """The origin of an imported name."""

    file: str
    name: str  # the name in the file; "*" = the whole module


class _Module(NamedTuple):
    code: str  # code without imports, with placeholders for parts that can't contain names
    texts: list[str]  # these parts
    imports: dict[str, _Source]  # by the name in this module
    files: list[str]  # imported files, in the order of the imports
    names: dict[str, bool]  # names declared at top level -> whether they are exported
    reexports: dict[str, _Source]  # by exported name


def joined(modules: Mapping[str, str]) -> PageScript:
    """Join modules, given as texts by name, in the order in which `main.js` runs them.

    Raises:
        ValueError: a module imports a name that the other module does not export.
    """
    parsed = {name: _read(text) for name, text in modules.items()}
    order = list(dict.fromkeys(_order(parsed, MAIN, set())))
    numbers = {name: number for number, name in enumerate(order)}
    codes, facades, exported = [], {}, []
    for name in order:
        module = parsed[name]
        own_names = {symbol: f"{symbol}${numbers[name]}" for symbol in module.names}
        code = _renamed(module.code, *_finals(parsed, numbers, name, own_names))
        codes.append(_restored(_MARGIN.sub(_join_line, code), module.texts))
        exports = _exports(parsed, numbers, name)
        exported += [own_names[symbol] for symbol, is_exported in module.names.items() if is_exported]
        listed = ", ".join(f"{final} as {symbol}" for symbol, final in exports.items())
        facades[name] = f'export {{ {listed} }} from "./{PAGE}";\n'
    return PageScript(f"{''.join(codes)}export {{ {', '.join(exported)} }};\n", facades)


def _finals(
    modules: Mapping[str, _Module], numbers: Mapping[str, int], name: str, own_names: Mapping[str, str]
) -> tuple[dict[str, str], dict[str, dict[str, str]]]:
    """Return the final names in a module, and the final names of each module that it imports as a whole."""
    names, spaces = dict(own_names), {}
    for symbol, source in modules[name].imports.items():
        if source.name == "*":
            spaces[symbol] = _exports(modules, numbers, source.file)
        else:
            names[symbol] = _final(modules, numbers, name, source)
    return names, spaces


def _order(modules: Mapping[str, _Module], name: str, visited: set[str]) -> Iterator[str]:
    """Yield the modules in the order in which a browser runs them [ECMA-262, section 16.2.1.6]."""
    if name in visited:
        return
    visited.add(name)
    for file in modules[name].files:
        yield from _order(modules, file, visited)
    yield name


def _exports(modules: Mapping[str, _Module], numbers: Mapping[str, int], file: str) -> dict[str, str]:
    """Return the names that a module exports, with their names in the joined script."""
    names = modules[file].names.items()
    exports = {symbol: f"{symbol}${numbers[file]}" for symbol, is_exported in names if is_exported}
    for symbol, source in modules[file].reexports.items():
        exports[symbol] = _final(modules, numbers, file, source)
    return exports


def _final(modules: Mapping[str, _Module], numbers: Mapping[str, int], importer: str, source: _Source) -> str:
    """Return the joined script's name for an imported name; raise ValueError if it is not exported."""
    final = _exports(modules, numbers, source.file).get(source.name)
    if final is None:
        raise ValueError(f"{importer} imports {source.name!r} of {source.file}, which does not export it")
    return final


# --- one module


def _read(text: str) -> _Module:
    """Split a module into its imports, re-exports, declared names and code."""
    imports: dict[str, _Source] = {}
    reexports: dict[str, _Source] = {}
    files = []
    for match in _IMPORT.finditer(text):
        files.append(match["file"])
        names = (match["names"] or "").strip()
        if names.startswith("*"):
            imports[names.split()[-1]] = _Source(match["file"], "*")
        elif names:
            imports |= _listed(names.strip("{}"), match["file"])
    for match in _REEXPORT.finditer(text):
        files.append(match["file"])
        reexports |= _listed(match["names"], match["file"])
    code, texts = _cut_out(_REEXPORT.sub("", _IMPORT.sub("", text)))
    return _Module(
        code=re.sub(r"^export ", "", code, flags=re.MULTILINE),
        texts=texts,
        imports=imports,
        files=files,
        names=dict(_declared(code)),
        reexports=reexports,
    )


def _listed(names: str, file: str) -> dict[str, _Source]:
    """Return the sources of the names in a list such as `a, b as c`, by their new names."""
    sources = {}
    for entry in filter(None, map(str.strip, names.split(","))):
        old, _, new = entry.partition(" as ")
        sources[new or old] = _Source(file, old)
    return sources


def _cut_out(text: str) -> tuple[str, list[str]]:
    """Return code without comments, with placeholders for texts and patterns, and the cut-out parts."""
    pieces: list[str] = []
    texts: list[str] = []
    depths: list[int] = []  # depth of braces in each enclosing template
    position = 0

    def placeholder(cut: str) -> str:
        texts.append(cut)
        return f"\0{len(texts) - 1}\0"

    while match := _OPAQUE.search(text, position):
        pieces.append(text[position : match.start()])
        position, token = match.end(), match[0]
        ends_template_value = token == "}" and bool(depths) and not depths[-1]
        if token in "{}" and not ends_template_value:
            pieces.append(token)
            if depths:
                depths[-1] += 1 if token == "{" else -1
        elif token in "`}":
            end = _TEXT.match(text, position)
            assert end is not None, text[position : position + 40]
            if token == "}":
                depths.pop()
            if end[0].endswith("{"):
                depths.append(0)
            pieces.append(placeholder(token + end[0]))
            position = end.end()
        elif not token.startswith(("//", "/*")):
            pieces.append(placeholder(token))
    return "".join([*pieces, text[position:]]), texts


def _join_line(line_break: re.Match[str]) -> str:
    """Return the replacement for a line break: the bracket or comma before it, otherwise a line break."""
    return line_break[1] or "\n"


def _restored(code: str, texts: list[str]) -> str:
    return re.sub(r"\0(\d+)\0", lambda placeholder: texts[int(placeholder[1])], code)


def _declared(code: str) -> Iterator[tuple[str, bool]]:
    """Yield the names that a module declares at top level, and whether it exports them."""
    for match in _DECLARED.finditer(code):
        is_exported = match["export"] is not None
        symbol = match["function"] or match["class"]
        if symbol is not None:
            yield symbol, is_exported
        else:
            for name in _variables(code, match.end()):
                yield name, is_exported


def _variables(code: str, start: int) -> Iterator[str]:
    """Yield the variables of a declaration that begins at `start`: `a = 1, [b, c] = d, { e, f: g } = h;`."""
    depth, before_value = 0, True  # depth of brackets; whether the token is a variable or pattern
    for token in re.finditer(r"[\w$]+|\S", code[start:]):
        word = token[0]
        if word == ";" and not depth:
            return
        if word in ("[{" if before_value else "([{"):
            depth += 1
        elif word in ("]}" if before_value else ")]}"):
            depth -= 1
            before_value = before_value and depth > 0  # a nested pattern may be followed by more variables
        elif before_value and _NAME.fullmatch(word):
            is_key = depth and code[start + token.end() :].lstrip().startswith(":")
            if not is_key:
                yield word
            before_value = bool(depth)
        elif word == "," and not depth:
            before_value = True


def _renamed(code: str, names: Mapping[str, str], spaces: Mapping[str, Mapping[str, str]]) -> str:
    """Return code with its names replaced; `orders.look` of a whole module becomes the member's name."""
    if not names and not spaces:
        return code
    all_names = "|".join(sorted(map(re.escape, (*names, *spaces)), key=len, reverse=True))
    pattern = re.compile(rf"[(){{}}\[\]]|(?<![\w$])(?:{all_names})(?![\w$])")
    kinds: list[str] = []  # kinds of the enclosing brackets
    pieces, position = [], 0
    for match in pattern.finditer(code):
        token = match[0]
        if token in "([{":
            kinds.append(_kind(code, match.start()) if token == "{" else token)
        elif token in ")]}":
            kinds.pop()
        elif match.start() >= position:
            new_name, end = _new_name(code, match, names, spaces, kinds[-1] if kinds else "")
            pieces += [code[position : match.start()], new_name]
            position = end
    return "".join([*pieces, code[position:]])


def _kind(code: str, brace: int) -> str:
    """Return what begins at a brace: "class", "block", or "object" for an object or pattern."""
    text_before = code[max(0, brace - 80) : brace]
    if _CLASS_BEFORE.search(text_before):
        return "class"
    return "block" if _BLOCK_BEFORE.search(text_before) else "object"


def _new_name(
    code: str,
    match: re.Match[str],
    names: Mapping[str, str],
    spaces: Mapping[str, Mapping[str, str]],
    kind: str,
) -> tuple[str, int]:
    """Return the replacement for a name within braces of a kind, and the index where the code continues."""
    name, end = match[0], match.end()
    text_before, text_after = code[max(0, match.start() - 40) : match.start()], code[end : end + 40].lstrip()
    chained = text_before.rstrip(" \n")
    if chained.endswith(".") and not chained.endswith("..."):  # a property
        return name, end
    if kind in ("object", "class") and _KEY_BEFORE.search(text_before):
        is_shorthand = kind == "object" and (text_after[:1] in ",}" or re.match(r"=[^=>]", text_after))
        return (f"{name}: {names[name]}" if is_shorthand else name), end
    if name in spaces:
        member = re.compile(r"\s*\.\s*([\w$]+)").match(code, end)
        assert member is not None, f"{name} is a whole module: only its members may be used"
        return spaces[name][member[1]], member.end()
    return names[name], end
