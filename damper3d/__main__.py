"""python -m damper3d: the same as the command damper3d."""

from damper3d.commands.main import main

if __name__ == "__main__":
    main()
