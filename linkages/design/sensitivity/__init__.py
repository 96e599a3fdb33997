"""How outputs and measures change with numbers of a definition: exact derivatives."""
