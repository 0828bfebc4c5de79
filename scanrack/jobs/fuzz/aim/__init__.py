"""The search aims: parts at random, near what changes in a run."""
