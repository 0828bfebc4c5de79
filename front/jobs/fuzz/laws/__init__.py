"""What holds in every scan: invariants, the standard ones and those of users."""
