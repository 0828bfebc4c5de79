"""`--server`: processes that serve the tags of a run to HMIs, SCADA and scripts."""
