"""Hand edits: what a person overrules, in which order, kept safe on disk, and what the map becomes by them."""
