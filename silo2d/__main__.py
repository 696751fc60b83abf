"""python -m silo2d: the same as the command silo2d."""

from silo2d.commands.main import main

if __name__ == "__main__":
    main()
