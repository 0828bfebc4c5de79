"""Rewrite the assertions of test files in a process of its own, beside pytest that collects them.

    pytest   imports the first file, the second, ...   takes a file that is ready
    process  ... the last but one, the last            rewrites from the end

Rewriting is half of what collecting costs, and collecting is what no two processes do together. Files that
have bytecode are left out.
"""

from __future__ import annotations

import marshal
import os
import pickle
import shutil
import signal
import warnings
from collections.abc import Sequence
from pathlib import Path
from tempfile import mkdtemp
from types import CodeType

import pytest
from _pytest.assertion import rewrite
from processes import fork


class RewritingProcess:
    """A plugin of pytest.

    Args:
        config: of this run.
        files: the test files, in the order in which they are collected.
    """

    def __init__(self, config: pytest.Config, files: Sequence[Path]) -> None:
        self._names = {file: str(number) for number, file in enumerate(files)}
        self.folder, self.alone = Path(mkdtemp()), rewrite._rewrite_test
        self._pid = fork()
        if not self._pid:
            try:
                self._rewrite_all(config)
            finally:
                os._exit(0)
        rewrite._rewrite_test = self._rewritten

    def _rewrite_all(self, config: pytest.Config) -> None:
        warnings.simplefilter("error")
        for file, name in reversed(self._names.items()):
            if any(file.parent.glob(f"__pycache__/{file.stem}.*")):
                continue
            try:
                source, code = self.alone(file, config)
            except Exception:
                continue  # pytest meets it again and says so
            part = self.folder / "part"
            part.write_bytes(pickle.dumps((source, marshal.dumps(code))))
            part.rename(self.folder / name)

    def _rewritten(self, fn: Path, config: pytest.Config) -> tuple[bytes, CodeType]:
        try:
            source, code = pickle.loads((self.folder / self._names[fn]).read_bytes())
        except (KeyError, FileNotFoundError):
            return self.alone(fn, config)
        return source, marshal.loads(code)

    def pytest_collection_finish(self) -> None:
        """Let it end."""
        rewrite._rewrite_test = self.alone
        os.kill(self._pid, signal.SIGKILL)
        os.waitpid(self._pid, 0)
        shutil.rmtree(self.folder)
