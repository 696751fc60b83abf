"""Steps that several threads share."""
