"""Tables and figures of the documents, written from the results files in ``docs/results``."""
