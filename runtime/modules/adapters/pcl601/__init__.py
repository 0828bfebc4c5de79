"""A PCL601 under the 3601's command layer: its link, its axis, what it can and can't do."""
