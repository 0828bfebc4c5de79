"""Chains of causes beyond the rack's images: through its Python program, and into the racks beside it."""
