"""Find the packages, and build in a temporary folder: no file of an earlier build gets into a wheel.

Everything else is in pyproject.toml.
"""

import atexit
import shutil
import tempfile

from setuptools import find_packages, setup
from setuptools.command.build import build

BESIDE = ("examples", "io_images", "ladder", "rockwell", "runtime", "traces")
"""Folders beside `scanrack` that are installed in it: `io_images` is the package `scanrack.io_images`."""

FOLDERS = {"scanrack": "scanrack"} | {f"scanrack.{name}": name for name in BESIDE}


def packages() -> list[str]:
    """Return the names of all packages: each folder's, and those of the folders in it with an `__init__.py`.

    Links to the folders beside it are left out in `scanrack`: type checkers follow them, Python has no need.
    """
    links = [pattern for name in BESIDE for pattern in (name, f"{name}.*")]
    below = find_packages("scanrack", exclude=links)
    beside = [f"{name}.{each}" for name in BESIDE for each in find_packages(name)]
    return [*FOLDERS, *(f"scanrack.{each}" for each in (*below, *beside))]


class FreshBuild(build):
    """Builds in a folder that goes with the process."""

    def initialize_options(self) -> None:
        """Choose the folder."""
        super().initialize_options()
        self.build_base = tempfile.mkdtemp(prefix="scanrack-build-")
        atexit.register(shutil.rmtree, self.build_base, ignore_errors=True)


setup(packages=packages(), package_dir=FOLDERS, cmdclass={"build": FreshBuild})
