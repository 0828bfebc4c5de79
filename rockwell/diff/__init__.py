"""Comparison of two versions of an export: what a reviewer asks for first.

| file | content |
|---|---|
| `outline` | an export as items with fields, sequences and inner items |
| `pruning`, `l5x` | an L5X as an outline, less what two versions have in common; every attribute and text is in it |
| `slc` | the text of RSLogix 500 as an outline |
| `alignment` | two sequences side by side in nearly linear time |
| `renames` | tags with a new name, by their uses |
| `comparison` | the differences of two outlines |
| `opening` | which of the two formats; two files to their comparison |
| `page`, `rung_pictures` | the comparison as one HTML file |

Neither version needs to run: refused parts are compared as well.
"""

from .comparison import Comparison, Difference
from .opening import compare_exports, text_of_export

__all__ = ["Comparison", "Difference", "compare_exports", "text_of_export"]
