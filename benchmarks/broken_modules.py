"""How soon are deliberately broken modules and programs found?

    python benchmarks/broken_modules.py             all of them, with the scripts of the CI profile
    python benchmarks/broken_modules.py --smoke     a handful, quickly

A broken module is a 3601 with one mistake (tests/support/broken3601.py); it is played in lockstep with the
oracle until the first difference. A broken program is a small user program with one mistake
(tests/support/broken_programs.py); it is searched as `scanrack fuzz` does.

Exit status: 0 all are found, 1 one of them is not.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from broken3601 import MISTAKES
from broken_programs import BROKEN_PROGRAMS, found_after
from hunt3601 import hunt, scripts_of

SMOKE = 6


def report_modules(count: int | None) -> bool:
    """Hunt mistakes and print a line for each; return whether all were found."""
    chosen = MISTAKES[:count]
    for theme in sorted({mistake.theme for mistake in chosen}):
        scripts_of(theme)
    found = 0
    print(f"{'scripts':>8} {'seconds':>8}  mistake")
    for mistake in chosen:
        start = perf_counter()
        after = hunt(mistake).examples
        found += after is not None
        seconds = perf_counter() - start
        print(f"{'never' if after is None else after:>8} {seconds:>8.2f}  {mistake.sentence}")
    print(f"{found} of {len(chosen)} broken modules found")
    return found == len(chosen)


def report_programs(count: int | None) -> bool:
    """Search programs and print a line for each; return whether all were found."""
    chosen = BROKEN_PROGRAMS[:count]
    found = 0
    print(f"{'runs':>8} {'seconds':>8}  mistake")
    for program in chosen:
        start = perf_counter()
        after = found_after(program)
        found += after is not None
        seconds = perf_counter() - start
        print(f"{'never' if after is None else after:>8} {seconds:>8.2f}  {program.sentence}")
    print(f"{found} of {len(chosen)} broken programs found (the seconds include shrinking)")
    return found == len(chosen)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(
        description="How soon are deliberately broken modules and programs found?"
    )
    parser.add_argument("--smoke", action="store_true", help="a handful, quickly")
    given = parser.parse_args(arguments)
    count = SMOKE if given.smoke else None
    modules, programs = report_modules(count), report_programs(count)
    return 0 if modules and programs else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
