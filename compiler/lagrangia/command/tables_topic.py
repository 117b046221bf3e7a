"""The text of `lag help tables`."""

TABLES = """\
    Frame road = shift(world, {0, table(time, "road.csv", column = "z", smoothness = "cubic", beyond = "linear")});
    AppliedForce P(at = hub.center, force = {table(v*time, "profile.csv"), 0});
    Real torque = table(time/1[s], {0, 1, 3}, {0, 5, 0}, smoothness = "monotone", beyond = "periodic");

The first argument is looked up in the first column of the file, which rises; the file stands where the .lag file that names it
does. A column is named, or numbered from 1, and may be left out where there are two. Literal points take the same options.

table2(x, y, {x1, x2}, {y1, y2, y3}, {{z11, z12, z13}, {z21, z22, z23}})   in two variables: a row for each x, straight along both
in each cell, held beyond the ends, up to 1000 points; its kinks are events. Not supported yet: smooth.
table2(x, y, "map.csv", column = "z")   from a file: x and y in its first two columns, a row for each x with each y, in any order.

smoothness   "linear"    straight lines, the default; their corners are met exactly, as events
             "cubic"     the spline with two continuous derivatives ("not a knot" at its ends): what moves a support, whose
                         velocity and acceleration are those of the spline
             "monotone"  cubic pieces that do not overshoot (Fritsch, Butland, 1984), with one continuous derivative
             "steps"     each value holds until the next row
beyond       "hold"      the last value, the default. A support that is moved by a spline is stopped there: its rate jumps
             "linear"    goes on with the slope at the end;  "periodic": comes again (the last row is the first one);
             "error"     a run that gets there ends with exit code 1

Files        .csv: commas, semicolons, tabs or spaces; decimal commas where commas separate nothing; with a line of names or
             without; lines that begin with # or % are remarks. A unit may stand behind a name, as in z [mm]: values are taken to
             SI units, and dimensions are checked. .parquet is read by pyarrow, .mat (up to version 7) by SciPy.

-u road.y=road.csv         of lag simulate and sweep gives an input of a scene the column of its name, or the second of two,
                           over the first one: straight lines, held beyond the ends. Each input may have a file of its own.
-u road.y=road.csv:cubic   of an input that moves places: a spline; or :monotone, :steps (see lag help signals)

Of a + b*time with parameters a and b every knot is a time event, between which the table is a polynomial: exact for all solvers,
in any step, however many rows there are. Of anything else (a coordinate) the pieces are written out with their conditions: up to
2000 points. FMUs have their tables in them. Results never take the place of a table that is read. Exports to python write tables
of at most 64 points out; equations on paper those of a few.
"""
