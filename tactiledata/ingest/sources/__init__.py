"""Which recordings there are, and what became of them."""
