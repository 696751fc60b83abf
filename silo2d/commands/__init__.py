"""The commands of silo2d; what a command needs is imported in it, so that --help is quick."""
