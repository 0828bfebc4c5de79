"""Execution of stored programs."""

from __future__ import annotations

from .loading import load, read_program
from .machine import INSTRUCTION_NS, ProgramMachine

__all__ = ["INSTRUCTION_NS", "ProgramMachine", "load", "read_program"]
