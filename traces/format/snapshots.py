"""The attachment with snapshots of a program's values."""

from __future__ import annotations

SNAPSHOTS = "snapshots.txt.zst"
"""Name of the attachment. It is zstd of lines, each with a scan number and the values before it in JSON."""

SNAPSHOTS_BYTES = 16 * 1024 * 1024
"""Maximum text of a recording's snapshots."""
