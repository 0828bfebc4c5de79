"""How near the instant of no return is to the planted one: ten small failures, and the time for each.

    python benchmarks/inevitable.py [--smoke]

The bar: within one scan in eight of ten, 3 s of a processor each.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from inevitable_programs import failures
from scanrack.jobs.fuzz.explain.futures import find_point_of_no_return


def main() -> int:
    """Measure; return 1 if fewer than eight of ten are near."""
    planted = list(failures())
    if "--smoke" in sys.argv:
        planted = [each for each in planted if each[0] == "same scan"]
    near = 0
    for name, each in planted:
        bench, found = each.found()
        begin = time.process_time()
        late = find_point_of_no_return(bench, found)
        assert late is not None, name
        near += abs(late.scan - each.scan) <= 1
        took = time.process_time() - begin
        print(
            f"{name:<16} planted {each.scan:>4}  found {late.scan:>4}"
            f"  {late.few:>2} to {late.many} of 40  {took:.2f} s"
        )
    print(f"{near} of {len(planted)} within one scan")
    return 0 if near * 10 >= len(planted) * 8 else 1


if __name__ == "__main__":
    sys.exit(main())
