"""What names in an export say in the rack file that `--rack` prints: nothing but themselves."""

import json
import tomllib
from html import escape
from pathlib import Path

import pytest
from l5x_files import diagram, document, ladder, module, program, task
from scanrack.jobs.imports.l5x_rack import rack_of
from scanrack.jobs.imports.slc_rack import rack_of_slc
from scanrack.jobs.imports.toml_text import comment, key, text
from scanrack.rockwell.l5x.importer import Importer
from scanrack.rockwell.l5x.xml.document import parse_document
from scanrack.rockwell.slc import import_slc

KNOWN = {"name", "program", "controller", "scan_ms", "rpi_ms", "run_for_s", "trace", "stubs", "slot"}
NAMES = (
    *('"; DROP', "../../x", "__class__", "a]\n[evil", 'x = "evil.py:f"\n[slot]', "'''", "#", "\\", "\t"),
    *("a\nevil = 1", "a\r\nevil = 1", "a\revil = 1", "\x7f", "\x85", "\u2028evil = 1", "\u202e", "𝄞", "É"),
)


def rack_of_name(name):
    """Return the rack file of an export in which all that can have a name has this one."""
    said = escape(name).replace("\n", "&#10;").replace("\r", "&#13;").replace("\t", "&#9;")
    whole = document(
        name=said,
        modules=[module(said, 1), module("Other", 2, catalog=said)],
        programs=[program("P", ladder("Main", "NOP();"), diagram(said, "FBD"))],
        tasks=[task("T", "P")],
    )
    imported = Importer(parse_document(whole.encode(), "machine.L5X")).run(trial=True)
    return rack_of(imported, Path("machine.L5X"))


@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_no_name_breaks_out_of_its_place(name):
    printed = rack_of_name(name)
    read = tomllib.loads(printed)
    assert set(read) <= KNOWN
    assert read["name"] == name
    assert set(read.get("stubs", {}).values()) <= {"false", "empty"}
    assert [each["number"] for each in read["slot"]] == [1]
    assert printed.replace("\n", "").isprintable()


def test_a_name_that_stands_for_two_things_is_one_key():
    whole = document(
        programs=[
            program("P", ladder("Main", "FOO(A);", "FOO(A);"), diagram("FOO", "FBD")),
            program("Q", diagram("FOO", "FBD"), main=""),
        ]
    )
    imported = Importer(parse_document(whole.encode(), "machine.L5X")).run(trial=True)
    assert tomllib.loads(rack_of(imported, Path("machine.L5X")))["stubs"]["FOO"] == "false"


@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_texts_keys_and_comments(name):
    assert tomllib.loads(f"a = {text(name)}") == {"a": name}
    assert tomllib.loads(f"{key(name)} = 1") == {name: 1}
    assert tomllib.loads(f"{comment(name)}\na = 1") == {"a": 1}
    assert json.loads(f"[{text(name)}]") == [name]


@pytest.mark.parametrize("name", ["a\u2028[evil]", "\x85evil", "\x7f", '"'])
def test_comments_of_an_slc(tmp_path, name):
    path = tmp_path / "line.SLC"
    path.write_text(f"SLOT 1 {name}\nSOR XIC B3:0/0 {name} OTE B3:0/1 EOR\n", encoding="utf-8")
    assert set(tomllib.loads(rack_of_slc(import_slc(path), path))) <= KNOWN
