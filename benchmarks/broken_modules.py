"""How soon are deliberately broken modules found?

    python benchmarks/broken_modules.py             all of them, with the scripts of the CI profile
    python benchmarks/broken_modules.py --smoke     a handful, quickly

A broken module is a 3601 with one mistake (tests/support/broken3601.py); it is played in lockstep with the
oracle until the first difference.

Exit status: 0 all are found, 1 one of them is not.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from broken3601 import MISTAKES
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


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="How soon are deliberately broken modules found?")
    parser.add_argument("--smoke", action="store_true", help="a handful, quickly")
    given = parser.parse_args(arguments)
    return 0 if report_modules(SMOKE if given.smoke else None) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
