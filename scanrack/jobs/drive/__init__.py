"""The benches of `scanrack drive`: one module or controller, JSON in, JSON out, in virtual time."""
