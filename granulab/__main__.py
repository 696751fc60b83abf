"""python -m granulab: the same as the command granulab."""

from granulab.studio.main import main

if __name__ == "__main__":
    main()
