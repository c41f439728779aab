"""Command line: the only package that prints. Each command is a module, loaded when the command is called.

No other package imports it.
"""
