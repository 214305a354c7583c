"""The commands: what each `splinescope …` does, and how it prints."""
