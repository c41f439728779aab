"""The command line: the only folder that prints. Each command is a file, loaded when it is called.

Nobody imports it.
"""
