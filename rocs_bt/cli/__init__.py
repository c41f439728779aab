"""The command line: the only room that prints. Each command is a file, loaded when it is called."""
