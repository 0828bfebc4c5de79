"""The line locator: by hand for every form of TOML, and for all that hypothesis thinks of."""

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scanrack.runtime.config.tomllines import KeyLines

DOCUMENT = '''\
# a rack
name = "line # 1"   # comment
"quoted key" = 'lit[e]ral'
dotted . "inner key".last = 3

text = """
first [line]
second = "not a key"
\\""" still text """
raw = \'\'\'
x = 1\'\'\'
when = 1979-05-27 07:32:00
[plain.table] # comment
number = 1
list = [ # a list
  1,
  "two, three",
  [4, 5],

  { six = 6, seven.eight = [
    8 ] },
]
[[slot]]
number = 1
[slot.machine]
switches = [{input = "home", first = 1}, {input = "cw"}]
[[slot.machine.stations]]
position = 0
[[slot.machine.stations]]
position = 4000
[[slot]]
number = 2
machine.encoder.counts_per_step = 1
[[slot.machine.stations]]
position = 8000
'''

LINES = {
    ("name",): 2,
    ("quoted key",): 3,
    ("dotted", "inner key", "last"): 4,
    ("text",): 6,
    ("raw",): 10,
    ("when",): 12,
    ("plain", "table"): 13,
    ("plain", "table", "number"): 14,
    ("plain", "table", "list"): 15,
    ("plain", "table", "list", 0): 16,
    ("plain", "table", "list", 1): 17,
    ("plain", "table", "list", 2): 18,
    ("plain", "table", "list", 2, 1): 18,
    ("plain", "table", "list", 3, "six"): 20,
    ("plain", "table", "list", 3, "seven", "eight"): 20,
    ("plain", "table", "list", 3, "seven", "eight", 0): 21,
    ("slot", 0): 23,
    ("slot", 0, "number"): 24,
    ("slot", 0, "machine"): 25,
    ("slot", 0, "machine", "switches", 0, "first"): 26,
    ("slot", 0, "machine", "switches", 1, "input"): 26,
    ("slot", 0, "machine", "stations", 0): 27,
    ("slot", 0, "machine", "stations", 1, "position"): 30,
    ("slot", 1): 31,
    ("slot", 1, "number"): 32,
    ("slot", 1, "machine", "encoder", "counts_per_step"): 33,
    ("slot", 1, "machine", "stations", 0, "position"): 35,
}


def paths_of(value, path=()):
    """Return every key path of a parsed document."""
    yield path
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from paths_of(inner, (*path, key))
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            yield from paths_of(inner, (*path, index))


@pytest.mark.parametrize(("path", "line"), LINES.items(), ids=str)
def test_the_line_of_a_key(path, line):
    assert KeyLines(DOCUMENT).paths[path] == line


def test_every_key_is_found_and_nothing_else():
    assert set(KeyLines(DOCUMENT).paths) == set(paths_of(tomllib.loads(DOCUMENT))) - {()}


def test_what_is_missing_is_at_the_table_around_it():
    lines = KeyLines(DOCUMENT)
    assert lines.line(("slot", 1, "firmware")) == 31
    assert lines.line(("slot", 0, "machine", "switches", 1, "last")) == 26
    assert lines.line(("nothing",)) == 1


def test_windows_line_ends():
    assert KeyLines("a = 1\r\n\r\nb = '''\r\n'''\r\nc = 2\r\n").paths == {("a",): 1, ("b",): 3, ("c",): 5}


KEYS = st.one_of(st.from_regex(r"[A-Za-z0-9_-]{1,6}", fullmatch=True), st.just("a b"), st.just('q"[#]'))
STRINGS = st.text(st.sampled_from("a\"'\\#[]{}=,. \n"), max_size=8)
VALUES = st.recursive(
    st.one_of(st.integers(-9, 9), st.booleans(), STRINGS),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(KEYS, inner, max_size=3)),
    max_leaves=8,
)


def basic(text):
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


def written(value):
    """Write a value in TOML, arrays over several lines."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return basic(value) if '"' in value or "\\" in value else f'"""\n{value}"""'
    if isinstance(value, list):
        return "[\n" + "".join(f"  {written(inner)}, # [\n" for inner in value) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{basic(key)} = {written(inner)}" for key, inner in value.items()) + "}"
    return str(value)


@pytest.mark.slow
@given(st.lists(st.tuples(KEYS, VALUES), max_size=5, unique_by=lambda pair: pair[0]))
def test_every_key_of_any_document_is_found_where_it_was_written(pairs):
    text, lines = "", {}
    for key, value in pairs:
        text += "\n"
        lines[(key,)] = text.count("\n") + 1
        text += f"{basic(key)} = {written(value)}\n"
    found = KeyLines(text).paths
    assert set(found) == set(paths_of(tomllib.loads(text))) - {()}
    assert {path: line for path, line in found.items() if len(path) == 1} == lines
