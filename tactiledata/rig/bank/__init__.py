"""Contacts that are solved once and used for many recordings."""
