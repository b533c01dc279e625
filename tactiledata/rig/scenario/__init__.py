"""What a recorded world consists of."""
