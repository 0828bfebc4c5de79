"""The benches of `scanrack drive`, each for a module or controller in virtual time, with JSON requests."""
