"""Shared parts of export formats: outlines, programs, trees of bodies."""
