"""The root of the repository has the files that belong there, and none that was only tried out."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
FILES = {
    *("CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "MANIFEST.in", "README.md", "SECURITY.md"),
    *("Dockerfile", ".dockerignore", "action.yml"),
    *(
        "pyproject.toml",
        "setup.py",
        "conftest.py",
        ".git-blame-ignore-revs",
        ".gitignore",
        ".pre-commit-config.yaml",
    ),
}


def test_no_stray_file_is_kept():
    if not (ROOT / ".git").exists():
        pytest.skip("this is no clone: which files are kept is not known")
    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True, encoding="utf-8"
    )
    assert {each for each in listed.stdout.splitlines() if "/" not in each} <= FILES
