"""Test files whose assertions a process of its own rewrites."""

import time
from pathlib import Path

import pytest
from _pytest.assertion import rewrite
from rewriting import RewritingProcess


def test_pytest_takes_what_the_process_has_rewritten(tmp_path: Path, pytestconfig: pytest.Config) -> None:
    file, odd = tmp_path / "test_one.py", tmp_path / "test_two.py"
    file.write_text("def test(): assert [1] == [2]\n", encoding="utf-8")
    odd.write_text("def test(: pass\n", encoding="utf-8")
    alone = rewrite._rewrite_test
    expected = alone(file, pytestconfig)
    process = RewritingProcess(pytestconfig, [file, odd])
    try:
        while not (process.folder / "0").exists():
            time.sleep(0.001)
        assert [each.name for each in process.folder.iterdir()] == ["0"]
        process.alone = lambda *_: pytest.fail("rewritten twice")
        assert rewrite._rewrite_test(file, pytestconfig) == expected
        process.alone = alone
        with pytest.raises(SyntaxError):
            rewrite._rewrite_test(odd, pytestconfig)
    finally:
        process.pytest_collection_finish()
    assert rewrite._rewrite_test is alone
    assert not process.folder.exists()
