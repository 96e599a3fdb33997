"""Bars, joints, sliders, clearances, drives, loads: frozen data that contributes terms."""
