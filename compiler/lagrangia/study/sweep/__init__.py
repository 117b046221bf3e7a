"""Many runs of one scene: what is varied, how runs are shared out among threads and machines, what is kept of each.

Here belongs: values, plan, pieces, threads, a Dask cluster, the journal of a sweep that may be killed, the table of results.
Not here: what one run is (room run), the command's words (command/sweep.py).
"""
