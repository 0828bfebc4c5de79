"""A wheel has the product's files, and nothing else that lies in the checkout."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from house import BESIDE, ROOMS, ROOT

pytestmark = pytest.mark.slow


def tracked() -> list[str]:
    """Return the files of the checkout that git has or would have, links left out."""
    words = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(words, cwd=ROOT, capture_output=True, check=True, encoding="utf-8").stdout
    return [name for name in listed.split("\0") if name and (ROOT / name).is_file()]


def test_a_wheel_has_the_tracked_files_of_each_room(tmp_path: Path) -> None:
    """A file of an earlier build in `build/` is not among them."""
    pytest.importorskip("setuptools", minversion="77")
    if not (ROOT / ".git").exists():
        pytest.skip("this is no clone: which files are tracked is not known")
    names = tracked()
    for name in names:
        (tmp_path / "checkout" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, tmp_path / "checkout" / name)
    stale = tmp_path / "checkout" / "build" / "lib" / "scanrack" / "stale.py"
    stale.parent.mkdir(parents=True)
    stale.touch()

    words = [sys.executable, "-c", "from setuptools.build_meta import *; build_wheel('..')"]
    done = subprocess.run(
        words, cwd=tmp_path / "checkout", capture_output=True, encoding="utf-8", check=False
    )
    assert done.returncode == 0, done.stderr

    (path,) = tmp_path.glob("*.whl")
    wheel = zipfile.ZipFile(path)
    packed = {name for name in wheel.namelist() if ".dist-info/" not in name}
    examples = [name for name in names if name.startswith("examples/") and name.count("/") == 2]
    own = [name for name in names if name.split("/")[0] in ROOMS]
    wanted = {*own, *examples, "examples/__init__.py"}
    assert packed == {f"scanrack/{name.removeprefix('scanrack/')}" for name in wanted}
    assert {name.split("/")[1] for name in packed} >= set(BESIDE)
