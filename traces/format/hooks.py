"""Functions in modules that depend on the reader; they implement methods of a trace.

`scanrack.traces` sets them, so that the reader does not import these modules.
"""

from collections.abc import Callable, Sequence
from typing import Any

to_pandas: Callable[[Any, Sequence[str]], Any]
to_polars: Callable[[Any, Sequence[str]], Any]
read_columns: Callable[[Any], Any]
short_text: Callable[[Any], str]
as_html: Callable[[Any], str]
