"""Back ends: each turns a Graph into an Estimate. `back_end("direct")` makes one by name."""
