"""The words, pages and documents of a diagnosis."""
