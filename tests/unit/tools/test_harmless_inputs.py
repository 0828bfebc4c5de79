"""No tracked file holds an input that crashes, hangs or slips past a check of software that is not ours.

Guards are tested with harmless inputs: a text one step beyond our limit, a small chunk under a small limit, a
bare DOCTYPE, a stub of a transport. Each row of the table is a form that such an input has had or could have.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]

PATTERNS: dict[str, tuple[str, str]] = {
    "an entity": (
        r"<!ENTITY",
        "entities expand, and read files; a bare DOCTYPE is refused as well",
    ),
    "an external identifier": (
        r"<!DOCTYPE[^>\n]*\b(?:SYSTEM|PUBLIC)\b",
        "a parser may fetch it; a bare DOCTYPE is refused as well",
    ),
    "brackets, repeated": (
        r"""["'](?:\w*[\[({<]\w*[>=]?)+["'] ?\* ?(?:[2-9]_?\d{3}|\d{2,3}_\d{3}|\d{5,}|\d_\d{3}_\d{3})""",
        "nesting ends parsers; one level beyond our limit is refused as well",
    ),
    "parts of a name, repeated": (
        r"""["']["']?\w["']?\.["'] ?\* ?(?:\d{3,}|\d+_\d{3})""",
        "a dotted key takes parsers time and memory out of proportion; our limits are 16 and 64",
    ),
    "signs or operators, repeated": (
        r"""["'](?:\d?[-+~!]|not )["'] ?\* ?(?:\d{4,}|\d+_\d{3})""",
        "deep expressions end compilers; a stub that raises does as well",
    ),
    "a number with a great exponent": (
        r"(?<![\w.#-])[1-9](?:\.\d+)?[eE]\+?\d{5,}(?![\w.])",
        "its integer takes all memory; a number beyond the range of a double is refused as well",
    ),
    "much compressed": (
        r"compress(?:obj)?\(\s*bytes\((?:\d+ ?\* ?[MG]I?B|1 ?<< ?2\d|\d{7,}|\d+_\d{3}_\d{3})",
        "it unpacks to much; a small one is refused under `--max-chunk 1`",
    ),
    "records, repeated": (
        r"EMPTY ?\* ?(?:\d{5,}|\d+_\d{3}(?:_\d{3})+|[2-9]\d?_\d{3})",
        "readers keep each; a few are refused under a small `--max-records`",
    ),
    "a length beyond every file": (
        r"""pack\(["']<B[QI]["'][^)\n]*\b2 ?\*\* ?(?:3[0-9]|[4-6]\d)\b""",
        "readers may reserve that much; a length beyond the file is refused as well",
    ),
    "what others lack in their checks": (
        r"(?i)\b(?:asyncua|pymodbus|asyncio|tomllib|lxml|libxml2|mcap|cvc5|z3)\b[^\n]{0,80}"
        r"\b(?:bypass|segfault|never checks|does not check|without checking|can be crashed)\b",
        "a page says what happened, not how to do it",
    ),
}
"""A form of input, its pattern, and why it is not there."""

THIS = "tests/unit/tools/test_harmless_inputs.py"


def tracked() -> list[str]:
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True, encoding="utf-8"
    )
    return [each for each in listed.stdout.split("\0") if each and (ROOT / each).is_file()]


@pytest.mark.costly("what harms others must not land: all tracked files are read")
def test_no_tracked_file_holds_such_an_input() -> None:
    if not (ROOT / ".git").exists():
        pytest.skip("this is no clone: which files are kept is not known")
    every = re.compile("|".join(f"(?:{pattern.replace('(?i)', '')})" for pattern, _ in PATTERNS.values()))
    found = []
    for name in tracked():
        text = (ROOT / name).read_bytes().decode("utf-8", "replace")
        if name != THIS and every.search(text):
            found += [
                f"{name}: {form}: {why}"
                for form, (pattern, why) in PATTERNS.items()
                if re.search(pattern, text)
            ]
    assert found == []


MANY = "5_000"

EXAMPLES: dict[str, list[str]] = {
    "an entity": ["<!ENTITY" + ' a "b">'],
    "an external identifier": ["<!DOCTYPE" + ' a SYSTEM "b">'],
    "brackets, repeated": [
        f'"[" * {MANY}',
        f"'(' * {MANY}",
        f'b"<a>" * {MANY}',
        f'"A[" * {MANY}',
        '"[" * 100_000',
    ],
    "parts of a name, repeated": [f'"a." * {MANY}'],
    "signs or operators, repeated": [f'"-" * {MANY}', f'"1+" * {MANY}'],
    "a number with a great exponent": ["1e" + "9" * 6],
    "much compressed": ["zstandard.compress(bytes(64 * " + "MIB))"],
    "records, repeated": ["EMPTY * 3_000" + "_000"],
    "a length beyond every file": ['pack("<BQ", 6, 2' + "**62)"],
    "what others lack in their checks": ["asyncua 2.1 does not " + "check it"],
}

ALLOWED = [
    '"[" * 1_001',
    '"a." * 16',
    '"<a>" * 257',
    "1e400",
    "bytes(MIB + 1)",
    "EMPTY * 1_001",
    "<!DOCTYPE a>",
]


@pytest.mark.parametrize("form", PATTERNS)
def test_each_form_is_found(form: str) -> None:
    pattern, _ = PATTERNS[form]
    assert [each for each in EXAMPLES[form] if not re.search(pattern, each)] == []
    assert [each for each in ALLOWED if re.search(pattern, each)] == []
