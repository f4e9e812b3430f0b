"""Scenes of the picture suite that Cycles renders too: make.py."""
