"""Effects of what the gel is made of."""
