"""The processes of `--server`, which serve the tags of a run to HMIs, SCADA systems and scripts."""
