"""Reads and writes RSLogix 500 exports, which are the text of an SLC 500 or MicroLogix program.

    SOR BST XIC I:1.0/3 NXB XIC B3/17 BND TON T4:0 0.01 500 0 EOR

| file | content |
|---|---|
| `records` | slots, ladder files with rungs, data files |
| `lines`, `document` | lines, words and comments; lines to records |
| `addresses` | `N7:0`, `B3/17`, `N7:[N7:1]`, `#N7:0`, `T4:0/DN` to addresses of the tree, and back |
| `datavalues` | printed values |
| `datafiles` | data files to tags with their values |
| `rungs` | mnemonics and operands of a rung to the tree, and back |
| `importer` | a document to a program, and the report of its import |
| `export` | a program back to text |
| `rewriting` | edited rungs in the text of an export |
| `trial` | runs the program in the interpreter and compiled, in lockstep |

The program has the dialect `slc`, see `instructions.slc`.
"""

from .document import SlcError
from .export import export_text
from .importer import SlcImport, import_slc, import_text

__all__ = ["SlcError", "SlcImport", "export_text", "import_slc", "import_text"]
