#!/usr/bin/env python3
"""A digest of what each example records in 5 s of machine time: tests/golden/examples.txt.

    python tests/tools/example_digests.py           print those that differ; exit status 1 if there are some
    python tests/tools/example_digests.py --write   write them all

It covers topic, time and bytes of each message, not the compression: that may change with its library.
"""

from __future__ import annotations

import hashlib
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from mcap.reader import make_reader
from scanrack.commands import build
from typer.testing import CliRunner

ROOT = Path(__file__).resolve().parents[2]
DIGESTS = ROOT / "tests" / "golden" / "examples.txt"
TIME = "5s"


def racks() -> list[str]:
    """Return the rack files of all examples, relative to the repository."""
    return sorted(each.relative_to(ROOT).as_posix() for each in ROOT.glob("examples/*/*.toml"))


def digest_of(rack: str) -> str:
    """Run an example; return the digest of its recording."""
    with tempfile.TemporaryDirectory() as folder:
        trace = Path(folder) / "trace.mcap"
        words = ["run", str(ROOT / rack), "--for", TIME, "--quiet", "--record", str(trace)]
        done = CliRunner().invoke(build(), words)
        assert done.exit_code == 0, done.output
        return _digest(trace)


def _digest(trace: Path) -> str:
    digest = hashlib.sha256()
    with trace.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages(log_time_order=False):
            digest.update(f"{channel.topic} {message.log_time} {len(message.data)} ".encode())
            digest.update(message.data)
    return digest.hexdigest()


def kept() -> Mapping[str, str]:
    """Return the digests in the file, by rack."""
    lines = DIGESTS.read_text(encoding="utf-8").splitlines()
    return {rack: digest for digest, rack in map(str.split, lines)}


def main() -> int:
    """Compare or write the digests; return the exit status."""
    found = {each: digest_of(each) for each in racks()}
    if "--write" in sys.argv:
        lines = [f"{digest}  {rack}\n" for rack, digest in found.items()]
        DIGESTS.write_text("".join(lines), encoding="utf-8", newline="\n")
        return 0
    differing = sorted(rack for rack in {*found, *kept()} if found.get(rack) != kept().get(rack))
    sys.stdout.writelines(f"{each}: it differs\n" for each in differing)
    return bool(differing)


if __name__ == "__main__":
    sys.exit(main())
