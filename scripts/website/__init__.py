"""The site of documents: what `./scripts/docs` does beside mkdocs."""
