"""Studio: one page for a run that is over, one that goes on, and one that is written; the core does not import it."""
