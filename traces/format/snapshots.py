"""The attachment with snapshots of a program's values."""

from __future__ import annotations

SNAPSHOTS = "snapshots.txt.zst"
"""Name of the attachment, zstd-compressed lines with a scan number and the values before it in JSON."""

SNAPSHOTS_BYTES = 16 * 1024 * 1024
"""Maximum bytes of the values in a recording's snapshots, before compression."""
