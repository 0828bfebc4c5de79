"""`git diff` with the two lines that docs/l5x.md prints."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from l5x_files import machine

DOCS = Path(__file__).parents[3] / "docs" / "l5x.md"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("git") is None, reason="git is not installed"),
]


@pytest.fixture
def git(tmp_path):
    """Run git in a repository; the page's command is the installed one."""

    def run(*words):
        identity = ("-c", "user.name=n", "-c", "user.email=n@example.com")
        done = subprocess.run(
            ["git", *identity, *words],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            encoding="utf-8",
            check=True,
        )
        return done.stdout

    run("init", "-q")
    attributes = re.search(r"echo '(.*)' >> .gitattributes", DOCS.read_text(encoding="utf-8"))
    setting = re.search(r'git config (\S+) "scanrack (.*)"', DOCS.read_text(encoding="utf-8"))
    assert attributes is not None
    assert setting is not None
    (tmp_path / ".gitattributes").write_text(attributes[1] + "\n", encoding="utf-8")
    run("config", setting[1], f'"{Path(sys.executable).as_posix()}" -m scanrack {setting[2]}')
    return run


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_git_shows_rungs_instead_of_xml(tmp_path, git, encoding):
    rungs = ["XIC(A)OTE(B);", "XIC(B)OTE(C);"]
    file = tmp_path / "machine.L5X"
    file.write_text(machine(*rungs).replace("UTF-8", encoding), encoding=encoding)
    git("add", ".")
    git("commit", "-q", "-m", "one")
    changed = machine(rungs[0], "XIC(B)XIO(D)OTE(C);").replace("UTF-8", encoding)
    file.write_text(changed, encoding=encoding)
    for shown in (git("diff"), git("commit", "-q", "-a", "-m", "two") + git("log", "-p", "-1")):
        lines = shown.splitlines()
        edits = [each for each in lines if each.startswith(("+", "-")) and each[:3] not in ("+++", "---")]
        assert edits == ["-  XIC(B)OTE(C);", "+  XIC(B)XIO(D)OTE(C);"]
        assert any(each.startswith("@@") for each in lines)
