"""Creates new projects, and checks the installation."""

from .project import LOGICS, ProjectError, example_names, new_project

__all__ = ["LOGICS", "ProjectError", "example_names", "new_project"]
