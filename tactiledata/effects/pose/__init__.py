"""Effects that move the indenter against the gel."""
