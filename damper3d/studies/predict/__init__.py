"""Predictions of a damper by closed forms, and simulations compared with them."""
