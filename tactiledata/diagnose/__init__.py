"""Where simulation and recordings differ, and in which form: statistics whose units are whole trajectories."""
