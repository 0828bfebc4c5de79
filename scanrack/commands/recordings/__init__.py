"""Commands for recordings: show, query, compare, export, plot, repair, replay, rerun."""
