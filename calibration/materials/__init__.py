"""The contact-parameter file: values written into it, and where each of them came from."""
