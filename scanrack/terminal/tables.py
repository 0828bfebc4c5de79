"""Tables of one-line texts that can come from files."""

from __future__ import annotations

from typing import Any

from rich.table import Table
from rich.text import Text

from .terminal import on_a_line


class Cells(Table):
    """A table of one-line texts, with control characters made visible."""

    def add_row(self, *cells: Any, **options: Any) -> None:
        """Add a row without parsing its texts for markup."""
        super().add_row(
            *(Text(on_a_line(cell)) if isinstance(cell, str) else cell for cell in cells), **options
        )
