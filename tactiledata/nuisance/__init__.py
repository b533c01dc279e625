"""What every fit must allow for before it speaks of physics: noise, the sensor's zero, where the contact begins."""
