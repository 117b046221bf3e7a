"""The text of `lag help curves`."""

_CURVES = """\
lag simulate FILE --plot FILE.png (.svg, .pdf)     the coordinates over time, a panel a unit; further:

--plot-quantities NAME,...   any quantities instead; X:Y is Y against X: "bob.x:bob.y", "theta:theta'" (x' is der(x))
--spectrum NAME,...          amplitudes over frequency in Hz, in the quantity's unit: Fourier transform of the rows under Hann's
                             window, less the mean. A vibration A*cos(w*t) shows A (at least 0.85 A between two frequencies). The
                             rows must be at equal distances; faster vibration than one in two rows folds back: see --interval
--section NAME[=VALUE]       a Poincare section: the states in which NAME rises through 0, or the value (theta=30[deg]), found
                             between the rows by polynomials of order 5. Shown are the pairs of --plot-quantities, or the first
                             other coordinate and its rate. Crossings that the rows do not tell well are left out, and counted
--overlay FILE.csv           a measurement, or another run: a column `time` in s, others named as quantities are, in SI units or
                             as `theta [deg]` says; up to 400 rows as points. Several with several --overlay
--beside NAME=VALUE,...      another run with these parameters and start values in the picture: --beside k=2[kN/m],theta=5[deg];
                             k=1:5:1 several of them, FILE.csv those of a table that `lag sweep` wrote
--linear                     small motion about the equilibrium near the start beside it, dashed, from the same start and excited
                             as the run is

Impacts, switches and corners of inputs are marked along time axes: run.events in Python. There run.plot("theta:theta'", "bob.y",
path="p.svg", spectrum=["theta"], overlay=["measured.csv", other], linear=True) and run.plot(section=("theta", 0.5)) draw the
same; angles in rad. lag response FILE --plot shows magnitude and phase with the resonances.
"""


def curves_topic() -> str:
    """The options of pictures."""
    return _CURVES
