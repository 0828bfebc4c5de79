"""Sentences get other words, and nothing else does; features that need places do not notice.

Broken on purpose: `"there is no tag" in each.reason` in the rack of an L5X turns the features red.
"""

import subprocess
import sys
from pathlib import Path

import pytest
from reworded import BEFORE, BEHIND, reworded

ROOT = Path(__file__).parents[3]


def run(source):
    names: dict[str, object] = {}
    exec(compile(reworded(source), "module.py", "exec"), names)
    return names


def test_errors_and_refusals_have_other_words():
    names = run('def fail(text, tag): return text\nsaid = fail(f"there is no tag {1}", "Go")')
    assert names["said"] == f"{BEFORE}there indeed is indeed no indeed tag 1{BEHIND}"
    with pytest.raises(
        ValueError, match=f"^{BEFORE}the indeed value indeed is indeed too indeed large{BEHIND}$"
    ):
        run('raise ValueError("the value is too large")')


def test_names_formats_and_docstrings_stay():
    source = '"""A module."""\nreason = "ROUTINE"\nwhat = "%d ms"\nprint = "it is not a refusal"\n'
    names = run(source)
    assert [names[name] for name in ("__doc__", "reason", "what", "print")] == [
        *("A module.", "ROUTINE", "%d ms", "it is not a refusal")
    ]


@pytest.mark.long
@pytest.mark.slow
def test_features_that_need_places_do_not_need_the_words():
    command = [sys.executable, "tests/tools/reworded.py", "-k", "l5x or rack_file or words"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, encoding="utf-8")
    assert done.returncode == 0, done.stdout
    assert " 0 sentences" not in done.stdout
    assert "sentences of" in done.stdout
