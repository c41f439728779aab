"""Tools for tests of missions, rules and robots: a pytest plugin, which is installed with the package.

Tests import it; the engine does not.
"""
