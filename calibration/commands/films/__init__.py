"""Commands that measure films and pictures."""
