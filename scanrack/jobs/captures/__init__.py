"""Converts recordings of real controllers (network captures and frame logs) to traces."""
