"""The commands of damper3d; what a command needs is imported in it, so that --help is quick."""
