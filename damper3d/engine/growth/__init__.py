"""Growth: particles without overlap, from random positions, by going down the overlaps' energy."""
