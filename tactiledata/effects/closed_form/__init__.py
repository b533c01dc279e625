"""Contacts on a bonded layer in closed form."""
