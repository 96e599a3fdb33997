"""How the loops are compiled, how they reach memory, and how they call kernels.

Compiled functions here take numbers only: memory and kernels are addresses. Arrays as arguments
would each travel as seven words with a reference count, and cost more than a Runge–Kutta stage.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, get_args, get_type_hints

import numba
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from linkages.kernel.code.cache import cache_folder, digest_of
from linkages.solvers.steps.loaded import version

# Numba's annotations leave out some of its options.
njit: Any = numba.njit
config: Any = numba.config

NATIVE = {int: types.int64, float: types.float64, bool: types.boolean, type(None): types.void}
LLVM = {types.int64: "i64", types.float64: "double"}


# Contraction to fused multiply-adds leaves the order of operations alone, so that equal inputs
# give equal bits and compensated sums survive.
OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract"},
    "no_cfunc_wrapper": True,
}


def compiled(function: Callable, **options: Any) -> Callable:
    """Compile a function with the signature that its annotations state.

    It is compiled, or its machine code loaded, when the first that calls it is compiled. Python
    calls it through `linkages.solvers.steps.loaded`.
    """
    with _own_cache():
        dispatcher = njit(no_cpython_wrapper=True, **options, **OPTIONS)(function)
    find = dispatcher.get_call_template

    def compile_first(*arguments: Any) -> Any:
        if not dispatcher.overloads:
            dispatcher.compile(_signature(function))
            dispatcher.disable_compile()
        return find(*arguments)

    dispatcher.get_call_template = compile_first
    return dispatcher


def inlined(function: Callable) -> Callable:
    """Compile a function into those that call it: a call would pass each word of its tuples."""
    return compiled(function, forceinline=True)


def exported(function: Any) -> str:
    """A compiled function in LLVM's assembly language, with one of C that calls it.

    Of the same name; it takes as many integers in place of a named tuple.
    """
    python = function.py_func
    options = {**OPTIONS, "cache": False}  # what comes from the cache has no text
    dispatcher = njit(no_cpython_wrapper=True, **options)(python)
    signature = _signature(python)
    dispatcher.compile(signature)
    (found,) = dispatcher.overloads.values()
    kinds = [LLVM[part] for kind in signature.args for part in getattr(kind, "types", [kind])]
    result = LLVM[signature.return_type]
    arguments = [f"{kind} %{place}" for place, kind in enumerate(kinds)]
    given = ", ".join(["ptr %result", "ptr %error", *arguments])
    return f"""{found.library.get_llvm_str()}
define {result} @{python.__name__}({", ".join(arguments)}) {{
  %result = alloca {result}
  %error = alloca ptr
  %status = call i32 @"{found.fndesc.mangled_name}"({given})
  %found = load {result}, ptr %result
  ret {result} %found
}}
"""


@contextmanager
def _own_cache() -> Iterator[None]:
    """Keep machine code in the user's private folder while a function is decorated."""
    before = config.CACHE_DIR
    config.CACHE_DIR = str(cache_folder() / f"solvers-{digest_of(version())}")
    try:
        yield
    finally:
        config.CACHE_DIR = before


def _signature(function: Callable) -> Any:
    hints = get_type_hints(function)
    result = _native(hints.pop("return"))
    return result(*[_native(hint) for hint in hints.values()])


def _native(hint: Any) -> Any:
    """Numba type of an annotation: a number, a pair of floats, or a named tuple of integers."""
    if hasattr(hint, "_fields"):
        return types.NamedUniTuple(types.int64, len(hint._fields), hint)
    if get_args(hint):
        return types.Tuple([NATIVE[part] for part in get_args(hint)])
    return NATIVE[hint]


def _pointer_to(element: Any) -> Any:
    """Make the function that takes an address as a pointer, to be indexed in compiled code."""
    pointer = types.CPointer(element)

    def cast(_context: Any, address: Any) -> Any:
        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], context.get_value_type(pointer))

        return pointer(address), generate

    return intrinsic(cast)


def tuple_at(named: Any) -> Any:
    """Make the function that reads a named tuple of integers at an address."""
    words = _native(named)

    def read(_context: Any, address: Any) -> Any:
        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            pointer = context.get_value_type(words).as_pointer()
            return builder.load(builder.inttoptr(arguments[0], pointer))

        return words(address), generate

    return intrinsic(read)


def _generate_call(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    address, *rest = arguments
    result = context.get_value_type(signature.return_type)
    function = ir.FunctionType(result, [argument.type for argument in rest])
    return builder.call(builder.inttoptr(address, function.as_pointer()), rest)


# A call through an address costs about 1 ns and, unlike a call of a Numba function object, needs
# no compilation of the calling loop for each kernel.
def _rates(_context: Any, address: Any, state: Any, parameters: Any, timed: Any, out: Any) -> Any:
    return types.int64(address, state, parameters, timed, out), _generate_call


def _clock(_context: Any, address: Any, time: Any, parameters: Any, timed: Any) -> Any:
    return types.int64(address, time, parameters, timed), _generate_call


def _hook(_context: Any, address: Any, context: Any, t: Any, h: Any, t_end: Any) -> Any:
    return types.float64(address, context, t, h, t_end), _generate_call


def _step(_context: Any, address: Any, frame: Any) -> Any:
    return types.int64(address, frame), _generate_call


def _advance(_context: Any, address: Any, frame: Any, ticks: Any) -> Any:
    return types.int64(address, frame, ticks), _generate_call


def _fused(_context: Any, a: Any, b: Any, c: Any) -> Any:
    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(a, b, c), generate


floats: Any = _pointer_to(types.float64)
integers: Any = _pointer_to(types.int64)
call_rates: Any = intrinsic(_rates)
call_clock: Any = intrinsic(_clock)
call_hook: Any = intrinsic(_hook)
call_step: Any = intrinsic(_step)
call_advance: Any = intrinsic(_advance)
fused: Any = intrinsic(_fused)  # a·b + c with one rounding
