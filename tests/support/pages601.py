"""The tables of docs/pcl601.md, made from the tables in io_images; writes them with --write."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from scanrack.io_images.pcl601 import CAUSES, COMMANDS, FIRMWARE, MAP, NEEDS_IDLE, Code, Register

PAGE = Path(__file__).parents[2] / "docs" / "pcl601.md"
BLOCK = re.compile(r"(<!-- (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| " + " | ".join(str(cell) for cell in line) + " |\n" for line in lines)


def code(text):
    return f"`{text}`" if text else ""


def registers():
    rows = []
    for row in MAP:
        references = f"4x{row.reference}" + (f", {row.reference + 1}" if row.words == 2 else "")
        notes = ["read only"] * (not row.writable) + ["locked in motion"] * row.locked
        notes += ["non-volatile"] * row.kept
        letters = " ".join(code(letter) for letter in row.ascii.split())
        limits, default = f"{row.low:,} to {row.high:,}", f"{row.default:,}"
        if row.register is Register.FIRMWARE:
            limits, default = "fixed", f"{row.default:08X}h, `{FIRMWARE}` in ASCII"
        rows.append([references, row.meaning, limits, default, letters, ", ".join(notes)])
    return table(["Register", "Meaning", "Range", "Power-up", "ASCII", "Notes"], rows)


def codes():
    rows = [[int(c), c.name.replace("_", " ").lower(), "yes" if c in NEEDS_IDLE else ""] for c in Code]
    return table(["Code", "Command", "Needs an idle axis"], rows)


def commands():
    rows = []
    for command in COMMANDS:
        form = ", ".join(f"`{part}`" for part in command.form.replace("|", "\\|").split(", "))
        rows.append([form, command.meaning, "yes" if command.while_running else ""])
    return table(["Form", "Meaning", "While a program runs"], rows)


def errors():
    return table(["Value", "Raised by"], [[int(error), cause] for error, cause in CAUSES.items()])


TABLES = {"registers": registers, "codes": codes, "commands": commands, "errors": errors}


def made(text):
    """Return the page's text with its tables as they should be."""
    return BLOCK.sub(lambda found: found[1] + "\n" + TABLES[found[2]]() + "\n" + found[3], text)


if __name__ == "__main__":
    before = PAGE.read_text(encoding="utf-8")
    if "--write" in sys.argv:
        PAGE.write_text(made(before), encoding="utf-8")
    else:
        sys.exit(made(before) != before)
