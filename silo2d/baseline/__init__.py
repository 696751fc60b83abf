"""The second engine: impulses by pymunk, for pouring, discharge and comparison."""
