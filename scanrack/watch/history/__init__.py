"""Reconstruction of any scan of a session: images, tags, power, events, lanes and the strip."""
