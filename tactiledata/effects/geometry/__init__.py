"""Effects of the shape of the pad."""
