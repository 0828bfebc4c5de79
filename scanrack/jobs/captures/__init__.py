"""Recordings of real controllers: captures of a network and logs of frames become traces."""
