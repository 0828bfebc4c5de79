"""Compares two versions of an export, for review.

| file | content |
|---|---|
| `outline` | an export as items with fields, sequences and inner items |
| `pruning`, `l5x` | an L5X as an outline with all attributes and texts that the versions do not share |
| `slc` | the text of RSLogix 500 as an outline |
| `alignment` | two sequences side by side in nearly linear time |
| `renames` | tags with a new name, by their uses |
| `comparison` | the differences of two outlines |
| `opening` | detects the format and compares two files |
| `page`, `page_style`, `rung_pictures` | the comparison as one HTML file |
| `pairing` | pairs unchanged, moved and changed rungs and lines |

The versions need not be runnable. Parts that an import refuses are also compared.
"""

from .comparison import Comparison, Difference
from .opening import compare_exports, text_of_export
from .page import page_of

__all__ = ["Comparison", "Difference", "compare_exports", "page_of", "text_of_export"]
