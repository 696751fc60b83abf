"""Films: frames read one by one, and things found in them."""
