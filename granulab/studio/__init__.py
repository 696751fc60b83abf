"""The studio: cases built, run and watched in a browser on this machine; the command `granulab`."""
