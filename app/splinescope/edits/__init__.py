"""Hand edits: what is selected becomes a proposal, an entry in the journal, and a map that follows it."""
