"""What the instruments record, and the files that are written."""
