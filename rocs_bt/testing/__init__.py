"""For tests of missions, rules and robots: a pytest plugin, which pip installs with the package.

Tests import it; the engine does not.
"""
