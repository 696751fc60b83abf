"""Contact laws of more than one kind of sphere, with rolling resistance and cohesion."""
