"""Which touches to record next."""
