"""Leaves that every tree may use."""
