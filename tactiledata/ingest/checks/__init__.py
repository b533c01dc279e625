"""What is remarked about a recording."""
