"""Explicit steps in LLVM's assembly language, for one state or several lanes."""
