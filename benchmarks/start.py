"""What a command costs before it works: processor time in units of an empty Python.

    python benchmarks/start.py [--smoke]

`scanrack --help`, `scanrack run --help` and the README's job, of ten scans, each in a process of its own,
beside `python -c pass` and `import numpy, pydantic`, which the job needs; the least of the rounds counts.

Exit status 1 if the help of run takes more than 1.5 times as long as that of the whole, or the job more than
five times as long as these two libraries.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

LINE = Path(__file__).parents[1] / "examples/three_stations/line.toml"
MOST_HELP, MOST_JOB = 1.5, 5.0
TICK_S = 0.01

COMMANDS = {
    "python -c pass": ("-c", "pass"),
    "numpy and pydantic": ("-c", "import numpy, pydantic"),
    "scanrack --help": ("-m", "scanrack", "--help"),
    "scanrack run --help": ("-m", "scanrack", "run", "--help"),
    "the README's job": ("-m", "scanrack", "run", str(LINE), "--scans", "10", "--record", "a.mcap", "-q"),
}


def processor_s(words: tuple[str, ...], folder: str) -> float:
    """Return the processor time of a process, a tick at least: some systems count whole ticks."""
    before = os.times()
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    subprocess.run(
        [sys.executable, *words], cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL
    )
    after = os.times()
    took = after.children_user + after.children_system - before.children_user - before.children_system
    return max(took, TICK_S)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="one round, no limit")
    smoke = parser.parse_args().smoke
    with tempfile.TemporaryDirectory() as folder:
        rounds = 1 if smoke else 7
        least = {
            name: min(processor_s(words, folder) for _ in range(rounds)) for name, words in COMMANDS.items()
        }
    for name, seconds in least.items():
        print(
            f"{name:20} {seconds * 1000:6.0f} ms  {seconds / least['python -c pass']:5.1f} x python -c pass"
        )
    help_ratio = least["scanrack run --help"] / least["scanrack --help"]
    job_ratio = least["the README's job"] / least["numpy and pydantic"]
    print(f"run --help takes {help_ratio:.2f} of --help, at most {MOST_HELP}")
    print(f"the job takes {job_ratio:.2f} of the libraries, at most {MOST_JOB}")
    return int(not smoke and (help_ratio > MOST_HELP or job_ratio > MOST_JOB))


if __name__ == "__main__":
    sys.exit(main())
