"""Tables, tracks and signals as people, tools and instruments write them."""
