"""The text of `lag help fmu`."""

FMU = """\
lag export FILE --to fmu       writes an FMU: the scene with the same C run time and the same functions as `lag simulate`
lag fmu check X.fmu ...        looks for faults in any FMU, whoever made it; --seconds 20: each run is given up after that time
lag simulate X.fmu             runs any FMU, to compare; pip install "lagrangia[fmu]" brings FMPy, needed but for FMUs on tapes

Export. --fmi 2, 3 or both; --kind me,cs (Model Exchange, Co-Simulation; both in one archive); --platforms host, all, or names
of x86_64-linux (glibc 2.17), aarch64-linux, x86_64-windows, x86_64-darwin, aarch64-darwin; --no-sources; --outputs NAME,...;
--engine: what comes with the package for this machine, a library that runs the scene's tape and needs no C compiler (tape),
code compiled for the scene (native), or what costs less in a hundred runs (auto); both have the same digits. Other platforms,
or this one by its name, are compiled. The library reads the scene from the FMU's resources, whose folder importers tell; -p
NAME=VALUE other start values. A parameter that follows from others (m = 2*m0) is a calculatedParameter: it changes with them
and cannot be set; with a value for it (-p m=3) it is a parameter of its own. Vectors and matrices (p[3], inputs, outputs,
f.r, f.R, quaternions) are arrays in FMI 3, whose elements each tell what they depend on; those whose elements are in part set
and in part computed are scalars, as all are in FMI 2, and in FMI 3 with --no-arrays, for importers that know none (CasADi).
--info author=TEXT, version, copyright, license. Parameters are tunable, derivatives exact, states can be saved and
serialised. The source is inside, in extra/. Co-Simulation steps by the scene's own solver, as `lag simulate` does; linear
scenes are exact, at any tolerance, for inputs held over a step or, in FMI 2, with slopes. A component with an input and a
reported quantity (--outputs flange.s) is a terminal of FMI 3. Equal input gives equal bytes but for the date, which
SOURCE_DATE_EPOCH sets. From Python: model.export_fmu("x.fmu", fmi="both").

Check. What is written in the FMU is read with care and told with its place: FMPy's validation, and what no schema shows,
among it derivatives that point to another state (by name, unit, kind), start values out of their bounds, listed sources that
are not there, build descriptions for another version or model, states that are not continuous, flags in the spelling of the
other version, units that are empty or not defined, rows and dependencies of ModelStructure that point nowhere, terminals that
name nothing, archives with links, backslashes, ZIP64 or other ways to pack, binaries for another processor, of another name,
with libraries that are not inside or for a new glibc alone. Then its binary is run, in a process of its own: are the states
those that the description names, directional derivatives those of differences, is it the same after reset and from a saved
state. With a Lagrangia source inside, both kinds must move as the native run does, within 100 tolerances or 10 times what
errors grow to; others are only run. --no-run leaves that out: to run a binary is to trust it. Exit codes: 2 for what is
written wrong, 1 for what runs wrong, 0.

Any binary that is run here, by check and simulate, has its place for temporary files and its working folder in a folder that goes
with the run. Linux from 5.13 on (Landlock) keeps it and all that it starts from making, opening to write, moving or removing
files anywhere else but in shared memory (/dev/shm), from 6.2 on from cutting them short by name, from 6.12 on from sending
signals; what it reads, its home among it, and networks stay open. Elsewhere nothing keeps it.

Simulate. --kind me or cs (cs where there is one), --start, --stop, --interval, --at, --tolerance, -p (parameters), --initial
(start values), -u (inputs), --outputs, -o, --plot (outputs, or states), --plot-quantities, --stats mean what they mean for a
scene; what is not given is the FMU's own default experiment. Values may carry units: -p m=300[g]. Arrays are given whole, row
by row (-p 'M={{1, 2}, {3, 4}}', -u 'F={0, 5}') or by element (-p 'M[1,2]=3', a column F[2]), and have a column for each.
Model Exchange is integrated by the CVode of FMPy, Co-Simulation takes a step from row to row. Rows at the time of an event
show the state before it.
"""
