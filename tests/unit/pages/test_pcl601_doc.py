"""docs/pcl601.md: its tables are those of the code, its example prints what it says."""

from __future__ import annotations

import re

from pages601 import BLOCK, PAGE, TABLES, made


def test_the_tables_are_up_to_date():
    text = PAGE.read_text(encoding="utf-8")
    assert [found[2] for found in BLOCK.finditer(text)] == list(TABLES)
    assert made(text) == text, "stale: run python tests/support/pages601.py --write"


def test_the_example(capsys):
    [code] = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    exec(code, {})
    assert capsys.readouterr().out.strip() == code.rpartition("# ")[2].strip()
