"""Which frames and samples belong to which touch."""
