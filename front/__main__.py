"""`python -m scanrack`, the same as the `scanrack` command."""

from .runtime.cli import main

if __name__ == "__main__":
    main()
