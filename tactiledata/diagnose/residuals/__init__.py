"""What is left after a simulation, and the statistics on whole trajectories that it is asked with."""
