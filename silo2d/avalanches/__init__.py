"""Runs that go on after a clog: the arch is broken, the level kept, avalanche after avalanche."""
