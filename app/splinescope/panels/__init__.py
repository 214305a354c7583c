"""The widgets at the side of the page: one panel per file; panels ask, the session knows."""
