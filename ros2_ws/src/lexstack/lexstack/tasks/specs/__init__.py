"""What a program asks for: tasks as it writes them, and stacks of them as values.

A task here has the fields of its section in a stack file, and belongs to no robot yet;
``compiled`` makes of a stack what one team solves.
"""
