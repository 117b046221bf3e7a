"""CasADi Functions -> a Python module that needs NumPy alone: one assignment an operation."""

from collections.abc import Mapping, Sequence

import casadi as ca

_BINARY = {"ADD": "{0} + {1}", "SUB": "{0} - {1}", "MUL": "{0}*{1}", "DIV": "{0}/{1}", "POW": "{0}**{1}", "CONSTPOW": "{0}**{1}",
           "LT": "1.0*({0} < {1})", "LE": "1.0*({0} <= {1})", "EQ": "1.0*({0} == {1})", "NE": "1.0*({0} != {1})",
           "AND": "1.0*(({0} != 0) & ({1} != 0))", "OR": "1.0*(({0} != 0) | ({1} != 0))", "FMIN": "np.minimum({0}, {1})",
           "FMAX": "np.maximum({0}, {1})", "ATAN2": "np.arctan2({0}, {1})", "FMOD": "np.fmod({0}, {1})",
           "COPYSIGN": "np.copysign({0}, {1})", "IF_ELSE_ZERO": "np.where({0} != 0, {1}, 0.0)", "HYPOT": "np.hypot({0}, {1})"}
_UNARY = {"ASSIGN": "{0}", "NEG": "-{0}", "SQ": "{0}*{0}", "TWICE": "2.0*{0}", "INV": "1.0/{0}", "NOT": "1.0*({0} == 0)",
          **{op: f"np.{name}({{0}})" for op, name in (
              ("SQRT", "sqrt"), ("SIN", "sin"), ("COS", "cos"), ("TAN", "tan"), ("ASIN", "arcsin"), ("ACOS", "arccos"),
              ("ATAN", "arctan"), ("SINH", "sinh"), ("COSH", "cosh"), ("TANH", "tanh"), ("ASINH", "arcsinh"),
              ("ACOSH", "arccosh"),
              ("ATANH", "arctanh"), ("EXP", "exp"), ("LOG", "log"), ("FABS", "abs"), ("SIGN", "sign"), ("FLOOR", "floor"),
              ("CEIL", "ceil"))}}
_TEXT: Mapping[int, str] = {getattr(ca, f"OP_{name}"): text for name, text in (_BINARY | _UNARY).items()}


def statements(function: ca.Function, arguments: Sequence[str]) -> tuple[list[str], list[list[str]]]:
    """Assignments w0 = ..., and the entries of each output (column by column, zeros in their places) as names or numbers.

    `arguments` are formats of the inputs' entries: "q[{}]". Raises NotImplementedError for an operation without a NumPy name.
    """
    lines: list[str] = []
    work = [""] * max(1, function.sz_w())
    found = [["0.0"] * function.numel_out(i) for i in range(function.n_out())]
    for k in range(function.n_instructions()):
        op, read, write = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_INPUT:
            work[write[0]] = arguments[read[0]].format(read[1])
        elif op == ca.OP_CONST:
            value = function.instruction_constant(k)
            work[write[0]] = f"({value!r})" if value < 0 else repr(value)
        elif op == ca.OP_OUTPUT:
            rows, columns = function.sparsity_out(write[0]).get_triplet()
            place = rows[write[1]] + columns[write[1]] * function.size1_out(write[0])
            found[write[0]][place] = work[read[0]]
        elif op in _TEXT:
            lines.append(f"w{len(lines)} = {_TEXT[op].format(*(work[place] for place in read))}")
            work[write[0]] = f"w{len(lines) - 1}"
        else:
            raise NotImplementedError(f"the operation {op} of CasADi in '{function.name()}'")
    return lines, found


def write_function(name: str, function: ca.Function, arguments: Mapping[str, str], doc: str,
                   shape: tuple[int, int] | None) -> str:
    """A Python function of the arguments: a vector, or with `shape` a matrix."""
    lines, (entries,) = statements(function, list(arguments.values()))
    body = "".join(f"    {line}\n" for line in lines)
    if shape is None:
        result = f"np.array([{', '.join(entries)}], dtype=float)"
    else:
        rows = [f"[{', '.join(entries[i + j * shape[0]] for j in range(shape[1]))}]" for i in range(shape[0])]
        result = f"np.array([{', '.join(rows)}], dtype=float).reshape({shape[0]}, {shape[1]})"
    return f"def {name}({', '.join(arguments)}):\n    \"\"\"{doc}\"\"\"\n{body}    return {result}\n"
