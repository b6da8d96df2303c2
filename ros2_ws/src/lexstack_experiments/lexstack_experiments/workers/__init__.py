"""Programs that run in a process of their own, under another Python or another source tree.

Peers that do not fit the packages of this project, and earlier versions of it, are measured so.
Each program is run by its path, so that its folder is the first on the path and nothing of this
package is imported: it may import ``serving`` beside it, numpy, and what it is there to measure.
"""
