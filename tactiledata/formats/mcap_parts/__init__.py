"""The parts of the MCAP format: records and salvage, message decoding, roles of topics, images, descriptions."""
