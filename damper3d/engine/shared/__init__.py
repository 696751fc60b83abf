"""Steps that several threads share, and the forces that they hand to one another."""
