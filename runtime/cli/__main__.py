"""`python -m scanrack.runtime.cli`, the same as the `scanrack` command."""

from . import main

main()
