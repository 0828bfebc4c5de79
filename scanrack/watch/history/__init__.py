"""Any scan of a session again: images, tags, power, events, lanes and the strip."""
