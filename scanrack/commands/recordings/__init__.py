"""Commands for traces: show, query, plot, compare, replay, export, import, repair."""
