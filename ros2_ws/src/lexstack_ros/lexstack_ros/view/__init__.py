"""The live page: a browser looks at the running robots and asks for what any user may ask."""
