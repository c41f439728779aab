"""Version of rocs_bt, in a module without imports so that every module can write it into files."""

__version__ = "0.1.0"
