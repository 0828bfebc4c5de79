"""The simulated CQPUSI PMC006x3s: a controller on a serial line, with its pins and its motor."""
