"""A block on a plate, filmed: pose of the plate and of the block, first slip, slide."""
