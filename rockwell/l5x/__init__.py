r"""L5X: program exports of Studio 5000 and RSLogix 5000.

    XML -> document -> datatypes, values -> scopes, modules, addons, routines, schedule -> Controller
                                                      \-> report: what is refused, and where

| file | content |
|---|---|
| `limits` | limits of a document |
| `records` | the parts of a document: plain records with their lines |
| `document` | XML to records; refuses hostile input |
| `report` | what was imported, declared, refused |
| `datatypes` | data types, string families, packed BIT members, predefined and module-defined types |
| `values` | decorated data and L5K text to initial values |
| `addons` | add-on instructions |
| `routines` | rungs and structured text |
| `diagrams` | function block diagrams to structured text |
| `names` | tags by name, before they are declared |
| `presets` | PRE and ACC in rungs |
| `scopes` | tags and aliases of the controller and of programs |
| `modules` | modules to tags |
| `uses` | calls and instructions of routines |
| `unknown` | undefined types |
| `mnemonics` | names of all Logix instructions, including those that scanrack lacks |
| `schedule` | tasks |
| `assembly` | assembles the parts into a `Controller` |
| `completing` | declarations missing in a partial export |
| `widening` | members that the types of the file lack |
| `building` | builds the controller, and refuses rungs that can't be built |
| `importer` | imports one document: runs all of these steps |
| `unread` | notes on content that scanrack does not read |
| `spans` | positions of elements in the text, so that an edit replaces only those bytes |
| `rewriting` | edited rungs in the text of a file |
| `partial` | extracts a program or a routine from a file |
| `export`, `writing` | exports a program as an L5X |
| `trial` | runs the interpreted and the compiled controller in lockstep |
"""

from .importer import L5xImport, import_l5x
from .report import Refusal, Report
from .xml.parsing import L5xError

__all__ = ["L5xError", "L5xImport", "Refusal", "Report", "import_l5x"]
