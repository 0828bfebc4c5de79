"""The benches of `scanrack drive`: a module or controller in virtual time, with JSON requests and replies."""
