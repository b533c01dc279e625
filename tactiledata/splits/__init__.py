"""Who may learn from what: splits that never part a trajectory, and the audit that looks for leaks all the same."""
