"""Scripts of what the pages show and nobody should type; `python docs/make --list` lists them."""
