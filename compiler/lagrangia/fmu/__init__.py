"""FMUs of both versions: exported from scenes, checked, run beside the native run.

Here belongs: variables, XML, C sources and binaries of an FMU; rules of the standard; the process in which a foreign FMU runs.
Not here: lagrangia.Model, which is handed in; the C of an FMU's interface (runtime/fmi).
"""
