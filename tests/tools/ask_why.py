"""Ask all questions of `tests/support/why_questions.py`, and compare the last link with the planted cause.

python tests/tools/ask_why.py [WORD]      only questions with that word; prints whole answers
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from scanrack.ladder.debug.telling import told
from why_questions import QUESTIONS, do, make


def main() -> None:
    """Ask."""
    word = sys.argv[1] if len(sys.argv) > 1 else ""
    right = asked = 0
    for each in QUESTIONS:
        if word not in " ".join((each.group, each.world, each.asked)):
            continue
        with tempfile.TemporaryDirectory() as folder:
            bench = make(Path(folder), each.world)
            try:
                do(bench, each.done)
                link = bench.chain(each.asked)
                said, kind = told(link), link.end.kind
            except Exception as error:
                said, kind = f"{type(error).__name__}: {error}", ""
        last = " ".join(said[max(0, said.rfind("Cause: ")) :].split())
        good = kind == each.kind and all(part in last for part in each.words)
        right, asked = right + good, asked + 1
        print(f"--- {'right' if good else 'WRONG'}: {each.world}: {each.done}: {each.asked}? {kind}")
        print(said if word or not good else last)
    print(f"{right} of {asked} right")


if __name__ == "__main__":
    main()
