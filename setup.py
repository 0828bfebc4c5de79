"""Builds scanrack in a temporary folder, so that no file of an earlier build gets into a wheel.

Everything else is in pyproject.toml.
"""

import atexit
import shutil
import tempfile

from setuptools import setup
from setuptools.command.build import build


class FreshBuild(build):
    """Builds in a folder that goes with the process."""

    def initialize_options(self) -> None:
        """Choose the folder."""
        super().initialize_options()
        self.build_base = tempfile.mkdtemp(prefix="scanrack-build-")
        atexit.register(shutil.rmtree, self.build_base, ignore_errors=True)


setup(cmdclass={"build": FreshBuild})
