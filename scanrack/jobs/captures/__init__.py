"""Turns recordings of real controllers, network captures and frame logs, into traces."""
