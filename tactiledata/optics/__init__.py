"""From the deformed gel to a picture without learned models: height maps, camera registration, Taxim's table."""
