"""What the parts of the house hand to each other: records, documents checked against ``schemas/``, provenance."""
