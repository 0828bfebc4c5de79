"""The sound programs of `tests/programs`, and a way to check a program in a rack."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from scanrack.jobs.check import CheckReport, check_rack, load_any

SWITCHES = """
[slot.machine]
switches = [
    { input = "home", first = -1500, last = -1300 },
    { input = "ccw_limit", last = -4000 },
    { input = "cw_limit", first = 12000 },
]
"""

RACK = f"""\
program = "PROGRAM"
CONTROLLER
[[slot]]
number = 1
module = "amci3601"
{SWITCHES}
[[slot]]
number = 2
module = "1769-IQ16"

[[slot]]
number = 3
module = "1769-OB16"

[[slot]]
number = 4
module = "amci3601"
{SWITCHES}
"""

USED = "Configuration(inputs_used=InputBit.HOME | InputBit.CCW_LIMIT | InputBit.CW_LIMIT, starting_speed=500)"

_PROGRAMS = Path(__file__).parents[1] / "programs/sound"
_CLASSES = {"abort.py": "abort.py:Special", "winder.py": "winder.py:Winder"}  # files with several programs

SOUND = {
    _CLASSES.get(file.name, file.name): file.read_text(encoding="utf-8")
    for file in sorted(_PROGRAMS.iterdir())
    if file.is_file()  # not __pycache__
}
"""Programs of machine builders, by their names in a rack: `scanrack check` finds nothing in them."""

QUICK = ("blocks.rung", "words.rung", "tasks.rung", "text.rung", "function.py", "sequence.py")
"""The sound programs that the quick tests check."""

BLOCKS, SEQUENCE = SOUND["blocks.rung"], SOUND["sequence.py"]


def check(
    folder: Path, name: str, text: str, *, controller: str = "", rack: str = RACK, **options: Any
) -> CheckReport:
    """Check a program in the rack."""
    (folder / name.partition(":")[0]).write_text(text, encoding="utf-8")
    file = folder / "rack.toml"
    given = f'controller = "{controller}"' if controller else ""
    file.write_text(rack.replace("PROGRAM", name).replace("CONTROLLER", given), encoding="utf-8")
    return check_rack(load_any(str(file))[0], **options)
