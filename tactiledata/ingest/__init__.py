"""From a raw log to a store: clocks, contact wrench, trajectories, aligned values, checks."""
