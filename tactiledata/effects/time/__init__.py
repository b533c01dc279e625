"""Effects of time on the contact force."""
