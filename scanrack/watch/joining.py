"""Joins the page's modules into one script for a single request: removes comments, numbers names.

    dom.js     export const at = …            const at$1 = …;
    notice.js  import { at } from "./dom.js"
               at("notice").hidden = true     at$1("notice").hidden = true
    page.js                                   export { at$1, … }
    /dom.js    what scripts import            export { at$1 as at } from "./page.js";

A module's name gets its number everywhere in that module, even where a local variable has the same name: all
its uses are renamed alike. Names of properties stay.
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
_AGAIN = re.compile(r'^export \{(?P<names>[^}]*)\} from "\./(?P<file>[\w.]+)";\n', re.MULTILINE)
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
_MARGIN = re.compile(r"([,(\[])?\n\s*")
_TEXT = re.compile(r"(?:\\.|[^`\\$]|\$(?!\{))*+(?:`|\$\{)", re.DOTALL)
_BLOCK_BEFORE = re.compile(r"(?:[);{}>]|\b(?:else|try|catch|finally|do)|^)\s*$")
_CLASS_BEFORE = re.compile(r"\bclass [\w$]+(?: extends [\w$.]+)?\s*$")
_KEY_BEFORE = re.compile(r"[{,;}]\s*(?:(?:get|set|static|async) )*+$")


class PageScript(NamedTuple):
    """The modules joined into one script."""

    script: str
    facades: Mapping[str, str]
    """Text of each module, by name, for scripts that import it in addition to the joined script."""


class _Module(NamedTuple):
    code: str  # code without imports; parts that can't contain names are cut out
    texts: list[str]  # the parts that are cut out
    imports: dict[str, tuple[str, str]]  # own name -> file, and the name there; "*" = the whole module
    files: list[str]  # imported files, in the order of the imports
    names: dict[str, bool]  # names declared at top level -> whether they are exported
    again: dict[str, tuple[str, str]]  # exported name -> file, and the name there


def joined(modules: Mapping[str, str]) -> PageScript:
    """Join modules, given by name, in the order in which `main.js` runs them.

    Raises:
        ValueError: a module imports a name that the other module does not export.
    """
    parsed = {name: _read(text) for name, text in modules.items()}
    order = list(dict.fromkeys(_order(parsed, MAIN, set())))
    numbers = {name: number for number, name in enumerate(order)}
    parts, facades, exported = [], {}, []
    for name in order:
        module = parsed[name]
        own_names = {symbol: f"{symbol}${numbers[name]}" for symbol in module.names}
        code = _renamed(module.code, *_finals(parsed, numbers, name, own_names))
        parts.append(_restored(_MARGIN.sub(_join_line, code), module.texts))
        exports = _exports(parsed, numbers, name)
        exported += [own_names[symbol] for symbol, is_exported in module.names.items() if is_exported]
        listed = ", ".join(f"{final} as {symbol}" for symbol, final in exports.items())
        facades[name] = f'export {{ {listed} }} from "./{PAGE}";\n'
    return PageScript(f"{''.join(parts)}export {{ {', '.join(exported)} }};\n", facades)


def _finals(
    read: Mapping[str, _Module], numbers: Mapping[str, int], name: str, own: Mapping[str, str]
) -> tuple[dict[str, str], dict[str, dict[str, str]]]:
    """Return the final names in a module, and the final names of each module that it imports as a whole."""
    imports = read[name].imports.items()
    imported_names = {
        symbol: _final(read, numbers, name, *place) for symbol, place in imports if place[1] != "*"
    }
    spaces = {
        symbol: _exports(read, numbers, file) for symbol, (file, imported) in imports if imported == "*"
    }
    return {**own, **imported_names}, spaces


def _order(read: Mapping[str, _Module], name: str, seen: set[str]) -> Iterator[str]:
    """Yield the modules in the order in which a browser runs them [ECMA-262, section 16.2.1.6]."""
    if name in seen:
        return
    seen.add(name)
    for file in read[name].files:
        yield from _order(read, file, seen)
    yield name


def _exports(read: Mapping[str, _Module], numbers: Mapping[str, int], file: str) -> dict[str, str]:
    """Return the names that a module exports, with their names in the joined script."""
    own_names = {
        symbol: f"{symbol}${numbers[file]}" for symbol, is_exported in read[file].names.items() if is_exported
    }
    return own_names | {
        symbol: _final(read, numbers, file, *place) for symbol, place in read[file].again.items()
    }


def _final(read: Mapping[str, _Module], numbers: Mapping[str, int], by: str, file: str, name: str) -> str:
    final = _exports(read, numbers, file).get(name)
    if final is None:
        raise ValueError(f"{by} imports {name!r} of {file}, which does not export it")
    return final


# --- one module


def _read(text: str) -> _Module:
    imports: dict[str, tuple[str, str]] = {}
    reexports: dict[str, tuple[str, str]] = {}
    files = []
    for match in _IMPORT.finditer(text):
        files.append(match["file"])
        names = (match["names"] or "").strip()
        if names.startswith("*"):
            imports[names.split()[-1]] = match["file"], "*"
        for local_name, imported_name in _listed(names.strip("{}")) if names.startswith("{") else ():
            imports[local_name] = match["file"], imported_name
    for match in _AGAIN.finditer(text):
        files.append(match["file"])
        reexports |= {
            local_name: (match["file"], imported_name)
            for local_name, imported_name in _listed(match["names"])
        }
    code, texts = _cut_out(_AGAIN.sub("", _IMPORT.sub("", text)))
    names = dict(_declared(code))
    return _Module(re.sub(r"^export ", "", code, flags=re.MULTILINE), texts, imports, files, names, reexports)


def _listed(names: str) -> Iterator[tuple[str, str]]:
    """Yield the new and the old name of each entry in a list such as `a, b as c`."""
    for part in filter(None, map(str.strip, names.split(","))):
        old, _, new = part.partition(" as ")
        yield new or old, old


def _cut_out(text: str) -> tuple[str, list[str]]:
    """Return code without comments, with placeholders for texts and patterns, and the cut-out parts."""
    parts: list[str] = []
    texts: list[str] = []
    depths: list[int] = []  # depth of braces in each enclosing template
    place = 0

    def keep(kept: str) -> str:
        texts.append(kept)
        return f"\0{len(texts) - 1}\0"

    while match := _OPAQUE.search(text, place):
        parts.append(text[place : match.start()])
        place, token = match.end(), match[0]
        if token in "{}" and not (token == "}" and depths and not depths[-1]):
            parts.append(token)
            if depths:
                depths[-1] += 1 if token == "{" else -1
        elif token in "`}":
            end = _TEXT.match(text, place)
            assert end is not None, text[place : place + 40]
            if token == "}":
                depths.pop()
            if end[0].endswith("{"):
                depths.append(0)
            parts.append(keep(token + end[0]))
            place = end.end()
        else:
            parts.append("" if token.startswith(("//", "/*")) else keep(token))
    return "".join([*parts, text[place:]]), texts


def _join_line(found: re.Match[str]) -> str:
    """Return a line break without the next line's indentation; nothing where both lines can be one."""
    return found[1] or "\n"


def _restored(code: str, texts: list[str]) -> str:
    return re.sub(r"\0(\d+)\0", lambda found: texts[int(found[1])], code)


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


def _variables(code: str, place: int) -> Iterator[str]:
    """Yield the variables of a declaration that begins at a place: `a = 1, [b, c] = d, { e, f: g } = h;`."""
    depth, begins = 0, True  # depth of brackets; whether a variable comes next, until its value begins
    for token in re.finditer(r"[\w$]+|\S", code[place:]):
        word = token[0]
        if word == ";" and not depth:
            return
        if word in ("[{" if begins else "([{"):
            depth += 1
        elif word in ("]}" if begins else ")]}"):
            depth, begins = depth - 1, begins and not depth
        elif begins and _NAME.fullmatch(word):
            if not (depth and code[place + token.end() :].lstrip().startswith(":")):
                yield word
            begins = bool(depth)
        elif word == "," and not depth:
            begins = True


def _renamed(code: str, names: Mapping[str, str], spaces: Mapping[str, Mapping[str, str]]) -> str:
    """Return code with its names replaced; for a whole module, `orders.look` becomes the member's name."""
    if not names and not spaces:
        return code
    all_names = "|".join(sorted(map(re.escape, (*names, *spaces)), key=len, reverse=True))
    pattern = re.compile(rf"[(){{}}\[\]]|(?<![\w$])(?:{all_names})(?![\w$])")
    kinds: list[str] = []  # kinds of the enclosing brackets
    parts, place = [], 0
    for match in pattern.finditer(code):
        token = match[0]
        if token in "([{":
            kinds.append(_kind(code, match.start()) if token == "{" else token)
        elif token in ")]}":
            kinds.pop()
        elif match.start() >= place:
            new_name, end = _new_name(code, match, names, spaces, kinds[-1] if kinds else "")
            parts += [code[place : match.start()], new_name]
            place = end
    return "".join([*parts, code[place:]])


def _kind(code: str, place: int) -> str:
    """Return what a brace begins: "class", "block", or "object" for an object or pattern."""
    before = code[max(0, place - 80) : place]
    if _CLASS_BEFORE.search(before):
        return "class"
    return "block" if _BLOCK_BEFORE.search(before) else "object"


def _new_name(
    code: str,
    found: re.Match[str],
    names: Mapping[str, str],
    spaces: Mapping[str, Mapping[str, str]],
    kind: str,
) -> tuple[str, int]:
    """Return the replacement for a name, and the place where the code continues."""
    name, end = found[0], found.end()
    before, after = (
        code[max(0, found.start() - 40) : found.start()].rstrip(" \n"),
        code[end : end + 40].lstrip(),
    )
    if before.endswith(".") and not before.endswith("..."):
        return name, end
    if kind in ("object", "class") and _KEY_BEFORE.search(code[max(0, found.start() - 40) : found.start()]):
        short = kind == "object" and (after[:1] in ",}" or re.match(r"=[^=>]", after))
        return (f"{name}: {names[name]}" if short else name), end
    if name in spaces:
        member = re.compile(r"\s*\.\s*([\w$]+)").match(code, end)
        assert member is not None, f"{name} is a whole module: only its members are used"
        return spaces[name][member[1]], member.end()
    return names[name], end
