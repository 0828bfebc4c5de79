"""The first steps of a new project, and what this machine has for it."""

from .project import LOGICS, ProjectError, example_names, new_project

__all__ = ["LOGICS", "ProjectError", "example_names", "new_project"]
