"""Results of analyses, for terminal, page and JSON document."""
