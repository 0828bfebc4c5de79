"""The simulated CQPUSI PMC006x3s: a device on a serial line, with its pins and motor."""
