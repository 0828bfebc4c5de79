"""The benches of `scanrack drive`: one module or controller in virtual time, with JSON in and out."""
