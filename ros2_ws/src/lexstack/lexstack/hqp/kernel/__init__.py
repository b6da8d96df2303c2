"""The hierarchy as one compiled kernel: ``solver`` calls ``exchange``, which has the method.

``values`` has the arrays, ``usable`` looks at a problem, ``lq`` factorises all levels at once,
``guess`` judges an active set. ``python -m lexstack.compiled`` compiles it, as the set-up does.
"""
