"""The layer solver: a bonded elastic layer at finite strain."""
