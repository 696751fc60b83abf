"""The page that plays a damper's run: what it shows of particles, contacts and walls."""
