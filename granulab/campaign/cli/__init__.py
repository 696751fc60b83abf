"""Command lines: options, progress and words that all simulators share."""
