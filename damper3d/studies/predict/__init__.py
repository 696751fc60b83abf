"""What closed forms say of a damper before any simulation, and simulations set beside it."""
