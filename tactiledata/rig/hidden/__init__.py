"""Effects that only the rig knows."""
