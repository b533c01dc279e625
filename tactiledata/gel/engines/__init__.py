"""The finite-element engine, linear and at finite strain."""
