"""Addresses of compiled callbacks: numba, ctypes, cffi, scipy."""

from __future__ import annotations

import contextlib
import ctypes
import dis
from collections.abc import Callable, Iterator
from typing import Any

# C types of the arguments of each callback; M, J and W come with their leading dimension.
_ARGUMENTS = {
    "mass": "double t, const double *q, double *M, int ldm, void *user",
    "force": "double t, const double *q, const double *v, double *F, void *user",
    "force_damping": "double t, const double *q, const double *v, double *D, int ldd, void *user",
    "force_stiffness": "double t, const double *q, const double *v, double *K, int ldk, void *user",
    "constraint": "double t, const double *q, double *phi, void *user",
    "constraint_jacobian": "double t, const double *q, double *J, int ldj, void *user",
    "constraint_bias": "double t, const double *q, const double *v, double *phi_t, double *omega, void *user",
    "gap": "double t, const double *q, double *g, void *user",
    "gap_normal": "double t, const double *q, double *W, int ldw, void *user",
    "gap_tangent": "double t, const double *q, double *W, int ldw, void *user",
    "contact_bias": "double t, const double *q, double *w_n, double *w_t, void *user",
    "contact_acceleration": "double t, const double *q, const double *v, double *omega_n, double *omega_t, "
                            "double *omega_s, void *user",
    "frictional_joint_tangent": "double t, const double *q, double *W, int ldw, double *w_s, void *user",
    "joint_friction_bound": "double t, const double *q, const double *v, double *bound, void *user",
    "kinematics": "double t, const double *q, const double *v, double *qdot, void *user",
    "potential": "double t, const double *q, double *energy, void *user",
    "contact_speed": "double t, const double *q, const double *v, double *speed, void *user",
    "mass_blocks": "double t, const double *q, double *M, void *user",
    "constraint_rows": "double t, const double *q, nsdae_row_list *rows, void *user",
    "joint_friction_rows": "double t, const double *q, nsdae_row_list *rows, double *w_s, void *user",
    "force_damping_blocks": "double t, const double *q, const double *v, nsdae_block_list *blocks, void *user",
    "force_stiffness_blocks": "double t, const double *q, const double *v, nsdae_block_list *blocks, void *user",
    "contacts": "double t, const double *q, const double *v, double reach, nsdae_contact_list *list, void *user",
    "drive": "double t, double *drive, void *user",
    "load": "double t, const double *position, const double *velocity, double *force, double *torque, void *user",
}


def rebound(name: str, function: Any) -> str | None:
    """The array that the function should fill and assigns to instead, as by F = np.array(...): its values are lost.

    In-place operations such as F += 1 write into the array.
    """
    method = getattr(function, "__self__", None) is not None
    code = getattr(getattr(function, "__func__", function), "__code__", None)
    if code is None:
        return None
    arguments = [a.strip() for a in _ARGUMENTS[name].split(",") if not a.strip().startswith(("int ", "void "))]
    given = code.co_varnames[method : code.co_argcount]
    filled = {of for of, kind in zip(given, arguments) if kind.startswith("double *")}
    in_place = False
    for step in dis.get_instructions(code):
        stored = step.argval if isinstance(step.argval, tuple) else (step.argval,)
        if step.opname.startswith("STORE_FAST") and not in_place and stored[0] in filled:
            return str(stored[0])
        in_place = step.opname.startswith("INPLACE_") or step.opname == "BINARY_OP" and step.argrepr.endswith("=")
    return None


def _kind(argument: str) -> str:
    return "pointer" if "void" in argument or "_list" in argument else "array" if "*" in argument else argument.split()[0]


def _kinds(name: str) -> list[str]:
    if name not in _ARGUMENTS:
        raise ValueError(f"no callback is called '{name}': they are {', '.join(_ARGUMENTS)}")
    return [_kind(argument) for argument in _ARGUMENTS[name].split(", ")]


def signature(name: str, kind: str = "numba") -> Any:
    """Returns the signature of a compiled callback.

    Parameters
    ----------
    name : str
        Name of the callback.
    kind : str
        "numba": text for ``numba.cfunc``. "ctypes": the function type. "c": the C declaration, for cffi.

    Returns
    -------
    str or type

    Raises
    ------
    ValueError
        The name or the kind is unknown.

    Examples
    --------
    >>> @numba.cfunc(nsdae.signature("force"))
    ... def force(t, q, v, F, user):
    ...     F[0] = -0.981
    ...     return 0
    """
    kinds = _kinds(name)
    if kind == "numba":
        types = {"double": "float64", "int": "int32", "array": "CPointer(float64)", "pointer": "voidptr"}
        return f"int32({', '.join(types[k] for k in kinds)})"
    if kind == "ctypes":
        of = {"double": ctypes.c_double, "int": ctypes.c_int, "array": ctypes.POINTER(ctypes.c_double),
              "pointer": ctypes.c_void_p}
        return ctypes.CFUNCTYPE(ctypes.c_int, *(of[k] for k in kinds))
    if kind == "c":
        return f"int {name}({_ARGUMENTS[name]})"
    raise ValueError(f"kind is '{kind}'; it must be 'numba', 'ctypes' or 'c'")


@contextlib.contextmanager
def _inlined() -> Iterator[None]:
    """Allows LLVM to inline the compiled function.

    ``numba.cfunc`` returns a function that calls the compiled one with the attribute noinline. The call takes 4 ns, as long as a
    callback of a small mechanism. The attribute is omitted here, if numba has the expected structure.
    """
    try:
        from numba.core import compiler_lock, registry
        conventions, lock = type(registry.cpu_target.target_context.call_conv), compiler_lock.global_compiler_lock
        call_function = conventions.call_function
    except (ImportError, AttributeError):
        yield
        return

    def inlined(self: Any, *arguments: Any, attrs: Any = None, **others: Any) -> Any:
        return call_function(self, *arguments, **others)

    with lock:
        conventions.call_function = inlined
        try:
            yield
        finally:
            conventions.call_function = call_function


def cfunc(name: str, **options: Any) -> Callable[[Callable], Any]:
    """Decorator for a compiled callback: ``numba.cfunc`` with its signature, as fast as C.

    Parameters
    ----------
    name : str
        Name of the callback.
    **options
        Options of ``numba.cfunc``, such as ``fastmath`` or ``boundscheck``.

    Returns
    -------
    callable
        The decorator.

    Examples
    --------
    >>> @nsdae.cfunc("force")
    ... def force(t, q, v, F, user):
    ...     F[0] = -0.981
    ...     return 0
    """
    wanted = signature(name)

    def compiled_by_numba(function: Callable) -> Any:
        import numba
        with _inlined():
            return numba.cfunc(wanted, **options)(function)

    return compiled_by_numba


def _of_numba(name: str, function: Any) -> int:
    """Returns the address; a wrong signature raises TypeError here instead of a crash later."""
    has = getattr(function, "_sig", None)
    if has is not None:
        from numba.core import sigutils  # installed, since the function is from numba
        arguments, result = sigutils.normalize_signature(signature(name))
        if tuple(has.args) != tuple(arguments) or has.return_type != result:
            raise TypeError(f"{name} is a numba.cfunc of the signature {has}; it must be '{signature(name)}', which "
                            f"nsdae.signature('{name}') returns")
    return function.address


def _capsule(capsule: Any) -> int:
    api = ctypes.pythonapi
    api.PyCapsule_GetName.restype, api.PyCapsule_GetName.argtypes = ctypes.c_char_p, [ctypes.py_object]
    api.PyCapsule_GetPointer.restype = ctypes.c_void_p
    api.PyCapsule_GetPointer.argtypes = [ctypes.py_object, ctypes.c_char_p]
    return api.PyCapsule_GetPointer(capsule, api.PyCapsule_GetName(capsule))


def _of_cffi(pointer: Any) -> int:
    import cffi  # installed, since the pointer is from cffi
    return int(cffi.FFI().cast("uintptr_t", pointer))


def address(thing: Any) -> int:
    """Returns the address of ``user``: None, a number, an array, a pointer of ctypes or cffi, a capsule."""
    if thing is None:
        return 0
    if isinstance(thing, int):
        return thing
    if hasattr(thing, "ctypes") and hasattr(thing.ctypes, "data"):  # an array of NumPy
        return thing.ctypes.data
    if type(thing).__name__ == "PyCapsule":
        return _capsule(thing)
    if type(thing).__module__ == "_cffi_backend":
        return _of_cffi(thing)
    if isinstance(thing, ctypes.c_void_p):
        return thing.value or 0
    if isinstance(thing, (ctypes._Pointer, ctypes._SimpleCData, ctypes.Structure, ctypes.Array)):
        pointer = isinstance(thing, ctypes._Pointer)
        return ctypes.cast(thing, ctypes.c_void_p).value if pointer else ctypes.addressof(thing)
    raise TypeError(f"user is a {type(thing).__name__}; it must be an array, a number, or a pointer of ctypes or cffi")


def compiled(name: str, function: Any, user: Any) -> tuple[int, int] | None:
    """Returns (address, user) of a compiled callback, None for a function of Python."""
    if hasattr(function, "address") and hasattr(function, "native_name"):
        return _of_numba(name, function), address(user)
    if isinstance(function, tuple) and type(function).__name__ == "LowLevelCallable":
        own = function.user_data
        return _capsule(tuple.__getitem__(function, 0)), address(user if own is None else own)
    if isinstance(function, ctypes._CFuncPtr):
        return ctypes.cast(function, ctypes.c_void_p).value or 0, address(user)
    if type(function).__module__ == "_cffi_backend" and not isinstance(function, type):
        return _of_cffi(function), address(user)
    if callable(function):
        return None
    raise TypeError(f"{name} is a {type(function).__name__}; it must be a function, a numba.cfunc, a function pointer of "
                    "ctypes or cffi, or a scipy.LowLevelCallable")
