"""LagModel and what it points to, as ctypes has them: field by field what runtime/model states."""

import ctypes as c
from collections.abc import Sequence
from typing import Any, Self

from lagrangia.base.table_data import TableData

Doubles = c.POINTER(c.c_double)
Ints = c.POINTER(c.c_int)


class TapeMirror(c.Structure):
    """LagTape of tape.h."""

    _fields_ = (
        ("n_instructions", c.c_int32),
        ("n_constants", c.c_int32),
        ("code", c.POINTER(c.c_int32)),
        ("constants", Doubles),
    )


class FunctionMirror(c.Structure):
    """LagFunction of model.h."""

    _fields_ = (
        ("n_in", c.c_int),
        ("n_out", c.c_int),
        ("in_size", Ints),
        ("out_size", Ints),
        ("n_work", c.c_size_t),
        ("code", c.c_void_p),
        ("tape", c.POINTER(TapeMirror)),
    )


class TableMirror(c.Structure):
    """LagTable of table.h."""

    _fields_ = (
        *((name, c.c_int) for name in ("n", "degree", "beyond")),
        ("start", c.c_double),
        ("pitch", c.c_double),
        *((name, Doubles) for name in ("x", "y", "slopes")),
    )

    @classmethod
    def of(cls, table: TableData) -> Self:
        """With the table's own numbers, which stay where they are."""
        return cls(table.n, table.degree, int(table.beyond), table.start, table.pitch,
                   *(_shared(values) if len(values) else None for values in (table.x, table.y, table.slopes)))


def mirrored(tables: Sequence[TableData]) -> Any:
    """An array of them."""
    return (TableMirror * len(tables))(*map(TableMirror.of, tables))


def _shared(values: Any) -> Any:
    return (c.c_double * len(values)).from_buffer(values)


_SIZES = (
    "n", "n_parameters", "n_hoisted", "n_inputs", "n_modes", "n_events", "n_outputs", "n_initial", "n_power",
    "n_holonomic", "n_multipliers", "n_initial_positions", "n_lost", "n_switches", "n_lengths", "n_whens", "n_loaded", "n_rubs",
    "n_resets", "n_rests", "n_roots", "n_looks", "n_hiding", "n_cones", "n_lookups", "n_pieces", "n_samplers", "n_held",
    "n_delays", "n_attitudes", "n_kept", "n_guards", "n_seen", "guards_need_acceleration", "breaks_rise",
)
FUNCTIONS = (
    "parameters", "hoist", "start", "initial", "momentum", "events", "modes", "rhs", "outputs", "energies", "place", "steer",
    "linear", "waves", "jacobian", "tangent", "velocity", "force", "residual", "regular", "nearest", "kick",
    "switches", "resets", "roots", "looks", "held_first", "samples", "lags", "delayed", "before", "guards", "loads",
    "requirements",
)


class ModelMirror(c.Structure):
    """LagModel of model.h."""

    _fields_ = (
        *((name, c.c_int) for name in _SIZES),
        ("coordinate_kind", Ints),
        ("fixed", Ints),
        ("initial_pattern", Ints),
        ("mass_blocks", Ints),
        ("event_kind", Ints),
        ("reset_places", Ints),
        ("on_level", Ints),
        ("loaded", Ints),
        ("order", Ints),
        ("rubs", Ints),
        ("rests", Ints),
        ("at_level", Ints),
        ("cones", Ints),
        ("lookups", Ints),
        ("pieces", Ints),
        ("samplers", Ints),
        ("held", Ints),
        ("stated", Ints),
        ("attitudes", Ints),
        ("kept", Ints),
        ("guard_kinds", Ints),
        ("tables", c.POINTER(TableMirror)),
        ("outputs_need_acceleration", c.c_int),
        ("switches_need_acceleration", c.c_int),
        ("linear_pattern", Ints),
        ("solver", c.c_int),
        *((name, c.c_int) for name in ("n_entries", "n_lower", "n_upper", "n_colours")),
        *((name, c.c_int) for name in ("rhs_cost", "jacobian_cost", "has_corners", "may_hide", "may_be_narrow", "loops_know_time",
                                           "carries_in_time", "conditions_may_hide", "shares_bend", "is_swing", "is_steady",
                                           "may_repeat", "is_separable", "jacobian_waits")),
        ("jacobian_pattern", Ints),
        ("n_islands", c.c_int),
        ("island", Ints),
        ("islands", c.c_void_p),
        *((name, FunctionMirror) for name in FUNCTIONS),
        *((name, c.c_int) for name in ("n_jets", "jet_pitch", "n_products", "n_weighed", "series_rhs_cost")),
        ("jet_places", Ints),
        ("is_long_state", c.c_int),
        ("series_may_hide", c.c_int),
        ("taylor", c.c_void_p),
        *((name, c.c_int) for name in ("n_jet_instructions", "n_jet_slots", "n_angles")),
        ("jet_code", Ints),
        ("jet_rates", Ints),
        ("series", FunctionMirror),
        ("wide", c.c_void_p),
        ("wide_whole", c.c_void_p),
        ("wide_each", c.c_void_p),
        ("wide_roots", c.c_void_p),
        ("wide_energies", c.c_void_p),
        ("wide_taylor", c.c_void_p),
    )
