"""docs/rack-file.md has every table and every key of a rack file, as the schema has them."""

from rack_page import PAGE, REMEDY, page
from scanrack.runtime.config.rack_schema import rack_schema


def test_the_page_is_as_it_should_be() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), REMEDY


def test_every_table_has_a_section_and_every_key_a_row_with_its_meaning() -> None:
    schema, text = rack_schema(), PAGE.read_text(encoding="utf-8")
    for table in (schema, *schema["$defs"].values()):
        assert any(
            all(f"\n| `{key}` | " in section for key in table["properties"])
            for section in text.split("\n## ")
        ), table["description"]
    assert text.count("\n## ") == len(schema["$defs"]) + 1
